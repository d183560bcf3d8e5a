"""How figures look.

Colours of data are those of M. Okabe and K. Ito (2002), which colour-blind readers tell apart.
"""

from __future__ import annotations

import warnings
from collections.abc import Generator
from contextlib import contextmanager
from typing import Any

from plumbline.errors import printable

INK, MUTED, RULE, PAPER = "#1a1c1f", "#5b6168", "#d9dce0", "#fffffe"
"""Text, ticks, grid and ground; a page may put its own in their place."""

BLUE, ORANGE, SKY, GREEN = "#0072b2", "#d55e00", "#56b4e9", "#009e73"
YELLOW, PURPLE = "#f0e442", "#cc79a7"
SIZES, ERRORS = "Blues", "Oranges"
"""Scales of displacements and of their errors, light to dark."""


FULL, HALF = 9.2, 4.6
"""Widths of figures in inches."""

MANY = 2_000
"""From so many points on they are drawn as pixels, which keeps an SVG small."""

_MOST_LETTERS = 22
"""Chosen: longer names run into their neighbours."""
_LOOK: dict[str, Any] = {
    "axes.axisbelow": True,
    "axes.edgecolor": MUTED,
    "axes.facecolor": "none",
    "axes.grid": True,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.7,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlesize": 9,
    "figure.facecolor": PAPER,
    "font.size": 9,
    "grid.color": RULE,
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "lines.linewidth": 1.3,
    "svg.fonttype": "none",
    "svg.hashsalt": "plumbline",
    "text.color": INK,
    "text.parse_math": False,
    "xtick.color": MUTED,
    "xtick.labelcolor": INK,
    "ytick.color": MUTED,
    "ytick.labelcolor": INK,
}


@contextmanager
def drawing() -> Generator[None]:
    """Draw and save within this: the look is ours and not that of the user's matplotlibrc."""
    import matplotlib

    with matplotlib.rc_context(), warnings.catch_warnings():
        # A line's name in a script that the font lacks shows as boxes in PNG and well in SVG.
        warnings.filterwarnings("ignore", "Glyph", UserWarning)
        matplotlib.rcdefaults()
        params: Any = matplotlib.rcParams
        params.update(_LOOK)
        yield


def sheet(width: float, height: float) -> Any:
    """An empty figure of that size in inches."""
    from plumbline.report.figures.sheet import Sheet

    return Sheet(figsize=(width, height), layout="constrained")


def name(label: str) -> str:
    """A name from a file, fit for an axis."""
    text = printable(label)
    return text if len(text) <= _MOST_LETTERS else f"{text[: _MOST_LETTERS - 1]}…"

"""How figures look, and how they become PNG and SVG.

Colours of data are those of M. Okabe and K. Ito (2002), which colour-blind readers tell apart.
"""

from __future__ import annotations

import base64
import io
import warnings
from collections.abc import Generator
from contextlib import contextmanager
from typing import Any

from lxml import etree  # pyright: ignore[reportAttributeAccessIssue]

from plumbline._version import __version__
from plumbline.errors import printable
from plumbline.files import MARK

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

_SVG = "{http://www.w3.org/2000/svg}"
_LINK = "{http://www.w3.org/1999/xlink}href"
_DPI = 150
"""Chosen: a photo of a page's width stays sharp on a screen."""
_JPEG_QUALITY = 82
"""Chosen: artefacts cannot be seen at the shown size."""
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
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def name(label: str) -> str:
    """A name from a file, fit for an axis."""
    text = printable(label)
    return text if len(text) <= _MOST_LETTERS else f"{text[: _MOST_LETTERS - 1]}…"


def png_bytes(figure: Any) -> bytes:
    """The figure as PNG."""
    out = io.BytesIO()
    figure.savefig(out, format="png", dpi=_DPI, metadata={"Software": f"{MARK} {__version__}"})
    return out.getvalue()


def svg_tree(figure: Any) -> Any:
    """The figure as SVG, its photographs as JPEG, which is a tenth as large as PNG."""
    pictures = {
        f"picture{index}": picture
        for index, picture in enumerate(p for axes in figure.axes for p in axes.images)
    }
    pixels = {place: picture.get_array() for place, picture in pictures.items()}
    for place, picture in pictures.items():
        picture.set_gid(place)
        picture.set_data(pixels[place][:1, :1])  # no PNG is made of the whole
    out = io.BytesIO()
    creator = f"{MARK} {__version__}"
    figure.savefig(out, format="svg", dpi=_DPI, metadata={"Creator": creator, "Date": None})
    root = etree.fromstring(out.getvalue(), etree.XMLParser(huge_tree=True))
    for image in root.iter(f"{_SVG}image"):
        place = image.get("id", "")
        if place in pixels:
            pictures[place].set_data(pixels[place])
            image.set(_LINK, _jpeg_uri(pixels[place]))
            image.set("preserveAspectRatio", "none")
            image.set("style", "")
        else:
            image.set(_LINK, _fewer_colours(image.get(_LINK, "")))
    return root


def svg_bytes(figure: Any) -> bytes:
    """The figure as an SVG file."""
    return etree.tostring(svg_tree(figure), xml_declaration=True, encoding="utf-8") + b"\n"


def _fewer_colours(uri: str) -> str:
    """A drawing in a PNG with 64 colours, which it hardly needs, and a fifth of the bytes."""
    from PIL import Image

    out = io.BytesIO()
    with Image.open(io.BytesIO(base64.b64decode(uri.partition(",")[2]))) as image:
        image.quantize(64, method=Image.Quantize.FASTOCTREE).save(out, "PNG", optimize=True)
    return f"data:image/png;base64,{base64.b64encode(out.getvalue()).decode()}"


def _jpeg_uri(pixels: Any) -> str:
    from PIL import Image

    out = io.BytesIO()
    Image.fromarray(pixels).save(out, format="JPEG", quality=_JPEG_QUALITY, optimize=True)
    return f"data:image/jpeg;base64,{base64.b64encode(out.getvalue()).decode()}"

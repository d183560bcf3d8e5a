"""Snap the lines of a project: `plumbline snap` minus its parsing."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from plumbline.cli.tools.narration import named
from plumbline.wording import count, px

if TYPE_CHECKING:
    from rich.console import Console

    from plumbline.edges.snap import Snapped
    from plumbline.edges.trace import Traced
    from plumbline.observations import Observations

_KINDS = {"dark": "groove", "bright": "wire", "either": "edge of both signs"}


def snapped(parts: Sequence[Observations], photo: str | None, narration: Console) -> list[Snapped]:
    """Snap one lens's lines after the other's.

    Args:
        parts: What was picked, one a lens.
        photo: The photo that the user names; None for those beside the points.
        narration: Tells what goes on.

    Raises:
        PlumblineError: as `snap`; the sentence says which files and photos it is about.
    """
    from plumbline.edges.snap import snap

    results: list[Snapped] = []
    for part in parts:
        with named(part, len(parts)), narration.status("Snapping…"):
            results.append(snap(part, photo))
    return results


def described(result: Snapped) -> list[str]:
    """One sentence a line: what it was snapped to, or why it keeps its picks."""
    lines = result.observations.lines
    return [
        f"line {line.label}: {_one(traced)}"
        for line, traced in zip(lines, result.lines, strict=True)
    ]


def _one(traced: Traced) -> str:
    if not traced.found:
        return f"keeps its picks: {traced.refusal}"
    import numpy as np

    error = px(float(np.median(traced.errors_px)))
    return (
        f"{_KINDS.get(traced.kind or '', 'edge')} under {100 * traced.support:.0f} %, "
        f"{count(len(traced.points_px), 'sample')} to {error} each, the picks "
        f"{px(traced.distance_px)} away"
    )

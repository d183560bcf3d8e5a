"""Which line to pick next: the one that would lower the largest error of the correction most."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from math import hypot
from typing import TypeVar

import numpy as np

from plumbline.frame import Array
from plumbline.trust.assessment import Assessment
from plumbline.trust.displacement import errors_of, grid_px, motions
from plumbline.trust.linearised import linearise
from plumbline.wording import joined

_Key = TypeVar("_Key", bound=Hashable)

_POINTS = 9
"""Picks of the proposed line: chosen, as people pick."""
_INSET = 0.04
"""Share of the photo that it keeps from the edge: chosen."""
_THIRD = 1 / 3
"""The rule of LensFun's profile makers."""
_ALIKE = 0.01
"""Places within one percent are equally good: chosen."""
_WORTH = 0.9
"""Share of the error to quote that a further line must leave to be advised: chosen."""
_AT_EDGE = "near the {} edge"
_INSIDE = "a third of the way from the centre to the {}"


@dataclass(frozen=True, eq=False)
class NextLine:
    """A line worth picking.

    Attributes:
        place: Where, as in "near the top edge"; places that would do as well are named too.
        from_px: The largest standard error of the correction now.
        to_px: What it would be with nine picks along that line.
        points_px: These picks, shape (9, 2), for the best of the places.
    """

    place: str
    from_px: float
    to_px: float
    points_px: Array

    @property
    def words(self) -> str:
        """The line in words, with two places to pick it between."""
        (x0, y0), (x1, y1) = self.points_px[0], self.points_px[-1]
        way = "vertical" if x0 == x1 else "horizontal"
        return (
            f"one more {way} line {self.place}, for instance from ({x0:.0f}, {y0:.0f}) to "
            f"({x1:.0f}, {y1:.0f})"
        )


def worthwhile_line(trust: Assessment) -> tuple[NextLine, float] | None:
    """The best line where it would lower the error to quote by a tenth or more.

    Returns:
        The line, and the error to quote with it in pixels: what the model may miss stays.
    """
    sure, best = trust.quoted, next_line(trust)
    if sure is None or best is None:
        return None
    lower_px = hypot(sure.picks_px * best.to_px / best.from_px, sure.missed_px)
    return (best, lower_px) if lower_px < _WORTH * sure.worst_px else None


def next_line(trust: Assessment) -> NextLine | None:
    """The best of lines along the edges and a third of the way out.

    Returns:
        None where the model folds inside the photo, or before it reaches any of these lines.
    """
    lines = candidates(trust.lens.frame.size)
    found = lowered_to(trust, lines)
    now = trust.displacement
    if now is None or not found:
        return None
    best = min(found, key=lambda place: found[place])
    limit = (1 + _ALIKE) * found[best]
    sides = [side for (how, side), to in found.items() if how == best[0] and to <= limit]
    place = best[0].format(joined(sides, "or"))
    return NextLine(place, now.worst_px, found[best], lines[best])


def lowered_to(trust: Assessment, lines: Mapping[_Key, Array]) -> dict[_Key, float]:
    """What the largest standard error would be with more picks, for each of some lines.

    Args:
        trust: How far the fit can be trusted now.
        lines: Picks along each line in pixels of the lens's frame, shape (n, 2) each.

    Returns:
        Pixels; lines that the model folds before are left out.
    """
    moved = motions(trust.lens, trust.free, grid_px(trust.lens))
    if moved is None:
        return {}
    linear = trust.weighed
    seen = (linear.jacobian * linear.in_photo[:, None])[linear.kept]
    normal = seen.T @ seen
    found: dict[_Key, float] = {}
    for key, points_px in lines.items():
        more = linearise(
            trust.lens, [points_px], trust.free, np.ones(len(points_px), dtype=np.bool_), image=True
        )
        if np.all(np.isfinite(more.jacobian)):
            unit = np.asarray(np.linalg.pinv(normal + more.normal), dtype=np.float64)
            found[key] = trust.sigma_px * float(np.max(errors_of(moved, unit)))
    return found


def candidates(size: tuple[int, int]) -> dict[tuple[str, str], Array]:
    """Lines that one could pick, nine points each, shape (9, 2), by place and side."""
    right, bottom = size[0] - 1.0, size[1] - 1.0
    share = np.linspace(_INSET, 1 - _INSET, _POINTS)
    out: dict[tuple[str, str], Array] = {}
    for how, inset in ((_AT_EDGE, _INSET), (_INSIDE, (1 - _THIRD) / 2)):
        for side, at in (("top", inset), ("bottom", 1 - inset)):
            out[how, side] = _line(share * right, at * bottom)
        for side, at in (("left", inset), ("right", 1 - inset)):
            out[how, side] = _line(at * right, share * bottom)
    return out


def _line(x: Array | float, y: Array | float) -> Array:
    return np.stack(np.broadcast_arrays(np.asarray(x), np.asarray(y)), axis=1).astype(np.float64)

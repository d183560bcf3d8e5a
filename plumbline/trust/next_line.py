"""Which line to pick next: the one that would lower the largest error of the correction most."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plumbline.frame import Array
from plumbline.trust.assessment import Assessment
from plumbline.trust.displacement import errors_of, grid_px, motions
from plumbline.trust.linearised import linearise
from plumbline.wording import joined

_POINTS = 9
"""Picks of the proposed line: chosen, as people pick."""
_INSET = 0.04
"""Share of the photo that it keeps from the edge: chosen."""
_THIRD = 1 / 3
"""The rule of LensFun's profile makers."""
_ALIKE = 0.01
"""Places within one percent are equally good: chosen."""
_AT_EDGE = "near the {} edge"
_INSIDE = "a third of the way from the centre to the {}"


@dataclass(frozen=True)
class NextLine:
    """A line worth picking.

    Attributes:
        place: Where, as in "near the top edge"; places that would do as well are named too.
        from_px: The largest standard error of the correction now.
        to_px: What it would be with nine picks along that line.
    """

    place: str
    from_px: float
    to_px: float


def next_line(trust: Assessment) -> NextLine | None:
    """The best of lines along the edges and a third of the way out.

    Returns:
        None where the model folds inside the photo, or before it reaches any of these lines.
    """
    now = trust.displacement
    moved = motions(trust.lens, trust.free, grid_px(trust.lens))
    if now is None or moved is None:
        return None
    linear = trust.linearised
    seen = (linear.jacobian * linear.in_photo[:, None])[linear.kept]
    found: dict[tuple[str, str], float] = {}
    for place, points_px in candidates(trust.lens.frame.size).items():
        more = linearise(
            trust.lens, [points_px], trust.free, np.ones(len(points_px), dtype=np.bool_), image=True
        )
        if not np.all(np.isfinite(more.jacobian)):
            continue
        unit = np.asarray(np.linalg.pinv(seen.T @ seen + more.normal), dtype=np.float64)
        found[place] = trust.sigma_px * float(np.max(errors_of(moved, unit)))
    if not found:
        return None
    best = min(found, key=lambda place: found[place])
    limit = (1 + _ALIKE) * found[best]
    sides = [side for (how, side), to in found.items() if how == best[0] and to <= limit]
    return NextLine(best[0].format(joined(sides, "or")), now.worst_px, found[best])


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

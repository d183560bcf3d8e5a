"""Which edge is meant: curves through a strip, scored by what supports them and by the picks.

A curve is a parabola of offsets from the guide: at its start, in its middle, at its end.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from plumbline.edges.response import KINDS, Kind, answer, peaks, spread
from plumbline.edges.strip import Strip
from plumbline.frame import Array

_SCALE_PX = 1.3
"""Width of the derivative that edges are searched with: between a sharp photo's edge (0.6 px) and
a soft one's (2 px)."""

_SIGNIFICANT = 4.0
"""Times the spread of answers from which a peak is an edge: normal noise exceeds it once in
30,000 places, a strip has 64 rows of some 20."""

_LEAST_ANSWER = 2e-3
"""Change of linear light a pixel below which nothing counts: half a grey level of 255 at mid
grey, what rounding leaves."""

_TOLERANCE = (1.0, 0.8, 0.3)
"""What a peak counts at its own pixel, beside it, and two beside it."""

_LEVEL = 0.6
"""Slope over bend times width below which light is level: 1 at the shoulders of a step, at most
0.4 within half a pixel of a groove's middle."""

_PICKS = 0.15
"""Weight of the picks' mean squared distance in units of their scatter: an edge one and a half
times the scatter away loses a third of its support (chosen on rendered façades, where it told
parallel edges 4 px apart for picks with 2 px of scatter)."""

_PREFER_SIGNED = 0.2
"""By how much more a change of either sign must be supported than one of a single sign."""

_GRID = 19
"""Offsets tried at either end; with 2 px of scatter they are a pixel apart."""

_KEPT = 4
"""Best coarse curves of each kind that are refined, by score and again by support."""

SAME_PX = 2.0
"""Curves that are nowhere farther apart are one."""


_ALONG = np.linspace(0, 1, 17)
"""Places at which curves are compared."""


class Curve(NamedTuple):
    """Offsets from a guide in pixels, and what speaks for them.

    Attributes:
        start: At the guide's start.
        sag: In its middle, from the straight line between the ends.
        end: At its end.
        kind: What kind of edge it follows.
        support: Share of the curve with an edge of that kind under it, 0 to 1.
        score: Support less what the picks say against it.
    """

    start: float
    sag: float
    end: float
    kind: Kind
    support: float
    score: float

    def offset(self, share: Array) -> Array:
        """Offsets at shares 0 to 1 of the guide."""
        return self.start + (self.end - self.start) * share + 4 * self.sag * share * (1 - share)


class Wanted(NamedTuple):
    """What the picks ask for.

    Attributes:
        share: Where along the guide each pick is, 0 to 1.
        offset: How far across from the guide each is, pixels.
        scatter_px: Standard deviation of a pick across its line.
        reach_px: How far from the guide an edge may be.
        sag_px: How far the middle may be from the straight line between the ends.
    """

    share: Array
    offset: Array
    scatter_px: float
    reach_px: float
    sag_px: float


def curves(strip: Strip, share: Array, wanted: Wanted) -> list[Curve]:
    """Curves that edges support, the best first.

    Args:
        strip: Along the guide, one column a pixel.
        share: Where along the guide its rows are, 0 to 1.
        wanted: What the picks ask for.
    """
    found: list[Curve] = []
    for kind in KINDS:
        evidence, first = _evidence(strip, kind)
        if evidence.any():
            found += _of_kind(evidence, first, kind, share, wanted)
    found.sort(key=lambda curve: -curve.score)
    kept: list[Curve] = []
    for curve in found:  # the same place as another kind is the same
        if not kept or np.min(np.max(np.abs(apart(curve, kept)), axis=1)) > SAME_PX:
            kept.append(curve)
    return kept


def apart(one: Curve, others: Sequence[Curve]) -> Array:
    """How far other curves are from one at 17 places along, signed, shape (n, 17)."""
    return _shapes(others) - _shapes([one])


def _shapes(found: Sequence[Curve]) -> Array:
    return np.array([curve[:3] for curve in found]).reshape(-1, 3) @ _basis(_ALONG)


def _evidence(strip: Strip, kind: Kind) -> tuple[Array, float]:
    """Whether there is an edge at each pixel of a strip, 0 to 1, and the first pixel's offset."""
    values, offset = answer(strip, kind, _SCALE_PX)
    least = max(_SIGNIFICANT * spread(values), _LEAST_ANSWER)
    edge = peaks(values) & (np.nan_to_num(values) > least)
    if kind in ("dark", "bright"):
        edge &= _between_flanks(strip, values, offset)
    weight: Array = _TOLERANCE[0] * edge.astype(np.float64)
    for distance, share in enumerate(_TOLERANCE[1:], start=1):
        weight[:, distance:] = np.maximum(weight[:, distance:], share * edge[:, :-distance])
        weight[:, :-distance] = np.maximum(weight[:, :-distance], share * edge[:, distance:])
    return weight, float(offset[0])


def _between_flanks(strip: Strip, bend: Array, offset: Array) -> NDArray[np.bool_]:
    """Where light is level, as in the middle of a groove; not so at the shoulders of a step."""
    slope, at = answer(strip, "either", _SCALE_PX)
    slope = slope[:, (at >= offset[0]) & (at <= offset[-1])]
    with np.errstate(invalid="ignore"):
        return slope < _LEVEL * _SCALE_PX * bend


def _of_kind(
    evidence: Array, first: float, kind: Kind, share: Array, wanted: Wanted
) -> list[Curve]:
    """The best curves of a kind: by their score, and by their support wherever they are."""
    step = max(1.0, 2 * wanted.reach_px / (_GRID - 1))
    ends = np.arange(-wanted.reach_px, wanted.reach_px + 0.5 * step, step)
    sags = np.arange(-wanted.sag_px, wanted.sag_px + 0.5 * step, step)
    grid = _product(ends, sags - sags.mean(), ends)
    support = _support(grid, evidence, first, share)
    by_score = _distinct(grid, support - _against(grid, wanted), _KEPT)
    starts = np.concatenate((by_score, _distinct(grid, support, _KEPT)))
    shifts = np.linspace(-step, step, 5)
    near = _product(shifts, shifts, shifts)
    local = starts[:, None] + near
    support = _support(local.reshape(-1, 3), evidence, first, share).reshape(len(starts), -1)
    against = _against(local.reshape(-1, 3), wanted).reshape(len(starts), -1)
    # Where the picks do not decide, they still break ties.
    weight = np.where(np.arange(len(starts)) < len(by_score), 1.0, 1e-3)[:, None]
    best = np.argmax(support - weight * against, axis=1)
    minus = _PREFER_SIGNED * (kind == "either")
    return [
        Curve(
            *(float(local[row, at, part]) for part in range(3)),
            kind=kind,
            support=float(support[row, at]),
            score=float(support[row, at] - against[row, at]) - minus,
        )
        for row, at in enumerate(best)
    ]


def _product(first: Array, second: Array, third: Array) -> Array:
    return np.stack(np.meshgrid(first, second, third, indexing="ij"), axis=-1).reshape(-1, 3)


def _support(grid: Array, evidence: Array, first: float, share: Array) -> Array:
    """Mean evidence under curves (n, 3)."""
    column = np.rint(grid @ _basis(share) - first).astype(np.int64)
    padded = np.pad(evidence, ((0, 0), (1, 1)))
    column = np.clip(column, -1, evidence.shape[1]) + 1
    flat = padded.ravel()[column + np.arange(len(share)) * padded.shape[1]]
    return flat.mean(axis=1)


def _against(grid: Array, wanted: Wanted) -> Array:
    """What the picks say against curves (n, 3)."""
    gap = (grid @ _basis(wanted.share) - wanted.offset) / wanted.scatter_px
    return _PICKS * np.mean(gap**2, axis=1)


def _basis(share: Array) -> Array:
    """What start, sag and end do to offsets, shape (3, n)."""
    return np.stack((1 - share, 4 * share * (1 - share), share))


def _distinct(grid: Array, value: Array, most: int) -> Array:
    """The best curves (n, 3) that are not those before them."""
    order = np.argsort(-value, kind="stable")[: 20 * most]
    shapes = grid[order] @ _basis(_ALONG)
    left = np.arange(len(order))
    kept: list[int] = []
    while len(left) and len(kept) < most:
        kept.append(int(left[0]))
        gap = np.max(np.abs(shapes[left] - shapes[left[0]]), axis=1)
        left = left[gap > SAME_PX]
    return grid[order[kept]]

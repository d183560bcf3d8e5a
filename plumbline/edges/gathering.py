"""Pieces that a lens makes collinear, gathered into lines over the whole width of a photo."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from plumbline.edges.rough_lens import STRONGEST, division_lens
from plumbline.frame import Array, Frame
from plumbline.geometry.lens import Lens

_TOLERANCE = 1.3
"""Pixels of the smaller photo that a piece may be beside its line: its ends are right to one."""

_TILT = 0.06
"""Sine of the angle between a piece and its line at most: a piece of 15 px with ends right to a
pixel is tilted by 0.07."""

_ROUNDS = 8
"""Chosen: twice what a line from the middle to the border takes."""
_REACH = 1.5
"""How far a line looks for more pieces beyond each end, in its present lengths: from 100 px over
2,000 in four rounds."""

_SEEDS = 25
"""Lines begun with one try of the lens: chosen, the longest pieces vote first."""
_VOTERS = 500
"""Pieces that vote, the longest, and lines that are begun with the longest of them: with four
times as many the lens was no better and the time four times as long."""

_TRIED = 17
"""Values of the lens that pieces vote on, then half as far apart three times around the best."""

_SEED_PX = 35.0
"""Length of a piece in the smaller photo at least to begin a line with: its direction is right
to 2°."""

_LEAST_SPAN = 0.25
"""Length of a line over the photo's shorter side at least: shorter ones do not show a bend."""

_LEAST_COVER = 0.3
"""Share of a line with pieces on it at least, as for an edge that is traced."""


class Gathered(NamedTuple):
    """Pieces of one line.

    Attributes:
        members: Numbers of the pieces.
        span_px: From the first to the last of them, pixels of the photo.
        cover: Share of that with a piece on it.
    """

    members: NDArray[np.int64]
    span_px: float
    cover: float


def voted_lens(ends: Array, frame: Frame, scale: float) -> Lens:
    """The one-coefficient lens that gathers most pieces into few lines.

    Args:
        ends: Pieces, shape (n, 2, 2), the longest first.
        frame: The photo's.
        scale: Pixels of the photo to one that the pieces were found in.
    """
    corner = frame.corner_radius
    low, high = max(-STRONGEST, -0.5 / corner**2), min(STRONGEST, 0.5 / corner**2)

    voters = ends[:_VOTERS]

    def votes(l1: float) -> float:
        found = gathered(voters, division_lens(l1, frame), scale, seeds=_SEEDS)
        return float(sum((each.span_px * each.cover) ** 1.5 for each in found))

    tried = np.linspace(low, high, _TRIED)
    score = [votes(float(value)) for value in tried]
    best, step = float(tried[int(np.argmax(score))]), float(tried[1] - tried[0])
    for _ in range(3):
        step /= 2
        best = max((best - step, best, best + step), key=votes)
    return division_lens(best, frame)


def gathered(ends: Array, lens: Lens, scale: float, *, seeds: int | None = None) -> list[Gathered]:
    """Lines of pieces that a lens makes collinear, from the longest pieces on.

    Args:
        ends: Pieces, shape (n, 2, 2), the longest first.
        lens: The lens.
        scale: Pixels of the photo to one that the pieces were found in.
        seeds: Number of pieces that lines are begun with; all long ones by default.
    """
    ideal = lens.undistort_or_nan(ends)
    known = np.asarray(np.isfinite(ideal).all(axis=(1, 2)))
    ideal = np.where(known[:, None, None], ideal, 0.0)
    way = ideal[:, 1] - ideal[:, 0]
    length = np.hypot(way[:, 0], way[:, 1])
    known &= length > 0
    way /= np.maximum(length, 1e-9)[:, None]
    seen = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    stretch = length / np.maximum(seen, 1e-9)  # of the photo by the correction, there
    pieces = _Pieces(ends, ideal, way, length, _TOLERANCE * scale * stretch)
    free = known.copy()
    shorter = min(lens.frame.size)
    found: list[Gathered] = []
    begun = 0
    for seed in range(int(np.count_nonzero(seen >= _SEED_PX * scale))):
        if begun == seeds:
            break
        if not free[seed]:
            continue
        line = _grown(seed, pieces, free)
        begun += 1
        free[line.members] = False
        if line.span_px >= _LEAST_SPAN * shorter and line.cover >= _LEAST_COVER:
            found.append(line)
    return found


class _Pieces(NamedTuple):
    """Pieces as seen and undistorted, directions, lengths, and how far off a line they may be."""

    seen: Array
    ideal: Array
    way: Array
    length: Array
    tolerance: Array


def _grown(seed: int, pieces: _Pieces, free: NDArray[np.bool_]) -> Gathered:
    """All free pieces on the line of one of them, looked for farther and farther out."""
    seen, ideal, way, length, tolerance = pieces
    centre, direction = ideal[seed].mean(axis=0), way[seed]
    low, high = -length[seed] / 2, length[seed] / 2
    members = np.array([seed])
    for _ in range(_ROUNDS):
        gap = ideal - centre
        along = gap @ direction
        across = gap @ np.array([-direction[1], direction[0]])
        reach = _REACH * (high - low)
        near = np.max(np.abs(across), axis=1) < tolerance
        near &= np.abs(way @ np.array([-direction[1], direction[0]])) < _TILT
        near &= (along.max(axis=1) > low - reach) & (along.min(axis=1) < high + reach) & free
        now = np.flatnonzero(near)
        if len(now) == 0 or np.array_equal(now, members):
            break
        members = now
        centre, direction = _line(ideal[members], length[members])
        along = (ideal[members] - centre) @ direction
        low, high = float(along.min()), float(along.max())
    along = (ideal[members] - centre) @ direction
    ends = seen[members].reshape(-1, 2)
    span = ends[int(np.argmax(along))] - ends[int(np.argmin(along))]
    return Gathered(members, float(np.hypot(span[0], span[1])), _covered(np.sort(along, axis=1)))


def _line(ends: Array, length: Array) -> tuple[Array, Array]:
    """Least-squares line through pieces by their ends: a point of it and its direction."""
    weight = np.repeat(length, 2)
    points = ends.reshape(-1, 2)
    centre = np.average(points, axis=0, weights=weight)
    gap = points - centre
    moments = (gap * weight[:, None]).T @ gap
    angle = 0.5 * np.arctan2(2 * moments[0, 1], moments[0, 0] - moments[1, 1])
    return centre, np.array([np.cos(angle), np.sin(angle)])


def _covered(along: Array) -> float:
    """Share of a line that pieces from along[:, 0] to along[:, 1] cover."""
    order = along[np.argsort(along[:, 0])]
    last = np.maximum.accumulate(order[:, 1])
    before = np.concatenate((order[:1, 0], last[:-1]))
    fresh = np.clip(order[:, 1] - np.maximum(order[:, 0], before), 0, None)
    return float(fresh.sum() / max(last[-1] - order[0, 0], 1e-9))

"""Lines that run along the same edge: picked again, they are still one edge.

Picks along an edge that is picked twice are two measurements of it. Their picking errors are
independent, but the edge's own bend is in both, so that a jackknife leaves both out together.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array
from plumbline.geometry.lens import Lens
from plumbline.geometry.lines import Lines, fit_lines, line_numbers
from plumbline.observations import Observations
from plumbline.trust.linearised import in_frame

_APART = 4.0
"""Standard deviations of a pick within which two lines lie on each other: chosen, because the ends
of lines through a few picks scatter by one or two."""

_LEAST_PX = 1.0
"""The least that counts as apart: chosen, because no two edges are closer."""


def edges_of(lens: Lens, observations: Observations, sigma_px: float) -> NDArray[np.int64]:
    """The edge of each line, as the number of the first line along it, shape (l,).

    Args:
        lens: The fitted lens.
        observations: The picks.
        sigma_px: Standard deviation of one pick.
    """
    sizes = observations.sizes
    ideal = lens.undistort_or_nan(np.concatenate(in_frame(observations, lens.frame)))
    points = lens.frame.normalise(ideal, 1.0)
    known: Array = np.where(np.isfinite(points).all(axis=1), 1.0, 0.0)
    lines = fit_lines(points, sizes, known)
    along, _ = lines.place(points, line_numbers(sizes))
    starts = np.cumsum(sizes) - sizes
    along = np.where(np.isfinite(along), along, 0.0)
    reach = np.stack((np.minimum.reduceat(along, starts), np.maximum.reduceat(along, starts)))
    photo = np.array([line.photo for line in observations.lines])
    near_px = max(_APART * sigma_px, _LEAST_PX)
    pairs = [
        pair[:, (photo[pair[0]] == photo[pair[1]]) & _same(lines, reach, pair[0], pair[1], near_px)]
        for pair in _alike(lines, reach, near_px)
    ]
    return _joined(len(sizes), np.concatenate(pairs, axis=1))


def _alike(lines: Lines, reach: Array, near_px: float) -> Iterator[NDArray[np.int64]]:
    """Pairs of lines, shape (2, m), that may lie on each other.

    These are at one distance from the photo's centre, whichever way they point, and run in
    directions that differ by what the shorter one's ends allow.
    """
    away = np.abs(np.sum(lines.across * lines.centre, axis=1))
    order = np.argsort(away, kind="stable")
    away, (cosine, sine) = away[order], lines.along[order].T
    turn = 2 * near_px / np.maximum(reach[1] - reach[0], near_px)[order]
    ends = np.searchsorted(away, away + 2 * near_px, side="right")
    yield np.zeros((2, 0), dtype=np.int64)
    for step in range(1, int(np.max(ends - np.arange(len(away)), initial=1))):
        sine_between = cosine[:-step] * sine[step:] - sine[:-step] * cosine[step:]
        alike = np.abs(sine_between) <= np.maximum(turn[:-step], turn[step:])
        alike &= away[step:] - away[:-step] <= 2 * near_px
        first = np.flatnonzero(alike)
        yield np.stack((order[first], order[first + step]))


def _same(
    lines: Lines, reach: Array, one: NDArray[np.int64], other: NDArray[np.int64], near_px: float
) -> NDArray[np.bool_]:
    """Whether the shorter of two lines lies on the longer, half of it beside that at least."""
    length = reach[1] - reach[0]
    shorter = length[one] <= length[other]
    short, long = np.where(shorter, one, other), np.where(shorter, other, one)
    x, y = (lines.centre[short] - lines.centre[long]).T
    cosine, sine = lines.along[long].T
    # Where the middle of the shorter lies beside the longer, and what one pixel along it adds.
    along, across = x * cosine + y * sine, y * cosine - x * sine
    towards, aside = (
        lines.along[short, 0] * cosine + lines.along[short, 1] * sine,
        lines.along[short, 1] * cosine - lines.along[short, 0] * sine,
    )
    ends = along + reach[:, short] * towards
    near = np.all(np.abs(across + reach[:, short] * aside) <= near_px, axis=0)
    common = np.minimum(ends.max(axis=0), reach[1, long]) - np.maximum(
        ends.min(axis=0), reach[0, long]
    )
    return near & (common >= length[short] / 2)


def _joined(n_lines: int, pairs: NDArray[np.int64]) -> NDArray[np.int64]:
    """The first of the lines that pairs join each line with, directly or over others, (l,)."""
    first = np.arange(n_lines)
    while True:
        before = first.copy()
        least = np.minimum(first[pairs[0]], first[pairs[1]])
        for end in (*pairs, first[pairs[0]], first[pairs[1]]):
            np.minimum.at(first, end, least)
        first = first[first]
        if np.array_equal(first, before):
            return first

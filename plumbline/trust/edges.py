"""Lines that run along the same edge: picked again, they are still one edge.

Picks along an edge that is picked twice are two measurements of it. Their picking errors are
independent, but the edge's own bend is in both, so that a jackknife leaves both out together.
"""

from __future__ import annotations

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
    middle = np.sum(lines.across * lines.centre, axis=1)
    edge = np.arange(len(sizes))
    # Lines on each other are at one distance from the photo's centre, whichever way they point.
    order = np.argsort(np.abs(middle), kind="stable")
    distance = np.abs(middle)[order]
    for place, line in enumerate(order.tolist()):
        end = int(np.searchsorted(distance, distance[place] + 2 * near_px, side="right"))
        for other in order[place + 1 : end].tolist():
            if photo[line] == photo[other] and _same(lines, reach, line, other, near_px):
                edge[edge == edge[max(line, other)]] = edge[min(line, other)]
    return edge


def _same(lines: Lines, reach: Array, one: int, other: int, near_px: float) -> bool:
    """Whether the shorter of two lines lies on the longer, half of it beside that at least."""
    length = reach[1] - reach[0]
    short, long = (one, other) if length[one] <= length[other] else (other, one)
    ends = lines.centre[short] + reach[:, short, None] * lines.along[short]
    offset = ends - lines.centre[long]
    along = offset @ lines.along[long]
    common = min(float(np.max(along)), reach[1, long]) - max(float(np.min(along)), reach[0, long])
    across = np.abs(offset @ lines.across[long])
    return bool(np.all(across <= near_px) and common >= length[short] / 2)

"""How straight points are: orthogonal least-squares lines through them, many at a time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array
from plumbline.observations import Observations

_T = TypeVar("_T", bound=np.generic)


class LineStraightness(NamedTuple):
    """How straight one line is, before and after; all in pixels.

    Attributes:
        label: The line's name.
        photo: Index of its photo.
        n_points: Number of its points that were fitted.
        rms_before_px: Root mean square distance of the observed points from a line.
        rms_after_px: The same of the fit's residuals.
        largest_after_px: The largest residual, without its sign.
    """

    label: str
    photo: int
    n_points: int
    rms_before_px: float
    rms_after_px: float
    largest_after_px: float

    @property
    def left_out(self) -> bool:
        """Whether it was left out as a whole, and its numbers are those of no fit."""
        return self.n_points == 0


@dataclass(frozen=True, eq=False)
class Lines:
    """Orthogonal least-squares lines, one for each group of points.

    Attributes:
        centre: Centroids, shape (l, 2).
        along: Unit vectors along the lines, shape (l, 2).
        count: Number of points that count, shape (l,).
        spread: Sum of squared positions along the line from the centroid, shape (l,).
    """

    centre: Array
    along: Array
    count: Array
    spread: Array

    @property
    def across(self) -> Array:
        """Unit normals, shape (l, 2)."""
        return np.stack((-self.along[:, 1], self.along[:, 0]), axis=1)

    def place(self, points: Array, line: NDArray[np.int64]) -> tuple[Array, Array]:
        """Position along and signed distance from a line for each point, both (n,).

        Args:
            points: Shape (n, 2).
            line: Which line each is compared with, shape (n,).
        """
        # Columns one by one: rows of two are slow to gather.
        x, y = points[:, 0] - self.centre[:, 0][line], points[:, 1] - self.centre[:, 1][line]
        cosine, sine = self.along[:, 0][line], self.along[:, 1][line]
        return x * cosine + y * sine, y * cosine - x * sine


def line_numbers(sizes: NDArray[np.int64]) -> NDArray[np.int64]:
    """Which line each point belongs to, where points stand line after line, shape (n,)."""
    return np.repeat(np.arange(len(sizes)), sizes)


def by_line(values: NDArray[_T], sizes: NDArray[np.int64]) -> tuple[NDArray[_T], ...]:
    """Values of picks that stand line after line, as one array a line."""
    ends = np.cumsum(sizes).tolist()
    return tuple(map(values.__getitem__, map(slice, [0, *ends], ends)))


def drawn_through(kept: NDArray[np.bool_], sizes: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which points lines are drawn through, (n,): the kept ones, or all of a line without any."""
    none = np.add.reduceat(kept.astype(np.int64), np.cumsum(sizes) - sizes) == 0
    return kept | np.repeat(none, sizes)


def fit_lines(points: Array, sizes: NDArray[np.int64], weight: Array) -> Lines:
    """Fit lines by orthogonal least squares.

    tan 2θ = 2 S_xy / (S_xx − S_yy) for the direction θ of the second moments (Pearson 1901).

    Args:
        points: Shape (n, 2), line after line.
        sizes: Number of points of each line, at least one.
        weight: 1 for points that count, 0 for others, shape (n,).
    """
    starts, line = np.cumsum(sizes) - sizes, line_numbers(sizes)
    counted = np.add.reduceat(weight, starts)

    def centred(values: Array) -> tuple[Array, Array]:
        known = np.where(weight > 0, values, 0.0)
        middle = np.add.reduceat(known, starts) / np.maximum(counted, 1.0)
        return middle, (known - middle[line]) * weight

    (centre_x, x), (centre_y, y) = centred(points[:, 0]), centred(points[:, 1])
    xx, xy, yy = (np.add.reduceat(values, starts) for values in (x * x, x * y, y * y))
    cosine, sine = direction(xx, xy, yy)
    # A steep line runs down whichever way it leans, as in the compiled residual.
    turn = np.where((xx < yy) & (sine < 0), -1.0, 1.0)
    cosine, sine = cosine * turn, sine * turn
    spread = xx * cosine**2 + 2 * xy * cosine * sine + yy * sine**2
    centre = np.stack((centre_x, centre_y), axis=1)
    return Lines(centre, np.stack((cosine, sine), axis=1), counted, spread)


def direction(xx: Any, xy: Any, yy: Any) -> tuple[Any, Any]:
    """Cosine and sine of the direction θ of second moments."""
    angle = 0.5 * np.arctan2(2 * xy, xx - yy)
    return np.cos(angle), np.sin(angle)


def straightness_before(
    observations: Observations, kept: Sequence[NDArray[np.bool_]] | None = None
) -> tuple[Array, ...]:
    """Signed distances in square pixels of every line's observed points, before any fit.

    Args:
        observations: The picks.
        kept: Which points of each line its straight line is fitted to; all by default, and of a
            line that kept none.
    """
    points, sizes = observations.centred_px, observations.sizes
    every = np.ones(len(points), dtype=np.bool_)
    drawn = every if kept is None else drawn_through(np.concatenate(kept), sizes)
    lines = fit_lines(points, sizes, drawn.astype(np.float64))
    return by_line(lines.place(points, line_numbers(sizes))[1], sizes)


def rms(arrays: Sequence[Array]) -> float:
    """Root mean square over all arrays."""
    total = sum(float(values @ values) for values in arrays)
    return float(np.sqrt(total / sum(len(values) for values in arrays)))


def largest(arrays: Sequence[Array]) -> float:
    """Largest absolute value over all arrays."""
    return max(float(np.max(np.abs(values))) for values in arrays)

"""How straight points are: orthogonal least-squares lines through them, many at a time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array

_T = TypeVar("_T", bound=np.generic)


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

"""A chequerboard as found in a photograph."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from plumbline.boards.lattice import Lattice
from plumbline.frame import Array

LEAST_ON_A_LINE = 3
"""Corners that a row or column needs to tell whether it is straight."""


@dataclass(frozen=True, eq=False)
class Board:
    """Inner corners of one chequerboard, as far as the photograph shows them.

    Attributes:
        corners_px: Where they lie, the photograph's own pixels, (0, 0) the centre of the top-left
            pixel, shape (n, 2).
        cells: Column and row of each from 0, shape (n, 2). Columns run rightwards in the
            photograph, or as nearly as they can, and rows downwards; a board that is not wholly
            in view counts from what is seen of it.
    """

    corners_px: Array
    cells: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.corners_px)

    @property
    def inner(self) -> tuple[int, int]:
        """Columns and rows of inner corners that are seen, in part at least."""
        if not len(self):
            return 0, 0
        columns, rows = (self.cells.max(axis=0) + 1).tolist()
        return columns, rows

    def lines(self) -> Iterator[tuple[str, Array]]:
        """Rows, then columns of at least three corners: name, and points along it (k, 2)."""
        for name, across in (("row", 1), ("column", 0)):
            order = np.lexsort((self.cells[:, 1 - across], self.cells[:, across]))
            numbers, starts = np.unique(self.cells[order, across], return_index=True)
            for number, members in zip(numbers, np.split(order, starts[1:]), strict=True):
                if len(members) >= LEAST_ON_A_LINE:
                    yield f"{name} {number + 1}", self.corners_px[members]

    def only(self, which: NDArray[np.bool_]) -> Board:
        """Some of its corners, counted anew."""
        cells = self.cells[which]
        first = cells.min(axis=0) if len(cells) else 0
        return replace(self, corners_px=self.corners_px[which], cells=cells - first)


    def cut_down(self, inner: tuple[int, int]) -> Board:
        """The part of at most so many columns and rows, in either order, that has most corners."""
        best = self.only(np.zeros(len(self), dtype=np.bool_))
        for size in (inner, inner[::-1]):
            room = np.maximum(np.array(self.inner) - size, 0)
            for shift in np.ndindex(*(room + 1)):
                inside = ((self.cells >= shift) & (self.cells < np.add(shift, size))).all(axis=1)
                if np.count_nonzero(inside) > len(best):
                    best = self.only(inside)
        return best


def upright(lattice: Lattice) -> Board:
    """The board of a lattice, turned so that its columns run rightwards and rows downwards."""
    cells = np.array(list(lattice), dtype=np.int64)
    points = np.array([corner.xy for corner in lattice.values()])
    middle = cells - cells.mean(axis=0)
    # The average step along columns and rows by least squares; cells of a board span both.
    steps = np.linalg.lstsq(middle, points - points.mean(axis=0), rcond=None)[0]
    turned = [np.linalg.matrix_power(_QUARTER, k) for k in range(4)]
    best = max(turned, key=lambda turn: float(np.trace(turn @ steps)))
    cells = cells @ best.T
    cells -= cells.min(axis=0)
    order = np.lexsort((cells[:, 0], cells[:, 1]))
    return Board(points[order], cells[order])


_QUARTER = np.array([[0, -1], [1, 0]], dtype=np.int64)

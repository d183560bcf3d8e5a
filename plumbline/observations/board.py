"""A chequerboard as found in a photograph: its inner corners by column and row."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array
from plumbline.observations.picks import Line

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

    def lines(self) -> Iterator[tuple[str, NDArray[np.int64]]]:
        """Rows, then columns of at least three corners: the name, and which corners, in order."""
        for name, across in (("row", 1), ("column", 0)):
            order = np.lexsort((self.cells[:, 1 - across], self.cells[:, across]))
            numbers, starts = np.unique(self.cells[order, across], return_index=True)
            for number, members in zip(numbers, np.split(order, starts[1:]), strict=True):
                if len(members) >= LEAST_ON_A_LINE:
                    yield f"{name} {number + 1}", members

    def only(self, which: NDArray[np.bool_]) -> Board:
        """Some of its corners, counted anew."""
        cells = self.cells[which]
        first = cells.min(axis=0) if len(cells) else 0
        return replace(self, corners_px=self.corners_px[which], cells=cells - first)


def lines_of(boards: tuple[Board, ...], photo: int = 0) -> list[Line]:
    """Rows and columns of a photo's boards as lines of points.

    Args:
        boards: The boards of one photo.
        photo: Index of the photo.
    """
    several = len(boards) > 1
    return [
        Line(board.corners_px[members], photo, f"board {number} {name}" if several else name)
        for number, board in enumerate(boards, start=1)
        for name, members in board.lines()
    ]

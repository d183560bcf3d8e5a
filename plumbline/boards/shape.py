"""The shape of a board: which way is up, and how many columns and rows it may have."""

from __future__ import annotations

import numpy as np

from plumbline.boards.lattice import Lattice
from plumbline.observations.board import Board

_QUARTER = np.array([[0, -1], [1, 0]], dtype=np.int64)
"""A quarter turn of columns and rows."""


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


def cut_down(board: Board, inner: tuple[int, int]) -> Board:
    """The part of at most so many columns and rows, in either order, that has most corners."""
    best = board.only(np.zeros(len(board), dtype=np.bool_))
    for size in (inner, inner[::-1]):
        room = np.maximum(np.array(board.inner) - size, 0)
        for shift in np.ndindex(*(room + 1).tolist()):
            inside = np.all((board.cells >= shift) & (board.cells < np.add(shift, size)), axis=1)
            if np.count_nonzero(inside) > len(best):
                best = board.only(inside)
    return best

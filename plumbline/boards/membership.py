"""Which corners belong to a board: those of whole squares, where the others say they should lie."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from plumbline.boards.refine import sides_px
from plumbline.frame import Array
from plumbline.observations.board import Board

_REACH = 2
"""Cells to each side of a corner that predict it; chosen, as a second-degree surface needs them."""

_LEAST = 8
"""Corners that must predict another; a surface of the second degree has six coefficients."""

_ODD, _ODD_SHARE = 6.0, 0.03
"""A corner is a stray that lies off its predicted place by so many times the board's median and by
so large a share of its square. In 24 rendered and 26 real photographs no true corner exceeded 4.2
times (`python -m tests.benchmarks.boards`)."""

_TRIED = 4
"""How many of the oddest corners are tried; chosen, as a stray has at most four neighbours."""

IRREGULAR = 0.1
"""Median offset, as a share of a square, from which corners do not lie as a grid: chosen, between
strong barrel in trials (0.04) and a board on a screen with moiré (0.12)."""


def belonging(board: Board) -> Board:
    """The board without corners that are not part of a whole square, and without strays.

    A stray spoils the prediction of those around it too; of the oddest few that one goes whose
    absence leaves the others least odd.
    """
    kept = board.only(in_whole_squares(board.cells))
    while len(kept):
        offset = offsets(kept)
        odd = np.flatnonzero(offset > _limit(offset))
        if not len(odd):
            break
        oddest = odd[np.argsort(-offset[odd])][:_TRIED]
        without = [kept.only(np.arange(len(kept)) != k) for k in oddest]
        best = min(without, key=lambda each: float(np.nansum(offsets(each) ** 2)))
        kept = best.only(in_whole_squares(best.cells))
    return kept


def _limit(offset: Array) -> float:
    known = offset[np.isfinite(offset)]
    return max(_ODD * float(np.median(known)), _ODD_SHARE) if len(known) else np.inf


def in_whole_squares(cells: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which corners have a square all of whose corners are there, shape (n,)."""
    known = set(map(tuple, cells.tolist()))
    good = np.zeros(len(cells), dtype=np.bool_)
    for k, (column, row) in enumerate(cells.tolist()):
        good[k] = any(
            {(column + i, row), (column, row + j), (column + i, row + j)} <= known
            for i in (-1, 1)
            for j in (-1, 1)
        )
    return good


def irregularity(board: Board) -> float:
    """Median offset of the corners from their predicted places, in squares; 0 if none is."""
    known = offsets(board)
    known = known[np.isfinite(known)]
    return float(np.median(known)) if len(known) else 0.0


def offsets(board: Board) -> Array:
    """How far each corner lies from where those around it predict it, in sides of a square.

    The prediction is a surface of the second degree in column and row through the corners at most
    two cells away, nearer ones weighing more; NaN where there are too few, shape (n,).
    """
    sides = sides_px(board)
    offset = np.full(len(board), np.nan)
    for k, cell in enumerate(board.cells):
        apart = board.cells - cell
        near = np.abs(apart).max(axis=1) <= _REACH
        near[k] = False
        if np.count_nonzero(near) < _LEAST:
            continue
        i, j = apart[near].T.astype(np.float64)
        terms = np.stack((np.ones_like(i), i, j, i * j, i * i, j * j), axis=1)
        weight = 1 / (1 + i * i + j * j)[:, None]
        surface, _, rank, _ = np.linalg.lstsq(
            terms * weight, board.corners_px[near] * weight, rcond=None
        )
        if rank == terms.shape[1]:
            offset[k] = np.hypot(*(surface[0] - board.corners_px[k])) / sides[k]
    return offset

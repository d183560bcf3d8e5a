"""Corners to a few hundredths of a pixel, and those that do not belong to their board."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from plumbline.boards.array import Grey
from plumbline.frame import Array
from plumbline.observations.board import Board

_SHARE = 0.25
"""Half the window as a share of the side of a square: no other edge comes into it."""

_LEAST_PX, _MOST_PX = 2, 7
"""Bounds of half the window, pixels of the picture searched: wider ones see edges bend, narrower
ones noise. With at most 5, 6 and 8 px corners of noisy photographs were good to 0.111, 0.096 and
0.080 px, while those of clean ones grew no better beyond 6 px
(`python -m tests.benchmarks.boards`)."""

_BLUR_PX = 1.0
"""Blur before gradients are taken, pixels of the picture searched, against noise and the steps of
sharp edges: 0.042 instead of 0.050 px (the same benchmark)."""

_FAR = 0.5
"""How far a corner may move, as a share of its window; farther ones have found something else."""

_SETTLED = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 60, 0.001)


def refined(grey: Grey, board: Board, scale: float) -> Board:
    """The board with its corners where the edges' gradients agree they are.

    Every pixel's gradient is at right angles to the way from the corner (W. Förstner and
    E. Gülch, 1987), as `cv2.cornerSubPix` solves it.

    Args:
        grey: Brightness of the whole photograph, shape (h, w).
        board: Corners to a pixel or so.
        scale: Pixels of the photograph to one of the picture in which the board was found.
    """
    half = _half_windows(board, scale)
    smooth = cv2.GaussianBlur(grey, (0, 0), _BLUR_PX * scale)
    found = board.corners_px.copy()
    for window in np.unique(half):
        which = half == window
        start = board.corners_px[which].astype(np.float32).reshape(-1, 1, 2)
        size = (int(window), int(window))
        found[which] = cv2.cornerSubPix(smooth, start, size, (-1, -1), _SETTLED).reshape(-1, 2)
    moved = np.hypot(*(found - board.corners_px).T)
    return replace(board, corners_px=found).only(moved < np.maximum(_FAR * half, scale))


def _half_windows(board: Board, scale: float) -> NDArray[np.int64]:
    half = np.floor(_SHARE * sides_px(board))
    least, most = np.ceil(_LEAST_PX * scale), np.ceil(_MOST_PX * scale)
    return np.clip(half, least, most).astype(np.int64)


def sides_px(board: Board) -> Array:
    """The shortest side of a square at each corner, shape (n,)."""
    place = {tuple(cell): k for k, cell in enumerate(board.cells.tolist())}
    shortest = np.full(len(board), np.inf)
    for (column, row), k in place.items():
        for other in ((column + 1, row), (column, row + 1)):
            if (there := place.get(other)) is None:
                continue
            side = float(np.hypot(*(board.corners_px[there] - board.corners_px[k])))
            shortest[[k, there]] = np.minimum(shortest[[k, there]], side)
    known = np.isfinite(shortest)
    shortest[~known] = shortest[known].min()
    return shortest

"""Corners to a few hundredths of a pixel, and those that do not belong to their board."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array
from plumbline.observations.board import Board
from plumbline.photos.brightness import Grey, sampled

_SHARE = 0.4
"""Half the window at most, as a share of the side of a square: no other corner comes into it."""

_LEAST_PX = 2
"""Half the smallest window, pixels."""

_ENOUGH_PX = 7.0
"""Half the window where nothing forbids it, pixels of the picture searched: wider ones see edges
bend, narrower ones noise. With at most 5, 6 and 8 px corners of noisy photographs were good to
0.111, 0.096 and 0.080 px, while those of clean ones grew no better beyond 6 px
(`python -m tests.benchmarks.boards`)."""

_BLURS = 3.0
"""Half the window in standard deviations of the blur, at least: within a narrower one brightness
is a plain saddle, from which the iteration runs away (its error doubles in every step)."""

_BLUR_PX = 1.0
"""Blur before gradients are taken, pixels of the picture searched, against noise and the steps of
sharp edges: 0.042 instead of 0.050 px (the same benchmark)."""

_ACROSS = np.linspace(-0.4, 0.4, 65)
"""Where an edge's profile is taken, in sides of a square."""

_FAR = 0.5
"""How far a corner may move, as a share of its window; farther ones have found something else."""

_SETTLED = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 60, 0.001)
"""As in growth, finer: chosen, far below the scatter of corners, .02 px."""


def refined(grey: Grey, board: Board, scale: float) -> Board:
    """The board with its corners where the edges' gradients agree they are.

    Every pixel's gradient is at right angles to the way from the corner (W. Förstner and
    E. Gülch, 1987), as `cv2.cornerSubPix` solves it.

    Args:
        grey: Brightness of the whole photograph, shape (h, w).
        board: Corners to a pixel or so.
        scale: Pixels of the photograph to one of the picture in which the board was found.
    """
    smooth = np.asarray(cv2.GaussianBlur(grey, (0, 0), _BLUR_PX * scale), dtype=np.float32)
    half = _half_windows(board, scale, blur_px(smooth, board))
    found = board.corners_px.copy()
    for window in np.unique(half):
        which = half == window
        start = board.corners_px[which].astype(np.float32).reshape(-1, 1, 2)
        size = (int(window), int(window))
        found[which] = cv2.cornerSubPix(smooth, start, size, (-1, -1), _SETTLED).reshape(-1, 2)
    moved = np.hypot(*(found - board.corners_px).T)
    return replace(board, corners_px=found).only(moved < np.maximum(_FAR * half, scale))


def _half_windows(board: Board, scale: float, blurred_px: float) -> NDArray[np.int64]:
    wanted = np.ceil(max(_ENOUGH_PX * scale, _BLURS * blurred_px))
    return np.maximum(np.minimum(wanted, np.floor(_SHARE * sides_px(board))), _LEAST_PX).astype(
        np.int64
    )


def blur_px(grey: Grey, board: Board) -> float:
    """Standard deviation of the blur, from how steep the edges between corners are.

    A step of height h blurred by σ has the slope h / (√(2π) σ) at most.
    """
    ends = [board.corners_px[list(pair)] for pair in neighbours(board)]
    if not ends:
        return 0.0
    start, end = np.array(ends).swapaxes(0, 1)
    along = end - start
    across = np.stack((-along[:, 1], along[:, 0]), axis=1)
    places = (start + end)[:, None] / 2 + across[:, None] * _ACROSS[:, None]
    profile = sampled(grey, places)
    spacing = np.hypot(along[:, 0], along[:, 1]) * (_ACROSS[1] - _ACROSS[0])
    steepest = np.abs(np.diff(profile, axis=1)).max(axis=1) / spacing
    height = profile.max(axis=1) - profile.min(axis=1)
    return float(np.median(height / np.maximum(np.sqrt(2 * np.pi) * steepest, 1e-9)))


def neighbours(board: Board) -> list[tuple[int, int]]:
    """Pairs of corners side by side in a row or column."""
    place = {tuple(cell): k for k, cell in enumerate(board.cells.tolist())}
    return [
        (k, place[other])
        for (column, row), k in place.items()
        for other in ((column + 1, row), (column, row + 1))
        if other in place
    ]


def sides_px(board: Board) -> Array:
    """The shortest side of a square at each corner, shape (n,)."""
    shortest = np.full(len(board), np.inf)
    for here, there in neighbours(board):
        side = float(np.hypot(*(board.corners_px[there] - board.corners_px[here])))
        shortest[[here, there]] = np.minimum(shortest[[here, there]], side)
    known = np.isfinite(shortest)
    shortest[~known] = shortest[known].min()
    return shortest

"""Find the chequerboards in a picture, at whatever size its squares are sharp."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from plumbline.boards.growth import grow
from plumbline.boards.links import link
from plumbline.boards.membership import IRREGULAR, belonging, irregularity
from plumbline.boards.refine import refined, sides_px
from plumbline.boards.rings import ring_test, smoothed
from plumbline.boards.saddles import saddles
from plumbline.boards.shape import cut_down, upright
from plumbline.frame import Array
from plumbline.observations.board import LEAST_ON_A_LINE, Board
from plumbline.photos.brightness import Grey, brightness
from plumbline.wording import count

_LONG_SIDE_PX = 1600
"""Longer side of the picture searched first; chosen, because boards in photographs of 12 to 45
megapixels have squares of 20 px or more there, and it takes 0.1 s."""

_SMALL_PX = 14.0
"""Squares smaller than this are sought in a finer picture too: their rings overlap."""

_COARSEST_PX = 300
"""Longer side below which no coarser picture is searched."""


def find_board(image: NDArray[Any], inner: tuple[int, int] | None = None) -> tuple[Board, ...]:
    """Find the inner corners of the chequerboards in a picture.

    Boards may be partly out of view, bent by the lens and of any size; at least three by three
    corners must be seen. Dot grids and boards with markers in their squares (ChArUco) are not
    read.

    Args:
        image: 8 or 16 bits, or real numbers from 0 to 255: grey (h, w), or blue, green, red
            (h, w, 3), a fourth channel being left aside.
        inner: Columns and rows of inner corners that a board has, in either order; boards are
            cut down to them. None takes boards as they are.

    Returns:
        The boards, that with most corners first; empty where there is none.

    Raises:
        OptionError: the array is not a picture.

    Example:
        >>> import numpy, plumbline
        >>> squares = numpy.indices((6, 8)).sum(axis=0) % 2 * 200 + 20
        >>> picture = numpy.kron(squares, numpy.ones((40, 40))).astype(numpy.uint8)
        >>> board, = plumbline.find_board(picture)
        >>> board.inner
        (7, 5)
    """
    return look_for_boards(brightness(image), inner).boards


@dataclass(frozen=True)
class Search:
    """What a picture shows.

    Attributes:
        boards: The boards, that with most corners first.
        reason: Why there is none, in words that complete "no board: …"; empty if there is one.
    """

    boards: tuple[Board, ...]
    reason: str = ""


def look_for_boards(grey: Grey, inner: tuple[int, int] | None = None) -> Search:
    """As `find_board`, for a picture's brightness; says why there is none."""
    seen = _searched(grey)
    boards = [belonging(refined(grey, board, scale)) for board, scale in seen.boards]
    if inner is not None:
        boards = [cut_down(board, inner) for board in boards]
    whole = [board for board in boards if min(board.inner) >= LEAST_ON_A_LINE]
    good = [board for board in whole if irregularity(board) < IRREGULAR]
    reason = "" if good else (_MIXED if whole else seen.reason)
    return Search(tuple(sorted(good, key=len, reverse=True)), reason)


_MIXED = (
    "corners of squares do not lie as in a grid: boards that overlap, or a screen whose pixels show"
)


@dataclass(frozen=True)
class _Seen:
    """Boards to a pixel or so at one scale.

    Attributes:
        boards: Each with the pixels of the photograph to one of the picture searched.
        corners: How many corners of squares there are, whether on a board or not.
    """

    boards: tuple[tuple[Board, float], ...]
    corners: int

    def __len__(self) -> int:
        return sum(len(board) for board, _ in self.boards)

    @property
    def reason(self) -> str:
        """Why there is no board."""
        if not self.corners:
            return "no place where four squares meet was found"
        return (
            f"{count(self.corners, 'place')} where four squares might meet, but no three by three "
            "of them with dark and light between"
        )

    @property
    def smallest(self) -> float:
        """Side of the smallest board's squares, pixels of the picture searched."""
        return min(float(np.median(sides_px(board))) / scale for board, scale in self.boards)


def _searched(grey: Grey) -> _Seen:
    """The boards of the scale that shows most corners."""
    longest = max(grey.shape)
    first = max(1.0, longest / _LONG_SIDE_PX)
    best = _at_scale(grey, first)
    scale = first
    while scale > 1 and (not best or best.smallest < _SMALL_PX):
        scale = max(1.0, scale / 2)
        best = max(best, _at_scale(grey, scale), key=len)
    scale = 2 * first
    while longest / scale >= _COARSEST_PX:
        coarser = _at_scale(grey, scale)
        if best and len(coarser) <= len(best):
            break
        best = max(best, coarser, key=len)
        scale *= 2
    return best


def _at_scale(grey: Grey, scale: float) -> _Seen:
    """Boards in the picture made smaller, in the photograph's own pixels."""
    size = (max(round(grey.shape[1] / scale), 1), max(round(grey.shape[0] / scale), 1))
    small: Any = grey if scale == 1 else cv2.resize(grey, size, interpolation=cv2.INTER_AREA)
    per_px = np.array([grey.shape[1], grey.shape[0]]) / np.array(size)
    smooth = smoothed(small)
    corners = ring_test(smooth, saddles(small))
    lattices = grow(smooth, corners, link(smooth, corners))
    boards = [belonging(upright(lattice)) for lattice in lattices]
    larger = tuple((_larger(board, per_px), scale) for board in boards if len(board))
    return _Seen(larger, len(corners))


def _larger(board: Board, per_px: Array) -> Board:
    return Board((board.corners_px + 0.5) * per_px - 0.5, board.cells)

"""Boards grow from their best corner, neighbour by neighbour.

First along edges of whole squares, whose four corners are linked all around; then into every cell
whose place the neighbours predict, where a corner passes the ring test.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from plumbline.boards.lattice import STEPS, Cell, Lattice, Placed, beside, frontier, prediction
from plumbline.boards.links import NONE, Links
from plumbline.boards.rings import Corners, ring_test
from plumbline.frame import Array
from plumbline.photos.brightness import Grey

LEAST_SQUARES = 4
"""Squares that must meet in a board's first corner; chosen, because clutter seldom has them."""

_AWAY = 0.2
"""How far from its predicted place a corner may lie, as a share of the side of a square."""

_FAINT = 0.3
"""Share of its neighbours' contrast that a predicted corner must have."""

_WINDOW = 0.2
"""Half the window in which a predicted corner is sought, as a share of the side of a square."""

_MOST_ROUNDS = 200
"""More than the squares across any board."""

_SETTLED = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 30, 0.01)
"""OpenCV's own stop for `cornerSubPix`: chosen, a hundredth of a pixel is below the noise."""


def squares(links: Links) -> NDArray[np.bool_]:
    """Whether the square to the far side of each edge is linked all around, shape (n, 4)."""
    n = len(links.to)
    start = np.broadcast_to(np.arange(n)[:, None], (n, 4)).copy()
    corner, ray = start, np.broadcast_to(np.arange(4), (n, 4)).copy()
    for _ in range(4):
        corner, ray = links.onwards(corner, ray, 1)
    return corner == start


def grow(smooth: Grey, corners: Corners, links: Links) -> list[Lattice]:
    """All boards in a picture, the largest first.

    Args:
        smooth: Brightness after `smoothed`, shape (h, w).
        corners: Those that passed the ring test.
        links: Their neighbours.
    """
    whole = squares(links)
    free = np.ones(len(corners), dtype=np.bool_)
    boards: list[Lattice] = []
    while len(corners):
        rank = np.where(free, whole.sum(axis=1), 0)
        seed = int(np.argmax(rank))
        if rank[seed] < LEAST_SQUARES:
            break
        members, lattice = _spread(corners, links, whole, free, seed)
        free[members] = False
        boards.append(_filled(smooth, lattice))
    return sorted(boards, key=len, reverse=True)


def _spread(
    corners: Corners, links: Links, whole: NDArray[np.bool_], free: NDArray[np.bool_], seed: int
) -> tuple[list[int], Lattice]:
    """The corners that edges of whole squares lead to, breadth first."""
    cells: dict[int, Cell] = {seed: (0, 0)}
    turns = {seed: 0}
    taken = {(0, 0): seed}
    waiting = deque([seed])
    while waiting:
        here = waiting.popleft()
        for direction, step in enumerate(STEPS):
            ray = (turns[here] + direction) % 4
            there = int(links.to[here, ray])
            # The edge's other square begins with the edge before it.
            in_square = whole[here, ray] or whole[here, (ray - 1) % 4]
            cell = beside(cells[here], step)
            if there == NONE or not free[there] or not in_square:
                continue
            if there in cells or cell in taken:
                continue
            cells[there], taken[cell] = cell, there
            turns[there] = (int(links.back[here, ray]) + 2 - direction) % 4
            waiting.append(there)
    return list(cells), {cell: _placed(corners, k, turns[k]) for k, cell in cells.items()}


def _placed(corners: Corners, k: int, turn: int) -> Placed:
    """Corner number `k`, whose edge number `turn` leads along the first step."""
    x, y = corners.points[k].tolist()
    return Placed(x, y, int(corners.signs[k, turn]), float(corners.contrast[k]))


def _filled(smooth: Grey, lattice: Lattice) -> Lattice:
    """The board with every predicted corner that passes the ring test."""
    grown = dict(lattice)
    for _ in range(_MOST_ROUNDS):
        found = _found(smooth, grown)
        if not found:
            break
        grown |= found
    return grown


def _found(smooth: Grey, lattice: Lattice) -> Lattice:
    """Corners in the empty cells beside a board."""
    said = {cell: prediction(lattice, cell) for cell in frontier(lattice)}
    expected = [Expected(cell, *what) for cell, what in said.items() if what is not None]
    corners: Lattice = {}
    for each, corner in _sought(smooth, expected):
        near = {i: lattice.get(beside(each.cell, step)) for i, step in enumerate(STEPS)}
        known = {i: other for i, other in near.items() if other is not None}
        faintest = min(other.contrast for other in known.values())
        if corner.contrast[0] >= _FAINT * faintest and (found := _fitting(corner, known)):
            corners[each.cell] = found
    return corners


class Expected(NamedTuple):
    """Where the corner of a cell should lie, and the side of a square there, in pixels."""

    cell: Cell
    at: Array
    side: float


def _sought(smooth: Grey, expected: Sequence[Expected]) -> Iterator[tuple[Expected, Corners]]:
    """Those corners that are where they should be, one by one."""
    windows = np.array([max(2, round(_WINDOW * each.side)) for each in expected])
    size = np.array(smooth.shape[::-1])
    room = [bool(((e.at > 1) & (e.at < size - 2)).all()) for e in expected]
    for window in np.unique(windows[room]).tolist():
        if min(smooth.shape) < 2 * window + 5:  # OpenCV wants that much
            continue
        some = [e for e, w, r in zip(expected, windows, room, strict=True) if r and w == window]
        start = np.array([each.at for each in some], dtype=np.float32).reshape(-1, 1, 2)
        settled = cv2.cornerSubPix(smooth, start, (window, window), (-1, -1), _SETTLED)
        places = settled.reshape(-1, 2).astype(np.float64)
        passed = ring_test(smooth, places, 0.0)
        for each, place in zip(some, places, strict=True):
            same = (passed.points == place).all(axis=1)
            if same.any() and np.hypot(*(place - each.at)) <= _AWAY * each.side:
                yield each, passed.only(np.flatnonzero(same)[:1])


def _fitting(corner: Corners, near: Mapping[int, Placed]) -> Placed | None:
    """A corner whose edges lead to all its neighbours, light and dark as theirs; else None."""
    turns: set[int] = set()
    for direction, other in near.items():
        offset = other.xy - corner.points[0]
        away = corner.rays[0] - np.arctan2(offset[1], offset[0])
        turns.add((int(np.argmax(np.cos(away))) - direction) % 4)
    signs = {-other.sign for other in near.values()}
    if len(turns) != 1 or len(signs) != 1:
        return None
    found = _placed(corner, 0, turns.pop())
    return found if found.sign == signs.pop() else None

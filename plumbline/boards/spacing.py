"""Whether a board's squares are of one size: the test that lines do not need to pass.

A print with a seam, a printer's feed or a board of two sheets has straight rows and columns at
uneven distances. A grid of equal squares, as calibration by homographies assumes it, then leaves
more than picking errors where lines do not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from plumbline.frame import Array
from plumbline.observations.board import Board
from plumbline.result.calibration import Calibration
from plumbline.trust.linearised import in_frame

_UNEVEN = 1.5
"""How many times worse equal squares must fit than lines do; chosen, well above the 1 of boards
without a seam."""

_LEAST = 12
"""Corners of a board that tell its spacing; a homography takes four of them."""


@dataclass(frozen=True)
class Spacing:
    """How well equal squares and straight lines fit the corrected corners.

    Attributes:
        grid_px: Root mean square offset, along x or y, from a grid of equal squares in
            perspective, pixels of the corrected photo.
        lines_px: Root mean square distance from the straight lines.
    """

    grid_px: float
    lines_px: float

    @property
    def uneven(self) -> bool:
        """Whether rows and columns are straight but not evenly spaced."""
        return self.grid_px > _UNEVEN * self.lines_px

    @property
    def sentence(self) -> str:
        """What to know of it."""
        return (
            f"rows and columns stray from straight lines by {self.lines_px:.2g} px, but are not "
            f"evenly spaced: a grid of equal squares misses them by {self.grid_px:.2g} px (a seam, "
            "two sheets or a printer's feed); this fit uses only that they are straight"
        )


def spacing(calibration: Calibration, boards: Sequence[Sequence[Board]]) -> Spacing | None:
    """Compare corrected corners with grids of equal squares.

    Args:
        calibration: Fitted to the rows and columns of these boards, in their order.
        boards: The boards of each photo.

    Returns:
        None where no board has enough corners whose row and column were both fitted.
    """
    points_px = in_frame(calibration.observations, calibration.lens.frame)
    kept = iter(zip(points_px, calibration.kept, strict=True))
    offsets: list[Array] = []
    for of_photo in boards:
        for board in of_photo:
            corners = np.full((len(board), 2), np.nan)
            wrong = np.zeros(len(board), dtype=np.bool_)
            for _, members in board.lines():
                line_px, good = next(kept)
                corners[members] = line_px
                wrong[members] |= ~good
            corners[wrong] = np.nan
            offsets.append(_from_grid(calibration, board, corners))
    found = np.concatenate(offsets) if offsets else np.zeros(0)
    if not len(found):
        return None
    return Spacing(float(np.sqrt(np.mean(found**2))), calibration.rms_corrected_px)


def _from_grid(calibration: Calibration, board: Board, corners: Array) -> Array:
    """Offsets along x and y of the corrected corners from their grid; none where they are few."""
    ideal = calibration.lens.undistort_or_nan(corners)
    known = np.isfinite(ideal).all(axis=1)
    if np.count_nonzero(known) < _LEAST:
        return np.zeros(0)
    cells, seen = board.cells[known].astype(np.float64), ideal[known]
    homography: Any = cv2.findHomography(cells, seen, 0)[0]
    if homography is None:
        return np.zeros(0)
    grid = cv2.perspectiveTransform(cells[:, None], homography)[:, 0]
    # Eight numbers of the homography were fitted to so many.
    return (seen - grid).ravel() * np.sqrt(seen.size / (seen.size - 8))

"""Corners found against corners rendered."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import plumbline
from tests.render import board as render

NEAR_PX = 3.0


@dataclass(frozen=True)
class Verdict:
    """How a board found compares with the truth.

    Attributes:
        share: Of the corners visible, those found.
        rms_px: Root mean square error of those found.
        strays: Corners found where there is none.
        labels_true: Whether one turn and shift takes all cells to the true ones.
    """

    share: float
    rms_px: float
    strays: int
    labels_true: bool


def judged(shot: render.Shot, truth: render.Board, found: plumbline.Board) -> Verdict:
    """Compare a board found with the one rendered."""
    true_px = shot.corners(truth)
    apart = np.linalg.norm(found.corners_px[:, None] - true_px[None], axis=2)
    apart[np.isnan(apart)] = np.inf
    nearest, error_px = apart.argmin(axis=1), apart.min(axis=1)
    good = error_px < NEAR_PX
    seen = set(nearest[good].tolist()) & set(np.flatnonzero(render.visible(shot, truth)).tolist())
    return Verdict(
        share=len(seen) / int(render.visible(shot, truth).sum()),
        rms_px=float(np.sqrt(np.mean(error_px[good] ** 2))),
        strays=int(np.count_nonzero(~good)),
        labels_true=_turned(found.cells[good], truth.cells[nearest[good]]),
    )


def _turned(cells: np.ndarray, true_cells: np.ndarray) -> bool:
    """Whether cells are the true ones turned by quarters and shifted."""
    for quarters in range(4):
        turn = np.linalg.matrix_power(np.array([[0, -1], [1, 0]]), quarters)
        shift = true_cells - cells @ turn.T
        if (shift == shift[0]).all():
            return True
    return False

"""The part of the photo that picks reach: where an error can be stated."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array
from plumbline.geometry.lens import Lens
from plumbline.observations import Observations
from plumbline.trust.displacement import grid_px
from plumbline.trust.linearised import in_frame

_GRID = 17
"""Points along a side: chosen, because a correction bends little between two of them."""

WHOLE = 0.95
"""Share of the way to the corner from which on picks reach it: chosen, because people cannot pick
the last pixels of an edge."""


def picked_range_px(
    lens: Lens, observations: Observations, kept: NDArray[np.bool_] | None = None
) -> Array:
    """Points all over the photo, as far out as picks reach, shape (n, 2).

    Args:
        lens: The lens.
        observations: The picks.
        kept: Which of them count, line after line; all by default.
    """
    frame = lens.frame
    grid = frame.normalise(grid_px(lens, _GRID))
    picks = frame.normalise(np.concatenate(in_frame(observations, frame)))
    picks = picks if kept is None else picks[kept]
    reached = float(np.max(np.hypot(*picks.T)))
    # Where no pick comes near the photo's edges the grid is laid over what they reach.
    grid *= np.minimum(1.0, reached / np.max(grid, axis=0))
    return frame.to_pixels(grid[np.hypot(*grid.T) <= reached])


def reached_share(lens: Lens, observations: Observations, kept: NDArray[np.bool_]) -> float:
    """How far out picks reach, as a share of the way to the corner."""
    picks = lens.frame.normalise(np.concatenate(in_frame(observations, lens.frame)))[kept]
    return float(np.max(np.hypot(*picks.T))) / lens.frame.corner_radius

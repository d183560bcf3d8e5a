"""Lines of one structure: parallel neighbours, which may bend together.

Both sides of a joint, rows of one sheet, boards of one floor are bent by the same hand. A jackknife
that leaves out one of them at a time takes the others' word for it, so it leaves them out together.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array
from plumbline.geometry.lens import Lens
from plumbline.geometry.lines import fit_lines
from plumbline.observations import Observations
from plumbline.trust.linearised import in_frame

_WIDTH = 0.07
"""Largest distance of lines of a cluster over R: bends of edges on façades were shared within it
(17 rendered and traced scenes)."""

_PARALLEL = 0.03
"""Radians between lines of a cluster: chosen, what a perspective turns neighbours by."""


def clusters_of(lens: Lens, observations: Observations) -> NDArray[np.int64]:
    """The cluster of each line, as the number of the first line in it, shape (l,).

    A cluster is no wider than `_WIDTH`: evenly spaced rows are not all one.

    Args:
        lens: The lens that makes the lines straight.
        observations: Their picks.
    """
    sizes = observations.sizes
    ideal = lens.undistort_or_nan(np.concatenate(in_frame(observations, lens.frame)))
    points = lens.frame.normalise(ideal, lens.frame.radius_px)
    known: Array = np.where(np.isfinite(points).all(axis=1), 1.0, 0.0)
    lines = fit_lines(np.nan_to_num(points), sizes, known)
    photo = np.array([line.photo for line in observations.lines])
    cluster = np.full(len(sizes), -1)
    for first in range(len(sizes)):
        if cluster[first] >= 0:
            continue
        turn = np.abs(lines.along @ lines.across[first])
        apart = np.abs((lines.centre - lines.centre[first]) @ lines.across[first])
        near = (turn < _PARALLEL) & (apart < _WIDTH) & (photo == photo[first])
        cluster[near & (cluster < 0)] = first
    return cluster

"""How straight picked points are as they stand, without any model."""

from __future__ import annotations

import numpy as np

from plumbline.frame import Array
from plumbline.observations import Observations


def distances_from_straight(points: Array) -> Array:
    """Signed distances of points, shape (n, 2), from their orthogonal least-squares line."""
    centred = points - points.mean(axis=0)
    (xx, xy), (_, yy) = centred.T @ centred
    angle = 0.5 * np.arctan2(2 * xy, xx - yy)
    return centred @ np.array([-np.sin(angle), np.cos(angle)])


def straightness_before(observations: Observations) -> tuple[Array, ...]:
    """Signed distances in square pixels of every line's observed points, before any fit."""
    frames = [photo.frame for photo in observations.photos]
    return tuple(
        distances_from_straight(frames[line.photo].normalise(line.points_px, 1.0))
        for line in observations.lines
    )

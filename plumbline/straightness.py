"""How straight picked points are as they stand, without any model."""

from __future__ import annotations

from typing import Any

import numpy as np

from plumbline.frame import Array
from plumbline.observations import Observations


def along_and_across(points: Array) -> tuple[Array, Array]:
    """Where points lie relative to their orthogonal least-squares line.

    Args:
        points: Shape (n, 2).

    Returns:
        Position along the line and signed distance from it, both (n,), from the centroid.
    """
    centred = points - points.mean(axis=0)
    (xx, xy), (_, yy) = centred.T @ centred
    cosine, sine = direction(xx, xy, yy)
    return centred @ np.array([cosine, sine]), centred @ np.array([-sine, cosine])


def direction(xx: Any, xy: Any, yy: Any) -> tuple[Any, Any]:
    """Cosine and sine of the direction θ of second moments: tan 2θ = 2 S_xy / (S_xx − S_yy)."""
    angle = 0.5 * np.arctan2(2 * xy, xx - yy)
    return np.cos(angle), np.sin(angle)


def straightness_before(observations: Observations) -> tuple[Array, ...]:
    """Signed distances in square pixels of every line's observed points, before any fit."""
    frames = [photo.frame for photo in observations.photos]
    return tuple(
        along_and_across(frames[line.photo].normalise(line.points_px, 1.0))[1]
        for line in observations.lines
    )

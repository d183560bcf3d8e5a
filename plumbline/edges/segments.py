"""Short straight pieces of edges all over a photo, as OpenCV's detector finds them.

R. Grompone von Gioi, J. Jakubowicz, J.-M. Morel, G. Randall, "LSD: a fast line segment detector
with a false detection control", 2010. A long edge that a lens bends comes as a chain of pieces.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from plumbline.edges.light import Light
from plumbline.frame import Array

_PIXELS = 2.0e6
"""Pixels that are looked at: pieces are wanted to a pixel only, and the detector's time grows with
their number, 0.5 s a million."""

_LEAST_PX = 15.0
"""Length of a piece in the smaller photo at least: shorter ones point anywhere within 4°."""

_TANGENTIAL = 0.05
"""Sine of the angle to a circle about the photo's centre below which a piece may be of its rim."""

_RIM_PX = 3.0
_RIM_ANGLE = 0.9
"""Radians of a circle about the centre that pieces cover before they are a rim: no straight line
keeps its distance from the centre within 3 px over more than 0.4 of them."""


def segments(light: Light) -> tuple[Array, float]:
    """Straight pieces of edges.

    Args:
        light: Linear light, shape (rows, columns).

    Returns:
        Both ends of each in pixels of the photo, shape (n, 2, 2), the longest first; and the
        photo's pixels to one that was looked at.
    """
    rows, columns = light.shape
    scale = max(1.0, float(np.sqrt(light.size / _PIXELS)))
    size = max(1, round(columns / scale)), max(1, round(rows / scale))
    small = light if scale == 1 else cv2.resize(light, size, interpolation=cv2.INTER_AREA)
    seen = np.asarray(np.sqrt(np.clip(small, 0, 1)) * 255, dtype=np.uint8)
    detected: Any = cv2.createLineSegmentDetector(cv2.LSD_REFINE_NONE).detect(seen)[0]
    if detected is None:
        return np.empty((0, 2, 2)), scale
    ends = np.asarray(detected, dtype=np.float64).reshape(-1, 2, 2)
    length = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    ends = ends[length >= _LEAST_PX]
    ends = ends[np.argsort(-np.hypot(*(ends[:, 1] - ends[:, 0]).T), kind="stable")]
    ends = ends[~_of_rims(ends, np.array([small.shape[1] - 1, small.shape[0] - 1]) / 2)]
    factor = np.array([columns / small.shape[1], rows / small.shape[0]])
    return (ends + 0.5) * factor - 0.5, scale


def _of_rims(ends: Array, centre: Array) -> NDArray[np.bool_]:
    """Which pieces belong to circles about the centre, such as the rim of a fisheye's picture."""
    middle = ends.mean(axis=1) - centre
    way = ends[:, 1] - ends[:, 0]
    radius = np.hypot(middle[:, 0], middle[:, 1])
    length = np.hypot(way[:, 0], way[:, 1])
    along = np.abs(np.sum(middle * way, axis=1)) / np.maximum(radius * length, 1e-9)
    tangential = along < _TANGENTIAL
    covered = np.where(tangential, length / np.maximum(radius, 1.0), 0.0)
    ring = np.rint(radius / _RIM_PX).astype(np.int64)
    total = np.bincount(ring, covered, ring.max(initial=0) + 2)
    near = total + np.concatenate((total[1:], [0.0])) + np.concatenate(([0.0], total[:-1]))
    return tangential & (near[ring] > _RIM_ANGLE)

"""Saddle points of a picture's brightness: where the corners of a chequerboard may lie.

Where four squares meet, brightness rises along one diagonal and falls along the other: the
determinant of its Hessian is negative, and least at the corner (D. Chen and G. Zhang, "A new
sub-pixel detector for X-corners in camera calibration targets", 2005).
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np

from plumbline.frame import Array
from plumbline.photos.brightness import Grey

SIGMA_PX = 1.5
"""Blur before derivatives are taken; chosen, because it is about a camera's own."""

LEAST_CONTRAST = 6.0
"""Half the difference between dark and light squares, in grey levels, below which a saddle is
noise; chosen, because in glare boards keep three times as much."""

_WIDEST_PX = 2.5
"""Blur, the camera's own and `SIGMA_PX` together, that the threshold allows for."""

_MOST = 20_000
"""Saddles that are looked at: the steepest; chosen, because no board has a tenth of it."""

_FIRST = np.array([[-0.5, 0.0, 0.5]], dtype=np.float32)
_SECOND = np.array([[1.0, -2.0, 1.0]], dtype=np.float32)
_MIXED = np.array([[0.25, 0, -0.25], [0, 0, 0], [-0.25, 0, 0.25]], dtype=np.float32)
"""Central differences of a smoothed picture: its first, second and mixed derivatives."""
_AROUND = np.ones((5, 5), dtype=np.uint8)
"""Where a saddle is the deepest one: chosen, corners are farther apart."""


def saddles(grey: Grey) -> Array:
    """Saddle points that are steeper than all around.

    An ideal corner ±A blurred by σ has the mixed derivative 2 A / (π σ²), from which the
    threshold follows. Where brightness is level is found from the derivatives by one step of
    Newton's.

    Args:
        grey: Brightness in grey levels, shape (h, w).

    Returns:
        Points (x, y), shape (n, 2), the steepest first.
    """
    smooth = cv2.GaussianBlur(grey, (0, 0), SIGMA_PX)
    xx, yy, xy = (_filtered(smooth, kernel) for kernel in (_SECOND, _SECOND.T, _MIXED))
    depth = xy * xy - xx * yy
    least = (2 * LEAST_CONTRAST / (np.pi * _WIDEST_PX**2)) ** 2
    found = (depth >= cv2.dilate(depth, _AROUND)) & (depth > least)
    rows, columns = np.nonzero(found)
    order = np.argsort(-depth[rows, columns], kind="stable")[:_MOST]
    at = rows[order], columns[order]
    x, y = (_filtered(smooth, kernel)[at] for kernel in (_FIRST, _FIRST.T))
    step_x = (yy[at] * x - xy[at] * y) / depth[at]
    step_y = (xx[at] * y - xy[at] * x) / depth[at]
    step = np.clip(np.stack((step_x, step_y), axis=1), -1.0, 1.0)
    return np.stack((at[1], at[0]), axis=1) + step.astype(np.float64)


def _filtered(smooth: Any, kernel: Any) -> Any:
    return cv2.filter2D(smooth, cv2.CV_32F, kernel)

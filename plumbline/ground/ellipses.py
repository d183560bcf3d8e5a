"""Error ellipses and intervals of 95 %."""

from __future__ import annotations

import numpy as np

from plumbline.frame import Array

CHI_2 = 5.991464547107979
"""95 % of chi square with two degrees of freedom: −2 ln 0.05."""

Z_95 = 1.959963984540054
"""95 % of the normal distribution, both sides."""


def standard_errors(covariances: Array) -> Array:
    """Root of the summed variances of each, shape (n, 2, 2) → (n,)."""
    return np.sqrt(np.trace(covariances, axis1=-2, axis2=-1))


def ellipse(covariance: Array) -> tuple[float, float, float]:
    """The 95 % ellipse: half axes, long and short, and the long one's angle from X in degrees."""
    values, axes = np.linalg.eigh(covariance)
    short, long = np.sqrt(CHI_2 * np.maximum(values, 0.0))
    return float(long), float(short), float(np.degrees(np.arctan2(axes[1, 1], axes[0, 1])) % 180.0)

"""How sure the correction is, in pixels of the photo.

Straight lines see neither the scale nor the place of the corrected photo (nor, with tangential
terms, its perspective). The standard error of a point's displacement is therefore taken after
the best common scale and translation (or homography) of the whole photo, which is what remains
uncertain in its geometry. It holds independent picking errors on straight edges under the right
model; bent edges, wrong picks and the model's own error are not in it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from plumbline.errors import FoldedError
from plumbline.frame import Array
from plumbline.lens import Lens

_STEP = 1e-6


def displacement_errors(
    lens: Lens, free: tuple[str, ...], covariance: Array, points_px: Array
) -> NDArray[np.float64] | None:
    """Standard errors of the displacements of observed points.

    Args:
        lens: The fitted lens.
        free: Names of the free coefficients.
        covariance: Their covariance, `d` and `e` in pixels.
        points_px: Observed points all over the photo, shape (n, 2).

    Returns:
        Shape (n,), pixels; None where the model folds before it reaches a point.
    """
    try:
        columns = [_derivative(lens, name, points_px) for name in free]
    except FoldedError:
        return None
    derivative = np.stack(columns, axis=-1).reshape(-1, len(free))
    unseen = _unseen(lens, free, points_px)
    derivative = derivative - unseen @ np.linalg.lstsq(unseen, derivative, rcond=None)[0]
    variance = np.einsum("ni,ij,nj->n", derivative, covariance, derivative)
    return np.sqrt(np.maximum(variance, 0.0).reshape(-1, 2).sum(axis=1))


def grid_px(lens: Lens, n: int = 9) -> Array:
    """A grid of n × n points over the photo, its corners included, shape (n², 2)."""
    width, height = lens.frame.size
    x, y = np.meshgrid(np.linspace(0, width - 1, n), np.linspace(0, height - 1, n))
    return np.stack((x.ravel(), y.ravel()), axis=1)


def _derivative(lens: Lens, name: str, points_px: Array) -> Array:
    step = _STEP * (lens.unit_px if name in ("d", "e") else 1.0)
    ends = [
        replace(lens, coefficients=dict(lens.coefficients) | {name: value}).undistort(points_px)
        for value in (lens.coefficients[name] + step, lens.coefficients[name] - step)
    ]
    return (ends[0] - ends[1]) / (2 * step)


def _unseen(lens: Lens, free: tuple[str, ...], points_px: Array) -> Array:
    """Motions of the corrected photo that keep lines straight, shape (2n, motions)."""
    x, y = lens.frame.normalise(lens.undistort(points_px)).T
    one, none = np.ones_like(x), np.zeros_like(x)
    motions = [(one, none), (none, one), (x, y)]
    if set(lens.model.tangential) & set(free):
        motions += [(y, none), (none, x), (x, none), (x * x, x * y), (x * y, y * y)]
    return np.stack([np.stack(motion, axis=-1).ravel() for motion in motions], axis=-1)

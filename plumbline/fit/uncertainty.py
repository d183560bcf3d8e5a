"""What the errors of a fit's coefficients do to the correction, for many fits at a time."""

from __future__ import annotations

import numpy as np

from plumbline.frame import Array
from plumbline.models import Model

_RADII, _STEP = 12, 1e-6
"""Radii up to the corner, and the step of a difference: chosen; a curve has no more bends, and
the step leaves ten digits."""


def corner_errors(model: Model, c: Array, covariance: Array, corner: Array) -> Array:
    """Largest standard errors of the radial displacement up to the corner, normalised.

    The best common scale is taken out, since straight lines do not see it.

    Args:
        model: The model.
        c: Its coefficients, shape (m, k).
        covariance: Theirs, shape (m, k, k).
        corner: Normalised radius of the photo's corner, shape (m,).

    Returns:
        Shape (m,).
    """
    radii = corner[:, None, None] * (np.arange(1, _RADII + 1) / _RADII)
    own = [model.coefficients.index(name) for name in model.radial]
    # In units in which every term amounts to the same at the corner.
    units = corner[:, None] ** -np.array(model.powers, dtype=np.float64)
    steps = _STEP * units[:, :, None] * np.eye(c.shape[1])[own]
    moved = np.concatenate((c[:, None], c[:, None] + steps), axis=1)
    with np.errstate(all="ignore"):  # a lens that makes no sense is refused, not an error here
        factors = model.factor(radii, moved.transpose(2, 0, 1)[..., None])
        design = radii * (factors[:, 1:] - factors[:, :1]) / (_STEP * units[..., None])
    scale = np.sum(design * radii, axis=2, keepdims=True) / np.sum(radii**2, axis=2, keepdims=True)
    design -= scale * radii
    of_radial = covariance[:, own][:, :, own]
    return np.sqrt(np.max(np.sum(of_radial @ design * design, axis=1), axis=1))

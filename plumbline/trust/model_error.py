"""How far a richer model would move the correction.

Standard errors and the jackknife do not see a model that cannot follow the lens; one more power
of r shows how far that would move the correction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plumbline.frame import Array
from plumbline.geometry.lens import Lens
from plumbline.trust.displacement import grid_px, motions
from plumbline.trust.linearised import Linearised
from plumbline.wording import joined, power_of

_SINGULAR = 1e-12
"""As for `Linearised.without_each_line`."""


@dataclass(frozen=True)
class ModelError:
    """How far a richer model would move the correction.

    Attributes:
        largest_px: The largest difference over the photo.
        error_px: Its own standard error.
        names: What the richer model adds.
    """

    largest_px: float
    error_px: float
    names: str


def model_error(
    lens: Lens, free: tuple[str, ...], linear: Linearised, sigma_px: float
) -> ModelError | None:
    """The largest difference to the next richer model over the photo.

    One Gauss–Newton step with the terms of `Model.richer` added, less one without them.

    Returns:
        None where the picks cannot tell the added terms, or the model folds inside the photo.
    """
    powers = lens.model.richer(free)
    moved = motions(lens, free, grid_px(lens), powers)
    # In the photograph, where every pick has the same σ.
    columns = np.concatenate((linear.jacobian, linear.extra), axis=1)
    design = (columns * linear.in_photo[:, None])[linear.kept]
    unit = _inverse_normal(design)
    if moved is None or unit is None:
        return None
    k, residual_px = len(free), linear.image_px[linear.kept]
    own = design[:, :k]
    step = -unit @ (design.T @ residual_px)
    step[:k] += np.linalg.pinv(own.T @ own) @ (own.T @ residual_px)
    size = np.hypot(*np.einsum("nik,k->in", moved, step))
    worst = int(np.argmax(size))
    effect = moved[worst] @ unit[:, k:] @ np.linalg.inv(unit[k:, k:])
    variance = np.trace(effect @ (sigma_px**2 * unit[k:, k:]) @ effect.T)
    added = joined([power_of("r", power) for power in powers])
    return ModelError(float(size[worst]), float(np.sqrt(variance)), added)


def _inverse_normal(design: Array) -> Array | None:
    """(JᵀJ)⁻¹, or None where the columns of J, shape (n, k), cannot be told apart."""
    scale = np.sqrt(np.sum(design**2, axis=0))
    if len(design) <= design.shape[1] or np.any(scale <= 0):
        return None
    values, vectors = np.linalg.eigh((design / scale).T @ (design / scale))
    if values[0] <= _SINGULAR:
        return None
    return (vectors / values) @ vectors.T / np.outer(scale, scale)

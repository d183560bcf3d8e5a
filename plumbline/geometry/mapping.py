"""A distortion model from either side to the other, its fold respected.

Outside the fit's compiled programs this is the only place that maps points with a model, so that
no caller can forget the fold: beyond it a polynomial turns back and its values mean nothing.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from plumbline.frame import Array
from plumbline.models import Model
from plumbline.models.base import Direction
from plumbline.models.inverse import first_fold, invert


def map_points(
    model: Model, coefficients: tuple[float, ...], points: Array, reach: float, way: Direction
) -> Array:
    """Map points from one side of a model to the other.

    Args:
        model: The distortion model.
        coefficients: Its coefficients, in order.
        points: Normalised, measured from the distortion centre. Shape (..., 2).
        reach: Radius up to which a fold is looked for; points farther out extend it.
        way: From which side to which.

    Returns:
        The points on the other side, same shape and unit; NaN where the model folds before it
        reaches a point.
    """
    c = np.array(coefficients, dtype=np.float64)
    if model.direction != way:
        return invert(model, c, points, reach)
    r = np.hypot(points[..., 0], points[..., 1])
    farthest = float(np.max(r, initial=0.0, where=np.isfinite(r)))
    mapped = np.stack(model.apply(points[..., 0], points[..., 1], c), axis=-1)
    fold = _first_fold(model, tuple(coefficients), max(reach, farthest))
    if fold is not None:
        mapped[r > fold] = np.nan
    return mapped


@lru_cache(maxsize=64)  # a picture is mapped tile by tile, with one lens
def _first_fold(model: Model, coefficients: tuple[float, ...], reach: float) -> float | None:
    return first_fold(model, np.array(coefficients), reach)

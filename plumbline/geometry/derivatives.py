"""Ideal points with their derivatives, in NumPy.

The fit differentiates in its compiled program. What is asked of a finished fit (leverage, errors
in pixels, left-out lines) needs the same derivatives at one lens only, and no program for them.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from plumbline.frame import Array
from plumbline.geometry.lens import Lens
from plumbline.models import CENTRE, Model

_STEP = 1e-5


class Ideal(NamedTuple):
    """Ideal points in square pixels from the distortion centre.

    Attributes:
        uv: Ideal points, shape (n, 2); NaN beyond the fold of the model.
        stretch: Derivative of the ideal point (rows) by the observed one (columns), both in
            square pixels, shape (n, 2, 2).
    """

    uv: Array
    stretch: Array


def undistorted(lens: Lens, observed_px: Array) -> Ideal:
    """Undistort points of shape (n, 2); those beyond the fold become NaN."""
    uv = lens.frame.normalise(lens.undistort_or_nan(observed_px), 1.0)
    observed = _observed(lens, observed_px)
    return Ideal(uv, stretch(lens.model, lens.vector, observed / lens.unit_px, uv / lens.unit_px))


def stretch(model: Model, c: Any, observed: Array, ideal: Array) -> Array:
    """Derivative of ideal points by observed ones, all normalised and from the distortion centre.

    Args:
        model: The model.
        c: Its coefficients, each a number or of shape (n,).
        observed: Shape (n, 2).
        ideal: Shape (n, 2).

    Returns:
        Shape (n, 2, 2), rows for the ideal point.
    """
    x, y = (observed if model.direction == "observed to ideal" else ideal).T
    xx, xy, yx, yy = model.jacobian(x, y, c)
    if model.direction == "ideal to observed":
        determinant = xx * yy - xy * yx
        with np.errstate(divide="ignore", invalid="ignore"):
            xx, xy, yx, yy = (v / determinant for v in (yy, -xy, -yx, xx))
    return np.stack((xx, xy, yx, yy), axis=-1).reshape(-1, 2, 2)


def by_coefficients(lens: Lens, names: tuple[str, ...], observed_px: Array, ideal: Ideal) -> Array:
    """Derivatives of ideal points by coefficients.

    Args:
        lens: The lens.
        names: Coefficients, `d` and `e` (per pixel of the photo) among them.
        observed_px: Observed points, shape (n, 2), the photo's own pixels.
        ideal: The same undistorted.

    Returns:
        Square pixels of the corrected photo for one unit of each coefficient, (n, 2, k).
    """
    columns: list[Array] = []
    for name in names:
        if name in CENTRE:
            axis = CENTRE.index(name)
            per_px = lens.frame.per_px(1.0)[axis]
            # The ideal side stays where it is: only the observed point moves against the centre.
            columns.append(-ideal.stretch[:, :, axis] * per_px)
            continue
        step = np.zeros(len(lens.vector))
        step[lens.model.coefficients.index(name)] = _STEP
        columns.append(_moved(lens, observed_px, ideal, step))
    return np.stack(columns, axis=-1)


def by_powers(lens: Lens, powers: tuple[int, ...], observed_px: Array, ideal: Ideal) -> Array:
    """The same for terms r^n that the model does not have, added to its polynomial.

    Args:
        lens: The lens.
        powers: The powers n.
        observed_px: As for `by_coefficients`.
        ideal: As for `by_coefficients`.
    """
    towards = lens.model.direction == "observed to ideal"
    own = (_observed(lens, observed_px) if towards else ideal.uv) / lens.unit_px
    r = np.hypot(*own.T)
    columns: list[Array] = []
    for power in powers:
        moved = own * (r**power)[:, None] * lens.unit_px
        columns.append(moved if towards else -np.einsum("nij,nj->ni", ideal.stretch, moved))
    return np.stack(columns, axis=-1)


def _moved(lens: Lens, observed_px: Array, ideal: Ideal, step: Array) -> Array:
    """Central difference by the model's own direction, turned around where that is the other."""
    towards = lens.model.direction == "observed to ideal"
    x, y = ((_observed(lens, observed_px) if towards else ideal.uv) / lens.unit_px).T
    above = np.stack(lens.model.apply(x, y, lens.vector + step), axis=-1)
    below = np.stack(lens.model.apply(x, y, lens.vector - step), axis=-1)
    slope = (above - below) * (lens.unit_px / (2 * _STEP))
    return slope if towards else -np.einsum("nij,nj->ni", ideal.stretch, slope)


def _observed(lens: Lens, observed_px: Array) -> Array:
    """Observed points from the distortion centre in square pixels."""
    offset = np.array([lens.coefficients[name] for name in CENTRE])
    return lens.frame.normalise(observed_px - offset, 1.0)

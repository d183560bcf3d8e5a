"""Ideal points with their derivatives, in NumPy.

The fit differentiates in its compiled program. What is asked of a finished fit (leverage, errors
in pixels, left-out lines) needs the same derivatives at one lens only, and no program for them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from plumbline.frame import Array
from plumbline.geometry.lens import Lens
from plumbline.models import CENTRE

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
    slopes = lens.model.stretch(observed / lens.unit_px, uv / lens.unit_px, lens.vector)
    return Ideal(uv, slopes)


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
    own = lens.model.argument(_observed(lens, observed_px), ideal.uv) / lens.unit_px
    r = np.hypot(*own.T)
    columns: list[Array] = []
    for power in powers:
        moved = own * (r**power)[:, None] * lens.unit_px
        columns.append(lens.model.as_ideal_motion(moved, ideal.stretch))
    return np.stack(columns, axis=-1)


def _moved(lens: Lens, observed_px: Array, ideal: Ideal, step: Array) -> Array:
    """Central difference by the model's own direction, turned around where that is the other."""
    x, y = (lens.model.argument(_observed(lens, observed_px), ideal.uv) / lens.unit_px).T
    above = np.stack(lens.model.apply(x, y, lens.vector + step), axis=-1)
    below = np.stack(lens.model.apply(x, y, lens.vector - step), axis=-1)
    slope = (above - below) * (lens.unit_px / (2 * _STEP))
    return lens.model.as_ideal_motion(slope, ideal.stretch)


def _observed(lens: Lens, observed_px: Array) -> Array:
    """Observed points from the distortion centre in square pixels."""
    offset = np.array([lens.coefficients[name] for name in CENTRE])
    return lens.frame.normalise(observed_px - offset, 1.0)

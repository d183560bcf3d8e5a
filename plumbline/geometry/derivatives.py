"""Ideal points with their derivatives, in NumPy.

The fit differentiates in its compiled program. What is asked of a finished fit (leverage, errors
in pixels, left-out lines) needs the same derivatives at one lens only, and no program for them.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array
from plumbline.geometry.lens import Lens
from plumbline.models import CENTRE

_STEP = 1e-5
"""By how much a term changes the magnification at the corner for a central difference: chosen,
because its error, squared, is 1e-10, and rounding adds no more."""


class Ideal(NamedTuple):
    """Ideal points in square pixels from the distortion centre.

    Attributes:
        uv: Ideal points, shape (n, 2); NaN beyond the fold of the model.
        stretch: Derivative of the ideal point (rows) by the observed one (columns), both in
            square pixels, shape (n, 2, 2).
        aspect: Width over height of the photograph's pixels; shape (n,) where photos differ.
    """

    uv: Array
    stretch: Array
    aspect: Array | float = 1.0

    def at(self, which: NDArray[Any]) -> Ideal:
        """Some of the points, by their numbers or a mask."""
        aspect = np.broadcast_to(self.aspect, len(self.uv))[which]
        return Ideal(self.uv[which], self.stretch[which], aspect)


def undistorted(lens: Lens, observed_px: Array) -> Ideal:
    """Undistort points of shape (n, 2); those beyond the fold become NaN."""
    uv = lens.frame.normalise(lens.undistort_or_nan(observed_px), 1.0)
    observed = _observed(lens, observed_px)
    slopes = lens.model.stretch(observed / lens.unit_px, uv / lens.unit_px, lens.vector)
    return Ideal(uv, slopes, lens.frame.pixel_aspect)


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
        columns.append(_moved(lens, observed_px, ideal, name))
    return np.stack(columns, axis=-1)


def by_tangential(lens: Lens, observed_px: Array, ideal: Ideal) -> Array:
    """The same for the two tangential terms, whether the model has them or not.

    (2 p1 x y + p2 (r² + 2x²), p1 (r² + 2y²) + 2 p2 x y), r in units of half the shorter side.

    Returns:
        Shape (n, 2, 2), for p1 and p2.
    """
    unit_px = lens.frame.radius_px
    own = lens.model.argument(_observed(lens, observed_px), ideal.uv) / unit_px
    (x, y), r2 = own.T, np.sum(own**2, axis=1)
    first = np.stack((2 * x * y, r2 + 2 * y * y), axis=1) * unit_px
    second = np.stack((r2 + 2 * x * x, 2 * x * y), axis=1) * unit_px
    moved = [lens.model.as_ideal_motion(each, ideal.stretch) for each in (first, second)]
    return np.stack(moved, axis=-1)


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


def _moved(lens: Lens, observed_px: Array, ideal: Ideal, name: str) -> Array:
    """Central difference by the model's own direction, turned around where that is the other."""
    model = lens.model
    x, y = (model.argument(_observed(lens, observed_px), ideal.uv) / lens.unit_px).T
    size = _STEP / step_unit(lens, name)
    step = np.zeros(len(lens.vector))
    step[model.coefficients.index(name)] = size
    above = np.stack(model.apply(x, y, lens.vector + step), axis=-1)
    below = np.stack(model.apply(x, y, lens.vector - step), axis=-1)
    return model.as_ideal_motion((above - below) * (lens.unit_px / (2 * size)), ideal.stretch)


def step_unit(lens: Lens, name: str) -> float:
    """What a coefficient's term amounts to at the photo's corner for a coefficient of 1.

    A lens of 400 mm measured in focal lengths has its corner at r = 0.05, where a coefficient of
    r⁶ moves nothing by a step that suits one of half the shorter side.
    """
    corner = lens.frame.corner_radius * lens.frame.radius_px / lens.unit_px
    powers = dict(zip(lens.model.radial, lens.model.powers, strict=True))
    return corner ** powers.get(name, 1)


def _observed(lens: Lens, observed_px: Array) -> Array:
    """Observed points from the distortion centre in square pixels."""
    offset = np.array([lens.coefficients[name] for name in CENTRE])
    return lens.frame.normalise(observed_px - offset, 1.0)

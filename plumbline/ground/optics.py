"""A lens over a photo, with the derivatives that an adjustment needs.

    observed = D(ideal; c) + δ

D is the lens's distortion with its coefficients c, δ the shift of its centre. Beyond the fold of
the model no point has an image; there are ghosts else, ground that maps back into the photo.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from plumbline.frame import Array
from plumbline.lenses.mapping import PhotoLens
from plumbline.models.inverse import REACH

_COMPLEX_STEP = 1e-30
"""Step of derivatives by coefficients: W. Squire and G. Trapp (1998), exact at any small size."""


@dataclass(frozen=True)
class Optics:
    """The lens of one photo.

    Attributes:
        lens: The distortion over the photo.
        shift_px: δ, the shift of the lens's centre from where the source has it, pixels.
    """

    lens: PhotoLens
    shift_px: tuple[float, float] = (0.0, 0.0)

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the model's coefficients."""
        return self.lens.model.coefficients

    def with_coefficients(self, values: Array) -> Optics:
        """The same lens with other coefficients."""
        return replace(self, lens=replace(self.lens, coefficients=tuple(map(float, values))))

    def moved(self, shift_px: Array) -> Optics:
        """The same lens, its centre moved further."""
        x, y = np.array(self.shift_px) + shift_px
        return replace(self, shift_px=(float(x), float(y)))

    @cached_property
    def axis_px(self) -> Array:
        """Where the optical axis meets the ideal picture, shape (2,)."""
        turned = self._turn @ np.array(self.lens.ideal_centre)
        return self.lens.frame.to_pixels(turned, self.lens.unit_px)

    @property
    def aspect(self) -> float:
        """Width of one pixel over its height."""
        return self.lens.frame.pixel_aspect

    @cached_property
    def paraxial_scale(self) -> float:
        """Observed over ideal size at the centre; EXIF's focal length is that of the observed."""
        step = np.array([[1e-3, 0.0]])
        ends = [self.distort(self.axis_px + sign * step)[0, 0] for sign in (1, -1)]
        return float(ends[0] - ends[1]) / 2e-3

    def distort(self, ideal_px: Array) -> Array:
        """Ideal points to observed ones, shape (..., 2); NaN beyond the fold."""
        return self._outside(self._run(self._inside(ideal_px, ideal=True), ideal=True), ideal=False)

    def undistort(self, observed_px: Array) -> Array:
        """Observed points to ideal ones, shape (..., 2); NaN beyond the fold."""
        points = self._inside(observed_px, ideal=False)
        return self._outside(self._run(points, ideal=False), ideal=True)

    def with_derivatives(self, ideal_px: Array) -> tuple[Array, Array, Array]:
        """Observed points, and their derivatives by ideal points and by coefficients.

        Args:
            ideal_px: Shape (n, 2).

        Returns:
            Shapes (n, 2), (n, 2, 2) and (n, 2, k); NaN beyond the fold.
        """
        model, c = self.lens.model, self._vector
        start = self._inside(ideal_px, ideal=True)
        end = self._run(start, ideal=True)
        own = start if self._forward else end
        jacobian = np.stack(model.jacobian(own[:, 0], own[:, 1], c), axis=-1).reshape(-1, 2, 2)
        by_c = np.stack([self._by_coefficient(own, i) for i in range(len(c))], axis=-1)
        if not self._forward:
            jacobian = _inverse(jacobian)
            by_c = -jacobian @ by_c
        square = self.lens.frame.per_px(self.lens.unit_px)
        by_point = self._turn @ jacobian @ self._turn.T
        return (
            self._outside(end, ideal=False),
            by_point * square / square[:, None],
            (self._turn @ by_c) / square[:, None],
        )

    @property
    def _forward(self) -> bool:
        return self.lens.model.direction == "ideal to observed"

    @cached_property
    def _vector(self) -> Array:
        return np.array(self.lens.coefficients)

    @cached_property
    def _turn(self) -> Array:
        return np.array(self.lens.turn, dtype=np.float64)

    @cached_property
    def _reach(self) -> float:
        frame = self.lens.frame
        return REACH * frame.corner_radius * frame.radius_px / self.lens.unit_px

    def _inside(self, points_px: Array, *, ideal: bool) -> Array:
        """Pixels to normalised coordinates from the lens's centre, as the sensor lies."""
        centre = self.lens.ideal_centre if ideal else self.lens.observed_centre
        shift = 0.0 if ideal else np.array(self.shift_px)
        points = self.lens.frame.normalise(points_px - shift, self.lens.unit_px)
        return points @ self._turn - np.array(centre)

    def _outside(self, points: Array, *, ideal: bool) -> Array:
        centre = self.lens.ideal_centre if ideal else self.lens.observed_centre
        shift = 0.0 if ideal else np.array(self.shift_px)
        turned = (points + np.array(centre)) @ self._turn.T
        return self.lens.frame.to_pixels(turned, self.lens.unit_px) + shift

    def _run(self, points: Array, *, ideal: bool) -> Array:
        mapping = self.lens.model.distort if ideal else self.lens.model.undistort
        return mapping(points, self._vector, self._reach)

    def _by_coefficient(self, points: Array, index: int) -> Array:
        c = self._vector.astype(np.complex128)
        c[index] += 1j * _COMPLEX_STEP
        mapped = np.stack(self.lens.model.apply(points[:, 0], points[:, 1], c), axis=-1)
        return np.imag(mapped) / _COMPLEX_STEP


def _inverse(matrices: Array) -> Array:
    """Inverses of 2 by 2 matrices, shape (n, 2, 2)."""
    (a, b), (c, d) = np.moveaxis(matrices, 0, -1)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.stack((d, -b, -c, a), axis=-1).reshape(-1, 2, 2) / (a * d - b * c)[:, None, None]

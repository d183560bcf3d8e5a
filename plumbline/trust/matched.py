"""Matched points of an original and a corrected picture under a lens: residuals and clusters.

The corrected picture shows ideal points enlarged and shifted,

    X = place + s (p_ideal − C),                                                     (1)

C being the original's centre, for programs enlarge and crop what they correct. Scale s and
place are fitted with the lens. A lens of any model then predicts where the original shows a point
of the corrected picture. With `ptlens` this is the fit of a free quartic a r³ + b r² + c r + d
followed by restoring its gauge, the s with a s⁴ + b s³ + c s² + d s = 1.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array
from plumbline.geometry.lens import Lens
from plumbline.trust.jackknife import Jackknife

_STEP = 1e-6
"""Step of the derivatives by coefficients: the cube root of a double's precision, within 10."""

_STEP_PX = 1e-3
"""The same by pixels, over a thousand or so."""

UNSEEN = 3
"""Scale and the two shifts, which are fitted beside the coefficients."""


@dataclass(frozen=True)
class Setting:
    """A lens, and how the corrected picture shows ideal points.

    Attributes:
        lens: For photos like the original.
        scale: Pixels of the corrected picture to one of the original, at the centre's scale.
        place_px: Where the corrected picture shows the original's centre.
    """

    lens: Lens
    scale: float
    place_px: tuple[float, float]

    def observed(self, corrected_px: Array) -> Array:
        """Where the original shows points of the corrected picture, NaN beyond a fold, (n, 2)."""
        centre = np.array(self.lens.frame.centre_px)
        ideal = centre + (corrected_px - np.array(self.place_px)) / self.scale
        return self.lens.distort_or_nan(ideal)

    def corrected(self, observed_px: Array) -> Array:
        """Where the corrected picture shows points of the original, NaN beyond a fold, (n, 2)."""
        ideal = self.lens.undistort_or_nan(observed_px)
        return np.array(self.place_px) + self.scale * (ideal - np.array(self.lens.frame.centre_px))

    def moved(self, free: tuple[str, ...], step: Array) -> Setting:
        """With so much added to the free coefficients, the scale and the place."""
        values = dict(self.lens.coefficients)
        for name, by in zip(free, step[: len(free)].tolist(), strict=True):
            values[name] += by
        by_scale, by_x, by_y = step[len(free) :].tolist()
        place = (self.place_px[0] + by_x, self.place_px[1] + by_y)
        return Setting(replace(self.lens, coefficients=values), self.scale + by_scale, place)


def residual_px(setting: Setting, observed_px: Array, corrected_px: Array) -> Array:
    """Matched minus predicted points in the original, shape (n, 2); NaN beyond a fold."""
    return observed_px - setting.observed(corrected_px)


def derivatives(setting: Setting, free: tuple[str, ...], corrected_px: Array) -> Array:
    """Of the residuals by free coefficients, scale and place, shape (n, 2, k + 3)."""
    sizes = [_STEP_PX if name in ("d", "e") else _STEP for name in free]
    sizes += [_STEP, _STEP_PX, _STEP_PX]
    columns: list[Array] = []
    for index, size in enumerate(sizes):
        step = np.zeros(len(sizes))
        step[index] = size
        ahead, behind = (setting.moved(free, by).observed(corrected_px) for by in (step, -step))
        columns.append((behind - ahead) / (2 * size))
    return np.stack(columns, axis=-1)


def jackknife(
    setting: Setting,
    free: tuple[str, ...],
    observed_px: Array,
    corrected_px: Array,
    part: NDArray[np.int64],
) -> Jackknife | None:
    """Leave out the matches of one part of the photo after the other, in a Gauss–Newton step each.

    Args:
        setting: The fitted one.
        free: The coefficients fitted.
        observed_px: Matches that were fitted, in the original, shape (n, 2).
        corrected_px: The same in the corrected picture.
        part: Which part of the photo each lies in, shape (n,).

    Returns:
        None where the others do not determine the lens without some part.
    """
    slopes = derivatives(setting, free, corrected_px)
    rest = residual_px(setting, observed_px, corrected_px)
    parts = np.unique(part)
    whole = np.einsum("nik,nil->kl", slopes, slopes)
    shifts: list[Array] = []
    for each in parts:
        own, left = slopes[part == each], rest[part == each]
        normal = whole - np.einsum("nik,nil->kl", own, own)
        try:
            # The gradient of all vanishes at the minimum: that of the others is minus this.
            shifts.append(np.linalg.solve(normal, np.einsum("nik,ni->k", own, left)))
        except np.linalg.LinAlgError:
            return None
    moved = np.array(shifts)[:, : len(free)]
    if len(parts) < 2 or not np.all(np.isfinite(moved)):
        return None
    about = moved - moved.mean(axis=0)
    covariance = (len(parts) - 1) / len(parts) * about.T @ about
    return Jackknife(covariance, moved, parts)

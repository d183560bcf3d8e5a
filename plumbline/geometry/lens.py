"""A model in a frame: points in, points out, in pixels."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from math import isfinite

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plumbline.errors import FoldedError, OptionError
from plumbline.frame import Array, Frame
from plumbline.models import CENTRE, Model
from plumbline.models.inverse import REACH


def as_points(points_px: ArrayLike) -> tuple[Array, NDArray[np.bool_] | None]:
    """Points of shape (..., 2), NaN in both coordinates where one is NaN or masked.

    Returns:
        The points, and which of them are masked, shape (...); None where none can be.

    Raises:
        OptionError: these are not numbers in pairs.
    """
    try:
        points = np.array(np.ma.getdata(points_px), dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise OptionError(f"the points are not an array of numbers: {error}") from None
    if points.ndim < 1 or points.shape[-1] != 2:
        raise OptionError(
            f"the points have shape {points.shape}",
            hint="give x and y in pixels in the last axis, as in shape (n, 2)",
        )
    masked = isinstance(points_px, np.ma.MaskedArray)
    hidden = np.asarray(np.ma.getmaskarray(points_px).any(axis=-1)) if masked else None
    points[np.isnan(points).any(axis=-1)] = np.nan
    if hidden is not None:
        points[hidden] = np.nan
    return points, hidden


def _hidden_again(points: Array, hidden: NDArray[np.bool_] | None) -> Array:
    if hidden is None:
        return points
    return np.ma.masked_array(points, np.repeat(hidden[..., None], 2, axis=-1))


_DECIMAL = "check the decimal dots"
_LARGEST = 1e15
"""Of a coefficient: chosen, because k3 of a telephoto lens, in focal lengths, reaches 1e10."""

_FARTHEST = 10.0
"""Of the distortion centre, in diagonals of the photo: chosen, because a crop that shows a tenth of
the picture has its centre five away at most."""


def refuse_impossible(coefficients: Iterable[float], centre_in_diagonals: float) -> None:
    """Refuse the values of a lens that no photo was taken with, before overflow makes nonsense.

    Args:
        coefficients: Those of the model.
        centre_in_diagonals: How far the distortion centre is from the middle of the photo.

    Raises:
        OptionError: one of them is impossibly large.
    """
    if any(not abs(value) <= _LARGEST for value in coefficients):
        raise OptionError("a coefficient of the lens is impossibly large", hint=_DECIMAL)
    if not centre_in_diagonals <= _FARTHEST:
        raise OptionError(
            "the distortion centre d, e is impossibly far outside of the photo", hint=_DECIMAL
        )


@dataclass(frozen=True)
class Lens:
    """A distortion model with its coefficients, for photos of one size.

    Attributes:
        model: The distortion model.
        frame: The photo's frame.
        coefficients: All of the model's coefficients, and `d`, `e`: the distortion centre's
            offset from the image centre in the photo's own pixels.
        focal_px: Focal length in pixels, for the models that measure in it.

    Raises:
        OptionError: a coefficient is missing or not finite, or the model needs a focal length
            in pixels and has none.

    Example:
        >>> from plumbline.models import get_model
        >>> zero = {"a": 0.0, "b": -0.02, "c": 0.0, "d": 0.0, "e": 0.0}
        >>> lens = Lens(get_model("ptlens"), Frame(3001, 2001), zero)
        >>> lens.undistort([[1500.0, 1000.0]]).tolist()
        [[1500.0, 1000.0]]
    """

    model: Model
    frame: Frame
    coefficients: Mapping[str, float]
    focal_px: float | None = None

    def __post_init__(self) -> None:
        names = (*self.model.coefficients, *CENTRE)
        if set(names) != set(self.coefficients):
            raise OptionError(f"a {self.model.label} lens has the coefficients {', '.join(names)}")
        if not all(map(isfinite, self.coefficients.values())):
            raise OptionError("a coefficient of the lens is not finite")
        if self.model.unit == "focal length" and not (self.focal_px and self.focal_px > 0):
            raise OptionError(
                f"the model {self.model.label} measures in focal lengths, and none is known",
                hint="give the focal length in pixels with --focal-px, or in millimetres with "
                "--focal and --crop-factor",
            )

    @cached_property
    def unit_px(self) -> float:
        """Square pixels to a normalised radius of 1."""
        if self.model.unit == "focal length" and self.focal_px:
            return self.focal_px
        return self.frame.radius_px

    @property
    def vector(self) -> Array:
        """The model's coefficients in its order."""
        return np.array([self.coefficients[name] for name in self.model.coefficients])

    @property
    def centre_px(self) -> tuple[float, float]:
        """The distortion centre in the photo's own pixels."""
        x, y = self.frame.centre_px
        return x + self.coefficients["d"], y + self.coefficients["e"]

    def undistort(self, points_px: ArrayLike) -> Array:
        """Map observed points to ideal ones.

        Args:
            points_px: Points as picked, pixels, y down. Shape (..., 2), OpenCV's (n, 1, 2) too.

        Returns:
            Ideal points, same shape and units. A point with a coordinate that is NaN or masked
            is NaN or masked as a whole.

        Raises:
            OptionError: these are not numbers in pairs.
            FoldedError: the polynomial folds before it reaches a point.
        """
        ideal_px = self.undistort_or_nan(points_px)
        self._refuse_folded(np.ma.getdata(ideal_px), as_points(points_px)[0])
        return ideal_px

    def undistort_or_nan(self, points_px: ArrayLike) -> Array:
        """As `undistort`, but points beyond the fold become NaN."""
        given, hidden = as_points(points_px)
        points = self.frame.normalise(given, self.unit_px) - self._offset
        ideal = self.model.undistort(points, self.vector, self._reach)
        return _hidden_again(self.frame.to_pixels(ideal, self.unit_px), hidden)

    def distort(self, points_px: ArrayLike) -> Array:
        """Map ideal points to observed ones.

        Args:
            points_px: Ideal points, pixels, y down. Shape (..., 2).

        Returns:
            Points as the photograph shows them, same shape and units; as for `undistort` where
            a coordinate is NaN or masked.

        Raises:
            OptionError: these are not numbers in pairs.
            FoldedError: the polynomial folds before it reaches a point.
        """
        observed_px = self.distort_or_nan(points_px)
        self._refuse_folded(np.ma.getdata(observed_px), as_points(points_px)[0])
        return observed_px

    def distort_or_nan(self, points_px: ArrayLike) -> Array:
        """As `distort`, but points beyond the fold become NaN."""
        given, hidden = as_points(points_px)
        points = self.frame.normalise(given, self.unit_px)
        observed = self.model.distort(points, self.vector, self._reach)
        return _hidden_again(self.frame.to_pixels(observed + self._offset, self.unit_px), hidden)

    def fold_radius_px(self) -> float | None:
        """Observed radius in square pixels at which the model folds, if inside the photo.

        Folding means that two different ideal (or observed) points share one place: the
        derivative of the radial polynomial vanishes there.
        """
        fold = self.model.observed_fold(self.vector, self._reach)
        if fold is None:
            return None
        corners = self.frame.normalise(self.frame.corners_px(), self.unit_px) - self._offset
        inside = fold < np.max(np.hypot(corners[:, 0], corners[:, 1]))
        return fold * self.unit_px if inside else None

    @property
    def _offset(self) -> Array:
        centre = np.array([self.coefficients[name] for name in CENTRE])
        return centre * self.frame.per_px(self.unit_px)

    @property
    def _reach(self) -> float:
        return REACH * self.frame.corner_radius * self.frame.radius_px / self.unit_px

    def _refuse_folded(self, mapped: Array, points: ArrayLike) -> None:
        given = np.isnan(np.asarray(points, dtype=np.float64)).any(axis=-1)
        lost = np.isnan(mapped).any(axis=-1) & ~given
        if np.any(lost):
            raise FoldedError(
                f"the {self.model.label} polynomial folds before it reaches "
                f"{np.count_nonzero(lost):,} of the {lost.size:,} points",
                hint="fit with fewer free coefficients, or pick lines closer to the corners",
            )

"""A distortion model laid over one photograph: the two maps of a `Correction`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from plumbline.errors import FoldedError
from plumbline.frame import Array, Frame
from plumbline.models import Model
from plumbline.models.inverse import REACH

_LOOKED_AT = 33  # points along a side; chosen, distortion is smooth

Turn = tuple[tuple[int, int], tuple[int, int]]

UPRIGHT: Turn = ((1, 0), (0, 1))
"""The photo as it is stored."""
TURNS: dict[int, Turn] = {
    1: UPRIGHT,
    2: ((-1, 0), (0, 1)),
    3: ((-1, 0), (0, -1)),
    4: ((1, 0), (0, -1)),
    5: ((0, 1), (1, 0)),
    6: ((0, -1), (1, 0)),
    7: ((0, -1), (-1, 0)),
    8: ((0, 1), (-1, 0)),
}
"""For each EXIF orientation the matrix from the stored to the upright picture."""


@dataclass(frozen=True)
class PhotoLens:
    """A distortion model over a photograph of any size, crop and orientation.

    Attributes:
        frame: The photograph as displayed.
        model: The distortion model.
        coefficients: Those of the model, in its order.
        unit_px: Length of a normalised radius of 1 in square pixels.
        observed_centre: Offset of the distortion centre from the image centre in units of
            `unit_px`, on the observed side, in the sensor's orientation.
        ideal_centre: The same on the ideal side.
        turn: Matrix from the sensor's orientation to the displayed one.
    """

    frame: Frame
    model: Model
    coefficients: tuple[float, ...]
    unit_px: float
    observed_centre: tuple[float, float] = (0.0, 0.0)
    ideal_centre: tuple[float, float] = (0.0, 0.0)
    turn: Turn = UPRIGHT

    def distort(self, ideal_px: ArrayLike) -> Array:
        """Map ideal points to observed ones; pixels, shape (..., 2).

        Raises:
            FoldedError: the polynomial folds before it reaches a point.
        """
        return self._map(ideal_px, self.ideal_centre, self.observed_centre, self.model.distort)

    def undistort(self, observed_px: ArrayLike) -> Array:
        """Map observed points to ideal ones; pixels, shape (..., 2).

        Raises:
            FoldedError: the polynomial folds before it reaches a point.
        """
        return self._map(observed_px, self.observed_centre, self.ideal_centre, self.model.undistort)

    def largest_difference_px(self, other: PhotoLens) -> float:
        """How far two lenses differ over the photograph, but for a shift of the corrected one.

        It is infinite where one of them folds inside.
        """
        columns, rows = (np.linspace(0, side - 1, _LOOKED_AT) for side in self.frame.size)
        observed = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
        try:
            apart = self.undistort(observed) - other.undistort(observed)
        except FoldedError:
            return np.inf
        return float(np.max(np.hypot(*(apart - np.mean(apart, axis=0)).T)))

    def _map(
        self,
        points_px: ArrayLike,
        from_centre: tuple[float, float],
        to_centre: tuple[float, float],
        mapping: Callable[[Array, Any, float], Array],
    ) -> Array:
        turn = np.array(self.turn, dtype=np.float64)
        points = self.frame.normalise(points_px, self.unit_px)
        if self.turn != UPRIGHT:
            points = points @ turn
        points = points - np.array(from_centre)
        corner = self.frame.corner_radius * self.frame.radius_px / self.unit_px
        mapped = mapping(points, np.array(self.coefficients), REACH * corner)
        self._refuse_folded(mapped, points)
        mapped += np.array(to_centre)
        if self.turn != UPRIGHT:
            mapped = mapped @ turn.T
        return self.frame.to_pixels(mapped, self.unit_px)

    def _refuse_folded(self, mapped: Array, points: Array) -> None:
        known = ~np.isnan(points).any(axis=-1)
        lost = int(np.count_nonzero(np.isnan(mapped).any(axis=-1) & known))
        if lost:
            raise FoldedError(
                f"the {self.model.label} polynomial of this lens folds before it reaches "
                f"{lost:,} of the points",
                hint="the lens values do not belong to this photo; take those of another lens",
            )

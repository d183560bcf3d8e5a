"""Where pixels are: the only module that turns pixels into normalised coordinates.

Inside plumbline x runs right and y down in pixels, and (0, 0) is the centre of the top-left
pixel, so the image centre is ((w−1)/2, (h−1)/2). That is Hugin's convention. Normalised
coordinates are centred there and measured in units of R, half the shorter side (Panorama
Tools, LensFun), or of the focal length (OpenCV, Adobe).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True)
class Frame:
    """The rectangle of pixels of one photograph.

    Attributes:
        width: Pixels in a row.
        height: Pixels in a column.
        pixel_aspect: Width of one pixel over its height; 1 but for some video.
    """

    width: int
    height: int
    pixel_aspect: float = 1.0

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels."""
        return self.width, self.height

    @property
    def square_size(self) -> tuple[float, float]:
        """Width and height in units of the pixel's height: the photo at square pixels."""
        return self.width * self.pixel_aspect, float(self.height)

    @property
    def centre_px(self) -> tuple[float, float]:
        """The image centre in the photo's own pixels."""
        return (self.width - 1) / 2, (self.height - 1) / 2

    @cached_property
    def radius_px(self) -> float:
        """R, half the shorter side at square pixels: where the normalised radius is 1."""
        return min(self.square_size) / 2

    @cached_property
    def corner_radius(self) -> float:
        """Normalised radius of the photo's corners about the image centre."""
        width, height = self.square_size
        return float(np.hypot(width, height)) / 2 / self.radius_px

    def per_px(self, unit_px: float | None = None) -> Array:
        """Normalised units of one pixel across and one down, shape (2,)."""
        return np.array([self.pixel_aspect, 1.0]) / (unit_px or self.radius_px)

    def normalise(self, points_px: ArrayLike, unit_px: float | None = None) -> Array:
        """Pixels to normalised coordinates about the image centre.

        Args:
            points_px: Shape (..., 2), the photo's own pixels.
            unit_px: Length of one normalised unit in square pixels; R by default.

        Returns:
            Same shape, square, in units of `unit_px`.
        """
        points = np.asarray(points_px, dtype=np.float64)
        return (points - np.array(self.centre_px)) * self.per_px(unit_px)

    def to_pixels(self, points: ArrayLike, unit_px: float | None = None) -> Array:
        """Undo `normalise`: shape (..., 2), back to the photo's own pixels."""
        normalised = np.asarray(points, dtype=np.float64)
        return normalised / self.per_px(unit_px) + np.array(self.centre_px)

    def contains(self, points_px: ArrayLike) -> NDArray[np.bool_]:
        """Which points, shape (..., 2), lie on the photo's area. Edges of pixels count."""
        points = np.asarray(points_px, dtype=np.float64)
        x, y = points[..., 0], points[..., 1]
        across = (x >= -0.5) & (x <= self.width - 0.5)
        return across & (y >= -0.5) & (y <= self.height - 0.5)

    def corners_px(self) -> Array:
        """Centres of the four corner pixels, shape (4, 2)."""
        right, bottom = self.width - 1.0, self.height - 1.0
        return np.array([[0.0, 0.0], [right, 0.0], [right, bottom], [0.0, bottom]])


def normalised(
    points_px: Array, frames: Sequence[Frame], which: NDArray[np.int64], units_px: Sequence[float]
) -> Array:
    """`Frame.normalise` for points of many photos at once.

    Args:
        points_px: Shape (n, 2), each in its own photo's pixels.
        frames: The photos.
        which: Photo of each point, shape (n,).
        units_px: Length of one normalised unit in square pixels, for each photo.
    """
    centres = np.array([frame.centre_px for frame in frames])
    sides = np.array([(frame.pixel_aspect, 1.0) for frame in frames])
    return (points_px - centres[which]) * (sides / np.array(units_px)[:, None])[which]

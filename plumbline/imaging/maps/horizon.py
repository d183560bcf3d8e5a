"""How far out a corrected picture shows anything: up to where the distortion folds.

Beyond a fold a polynomial comes back and shows parts of the photograph again, or has no answer
at all. Looked at along rays from the picture's centre, each is followed until the observed
point no longer moves outwards.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plumbline.errors import FoldedError
from plumbline.frame import Array

Points = Callable[[Array], Array]

_RAYS = 32  # chosen: the horizon of a shifted centre is smooth
_SAMPLES = 256  # points along a ray; chosen, one in every few pixels of a fold's width
_BISECTIONS = 20  # halves the longest ray of 2^15 px down to 0.03 px
_MARGIN_PX = 0.5  # keeps kernels off the fold itself; chosen, half a pixel


@dataclass(frozen=True)
class Horizon:
    """The part of the ideal plane that the lens shows, star-shaped about a centre.

    Attributes:
        centre_px: Where the rays begin, shape (2,).
        radii_px: Length of the rays, at equal angles from 0; the last repeats the first.
    """

    centre_px: Array
    radii_px: Array

    def contains(self, points_px: Array) -> NDArray[np.bool_]:
        """Which ideal points, shape (..., 2), lie within."""
        away = points_px - self.centre_px
        turn = np.arctan2(away[..., 1], away[..., 0]) % (2 * np.pi)
        angles = np.linspace(0, 2 * np.pi, len(self.radii_px))
        return np.hypot(away[..., 0], away[..., 1]) <= np.interp(turn, angles, self.radii_px)


def find_horizon(mapping: Points, size: tuple[int, int]) -> Horizon:
    """Follow the rays of a picture of this size.

    Args:
        mapping: Ideal points to observed ones; may raise FoldedError.
        size: Width and height in pixels.
    """
    centre = (np.array(size) - 1) / 2
    longest = float(np.hypot(*size)) / 2 + 1
    angles = np.linspace(0, 2 * np.pi, _RAYS + 1)
    radii = [
        _length(mapping, centre, np.array([np.cos(angle), np.sin(angle)]), longest)
        for angle in angles[:-1]
    ]
    return Horizon(centre, np.maximum(np.array([*radii, radii[0]]) - _MARGIN_PX, 0))


def _length(mapping: Points, centre: Array, direction: Array, longest: float) -> float:
    """How far one ray goes before it folds, at most `longest` pixels."""
    low, high = 0.0, longest
    if _rises(mapping, centre, direction, high):
        return high
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2
        if _rises(mapping, centre, direction, middle):
            low = middle
        else:
            high = middle
    return low


def _rises(mapping: Points, centre: Array, direction: Array, length: float) -> bool:
    try:
        observed = mapping(centre + np.linspace(0, length, _SAMPLES)[:, None] * direction)
    except FoldedError:
        return False
    return bool(np.all(np.diff(observed @ direction) > 0))

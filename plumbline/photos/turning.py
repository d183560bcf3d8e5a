"""Pixels turned upright, as EXIF's orientation says."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def turned_upright(pixels: NDArray[Any], orientation: int) -> NDArray[Any]:
    """Pixels as stored, turned as a viewer shows them.

    Args:
        pixels: Shape (rows, columns) or (rows, columns, channels).
        orientation: EXIF's, from 1 to 8 (CIPA DC-008, tag 274).
    """
    if orientation in (5, 6, 7, 8):
        pixels = pixels.swapaxes(0, 1)
    if orientation in (2, 3, 6, 7):
        pixels = pixels[:, ::-1]
    if orientation in (3, 4, 7, 8):
        pixels = pixels[::-1]
    return np.ascontiguousarray(pixels)

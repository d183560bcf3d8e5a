"""Pictures as searches take them: brightness alone, sampled anywhere."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from plumbline.errors import OptionError
from plumbline.frame import Array

Grey = NDArray[np.float32]

_SIXTEEN_BITS = 257.0
"""Grey levels of 16 bits to one of 8."""

_COLOURS = (3, 4)
"""Channels of RGB and RGBA."""
_TYPES = ("uint8", "uint16", "float32", "float64")


def brightness(image: NDArray[Any]) -> Grey:
    """A picture's brightness in grey levels from 0 to 255, shape (h, w).

    Args:
        image: 8 or 16 bits, or real numbers from 0 to 255: grey (h, w), or blue, green, red
            (h, w, 3), a fourth channel being left aside.

    Raises:
        OptionError: the array is something else.
    """
    values = np.asarray(image)
    channels = values.shape[2] if values.ndim == 3 else 1
    if values.ndim not in (2, 3) or channels not in (1, *_COLOURS) or not values.size:
        raise OptionError(
            f"an array of shape {values.shape} is not a picture",
            hint="give grey values as (height, width), or colours as (height, width, 3)",
        )
    if values.dtype.name not in _TYPES:
        raise OptionError(
            f"a picture cannot have values of type {values.dtype}",
            hint="convert it to 8 bits (numpy.uint8)",
        )
    grey: Any = values
    if channels in _COLOURS:
        grey = cv2.cvtColor(values[..., :3].astype(np.float32), cv2.COLOR_BGR2GRAY)
    elif values.ndim == 3:
        grey = values[..., 0]
    whole = np.ascontiguousarray(grey, dtype=np.float32)
    if values.dtype == np.uint16:
        whole = whole / np.float32(_SIXTEEN_BITS)
    if not np.isfinite(whole).all():
        raise OptionError("the picture holds values that are not finite")
    return whole


def sampled(grey: Grey, points: Array) -> Grey:
    """Brightness at points (x, y), shape (..., 2), between pixels by bilinear interpolation."""
    x, y = (points[..., k].astype(np.float32).reshape(-1, points.shape[-2]) for k in (0, 1))
    parts: list[Grey] = []
    for first in range(0, len(x), _MOST_ROWS):
        rows = slice(first, first + _MOST_ROWS)
        seen = cv2.remap(grey, x[rows], y[rows], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        parts.append(np.asarray(seen, dtype=np.float32))
    if not parts:
        return np.zeros(points.shape[:-1], dtype=np.float32)
    return np.concatenate(parts).reshape(points.shape[:-1])


_MOST_ROWS = 30_000
"""OpenCV's `remap` takes at most 32,767 rows."""

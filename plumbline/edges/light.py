"""Linear light from the values that a photograph stores.

Stored values bend light by the sRGB curve (IEC 61966-2-1). A blur that grows outwards shifts the
middle of an edge there, but not in linear light: on a rendered edge it feigned a sag of 0.25 px
in stored values and 0.004 px in linear light.
"""

from __future__ import annotations

from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

Light = NDArray[np.float32]
Channel = Literal["red", "green", "blue"]

CLIPPED = 0.985
"""Linear light from which a value counts as clipped: 253.2 of 255, beyond what JPEG leaves of 255
where it is next to an edge (chosen, because quality 85 moved 255 by up to 2)."""

_WEIGHTS = (0.0722, 0.7152, 0.2126)
"""Blue, green and red in luminance (ITU-R BT.709)."""

_PLACE = {"blue": 0, "green": 1, "red": 2}


def linear_light(pixels: NDArray[Any]) -> Light:
    """Luminance in linear light, 0 to 1, shape (rows, columns).

    Args:
        pixels: As a photograph stores them, 8 or 16 bit: grey (rows, columns), grey and alpha
            (…, 2), blue, green, red (…, 3) or with alpha (…, 4).
    """
    if pixels.ndim == 2 or pixels.shape[2] <= 2:
        return _straightened(pixels if pixels.ndim == 2 else pixels[..., 0])
    light = _WEIGHTS[0] * _straightened(pixels[..., 0])
    for weight, channel in zip(_WEIGHTS[1:], (1, 2), strict=True):
        light += weight * _straightened(pixels[..., channel])
    return light


def linear_channel(pixels: NDArray[Any], name: Channel) -> Light:
    """One colour in linear light, 0 to 1, shape (rows, columns); `pixels` have three colours."""
    return _straightened(pixels[..., _PLACE[name]])


def _straightened(values: NDArray[Any]) -> Light:
    most = np.iinfo(values.dtype).max
    stored = np.arange(most + 1, dtype=np.float64) / most
    table = np.where(stored <= 0.04045, stored / 12.92, ((stored + 0.055) / 1.055) ** 2.4)
    table = table.astype(np.float32)
    if values.dtype == np.uint8:
        return np.asarray(cv2.LUT(np.ascontiguousarray(values), table), dtype=np.float32)
    return table[values]

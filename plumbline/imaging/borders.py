"""What stands where a corrected photo shows nothing."""

from __future__ import annotations

import cv2
import numpy as np

from plumbline.imaging.resample import Border
from plumbline.photos.files.picture import Pixels


def outside_of(
    border: Border, channels: int, full: float, *, alpha: bool, inks: bool
) -> tuple[float, ...] | None:
    """The value of each channel where the photo shows nothing; None to repeat its edge."""
    if border == "edge":
        return None
    if border == "transparent":
        return (0.0,) * channels
    if inks:
        return 0.0, 0.0, 0.0, full if border == "black" else 0.0
    colour = full if border == "white" else 0.0
    return (colour,) * (channels - 1) + (full if alpha else colour,)


def with_alpha(pixels: Pixels) -> Pixels:
    """The pixels with an opaque alpha channel; 16-bit grey becomes colour, for its files."""
    if pixels.ndim == 3 and pixels.shape[2] in (2, 4):
        return pixels
    if pixels.ndim == 3:
        return cv2.cvtColor(pixels, cv2.COLOR_BGR2BGRA)
    if pixels.dtype == np.uint16:
        return cv2.cvtColor(pixels, cv2.COLOR_GRAY2BGRA)
    return np.stack((pixels, np.full_like(pixels, np.iinfo(pixels.dtype).max)), axis=-1)

"""The comparison picture of the literature: what a correction changed, dark on white."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from PIL import Image

from plumbline.photos.files.encode import encode
from plumbline.photos.files.metadata import Metadata, note_of
from plumbline.photos.files.picture import Picture, Pixels


def difference_png(before: Picture, after: Picture, target: Path) -> bytes:
    """A PNG, white where nothing changed: 255 less the absolute difference of the greys."""
    gap = cv2.absdiff(_grey(before), _grey(after))
    metadata = Metadata(exif=before.metadata.exif)
    picture = replace(before, pixels=cv2.bitwise_not(gap), inks=False, metadata=metadata)
    return encode(picture, target, 100, note_of("the difference from the original"))[0]


def _grey(picture: Picture) -> Pixels:
    """The picture in 8-bit grey."""
    pixels: Any = picture.pixels
    if picture.inks:
        pixels = np.asarray(Image.fromarray(pixels, "CMYK").convert("L"))
    elif pixels.ndim == 3:
        pixels = pixels[..., 0] if pixels.shape[2] == 2 else _luma(pixels)
    return (pixels >> 8).astype(np.uint8) if pixels.dtype == np.uint16 else pixels


def _luma(pixels: Pixels) -> Pixels:
    return cv2.cvtColor(pixels[..., :3], cv2.COLOR_BGR2GRAY)

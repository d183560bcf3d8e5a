"""Square pieces of a photo for the page, as it is or corrected, in the colours of the screen."""

from __future__ import annotations

import io
from functools import lru_cache
from typing import Any

import cv2
import numpy as np
from PIL import Image, ImageCms

from plumbline.errors import OptionError, ReadError
from plumbline.frame import Array
from plumbline.geometry.lens import Lens
from plumbline.pick.photos import Level, LoadedPhoto, Pixels

SIDE = 512
"""Pixels of a tile's side. Chosen, because a screen then needs about 12 of 20 ms each."""

_QUALITY = 92
"""Of JPEG, with colours at full resolution, so that edges are not bent by the coding."""

_NODES = 33
"""Places a side at which a corrected tile is computed; between them it is interpolated. The
largest error on an action camera (−20 % at the corner) is 0.02 px of the tile."""


def tile(photo: LoadedPhoto, number: int, column: int, row: int, lens: Lens | None) -> bytes:
    """One tile as JPEG.

    Args:
        photo: The photo.
        number: Level of the pyramid.
        column: Counted from 0 at the left.
        row: Counted from 0 at the top.
        lens: Show the photo corrected with this lens; None for the photo as it is.

    Raises:
        OptionError: there is no such tile.
        ReadError: the photo cannot be decoded.
    """
    if not 0 <= number < photo.n_levels:
        raise OptionError(f"there is no level {number}")
    width, height = (-(-side // 2**number) for side in photo.size)
    if not (0 <= column * SIDE < width and 0 <= row * SIDE < height):
        raise OptionError(f"there is no tile {column}, {row} of level {number}")
    level = photo.level(number)
    left, top = column * SIDE, row * SIDE
    right, bottom = min(left + SIDE, width), min(top + SIDE, height)
    if lens is None:
        piece = level.pixels[top:bottom, left:right]
    else:
        places = _sources(photo, lens, number, (left, top, right, bottom))
        piece = _sampled(level, places)
    return _jpeg(_on_screen(np.ascontiguousarray(piece), level.mode, photo.icc))


def _sampled(level: Level, places: Array) -> Pixels:
    """Pixels of a level at places of shape (rows, columns, 2); nothing outside."""
    across, down = (np.ascontiguousarray(places[..., axis], dtype=np.float32) for axis in (0, 1))
    # OpenCV's remap takes pictures of fewer than 32,767 pixels a side: cut out what is needed.
    rows, columns = level.pixels.shape[:2]
    known = np.isfinite(across) & np.isfinite(down)
    if not known.any():
        return np.zeros((*places.shape[:2], *level.pixels.shape[2:]), dtype=np.uint8)
    left = int(np.clip(np.floor(across[known].min()) - 2, 0, columns - 1))
    top = int(np.clip(np.floor(down[known].min()) - 2, 0, rows - 1))
    right = int(np.clip(np.ceil(across[known].max()) + 3, left + 1, columns))
    bottom = int(np.clip(np.ceil(down[known].max()) + 3, top + 1, rows))
    piece = np.ascontiguousarray(level.pixels[top:bottom, left:right])
    return np.asarray(
        cv2.remap(piece, across - left, down - top, cv2.INTER_LINEAR, borderValue=(0, 0, 0, 0))
    )


def _sources(photo: LoadedPhoto, lens: Lens, number: int, box: tuple[int, int, int, int]) -> Array:
    """Where in a level the pixels of a corrected tile are taken from, (rows, columns, 2)."""
    left, top, right, bottom = box
    scale = np.array([side / -(-side // 2**number) for side in photo.size])
    x = np.linspace(left, right - 1, _NODES)
    y = np.linspace(top, bottom - 1, _NODES)
    wanted = (np.stack(np.meshgrid(x, y), axis=-1) + 0.5) * scale - 0.5
    observed = (lens.distort_or_nan(wanted) + 0.5) / scale - 0.5
    columns, rows = np.meshgrid(
        np.linspace(0, _NODES - 1, right - left, dtype=np.float32),
        np.linspace(0, _NODES - 1, bottom - top, dtype=np.float32),
    )
    across, down = (
        cv2.remap(observed[..., axis].astype(np.float32), columns, rows, cv2.INTER_LINEAR)
        for axis in (0, 1)
    )
    return np.stack((across, down), axis=-1).astype(np.float64)


@lru_cache(maxsize=4)
def _to_screen(icc: bytes, mode: str) -> Any:
    """Pillow's transform from a colour profile to sRGB; None where there is none to make."""
    if not icc:
        return None
    try:
        profile = ImageCms.ImageCmsProfile(io.BytesIO(icc))
        return ImageCms.buildTransform(profile, ImageCms.createProfile("sRGB"), mode, "RGB")
    except (ImageCms.PyCMSError, OSError, ValueError):
        return None  # a damaged profile: the photo's own values are shown


def _on_screen(pixels: Pixels, mode: str, icc: bytes) -> Pixels:
    """The same pixels for the screen: blue, green, red in sRGB, or grey."""
    named = "RGB" if mode == "BGR" else mode
    transform = _to_screen(icc, named)
    if transform is None and mode != "CMYK":
        return pixels
    shown: Any = Image.fromarray(pixels[..., ::-1].copy() if mode == "BGR" else pixels, named)
    shown = shown.convert("RGB") if transform is None else ImageCms.applyTransform(shown, transform)
    return np.asarray(shown)[..., ::-1].copy()


def _jpeg(pixels: Pixels) -> bytes:
    how = [cv2.IMWRITE_JPEG_QUALITY, _QUALITY]
    how += [cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444]
    done, data = cv2.imencode(".jpg", pixels, how)
    if not done:
        raise ReadError("a tile cannot be encoded")
    return data.tobytes()

"""A rectified picture beside others on the same ground: grids shared, overlays, mosaics.

The overlay is the literature's: the aerial picture in red, the rectified photo in green, so that
what agrees is yellow. In a mosaic each picture weighs by how far a pixel is from its edge.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from plumbline.errors import OptionError
from plumbline.files import read_bytes
from plumbline.frame import Array
from plumbline.ground.world_file import read_world
from plumbline.photos.files.encode import encode
from plumbline.photos.files.metadata import Metadata, note_of
from plumbline.photos.files.picture import Picture, Pixels, Storage, decode
from plumbline.rectified.grid import Grid
from plumbline.rectified.picture import RectifiedPicture

_FEATHER_PX = 64.0
"""Pixels from its edge at which a picture of a mosaic weighs fully; chosen."""


def grid_like(path: str) -> Grid:
    """The grid of a picture with a world file.

    Raises:
        ReadError: it has none, or cannot be read.
    """
    pixels = decode(read_bytes(path), path).pixels
    return Grid(read_world(path), (pixels.shape[1], pixels.shape[0]))


def overlay(rectified: RectifiedPicture, aerial: str) -> Picture:
    """The aerial picture in red and the rectified one in green, on the grid of the latter.

    Raises:
        ReadError: the aerial picture has no world file, or cannot be read.
        OptionError: the two show no common ground.
    """
    green = _grey(rectified.rendered.pixels)
    red, shown = _onto(rectified.grid, aerial)
    both = shown & rectified.rendered.shown
    if not both.any():
        raise OptionError(
            f"{aerial} and the photo show no common ground",
            hint="check its world file, or give another --extent",
        )
    pixels = np.zeros((*green.shape, 3), np.uint8)
    pixels[..., 2] = np.where(shown, red, 0)
    pixels[..., 1] = np.where(rectified.rendered.shown, green, 0)
    return Picture(pixels, inks=False, metadata=Metadata(), storage=Storage("PNG"))


def overlay_bytes(rectified: RectifiedPicture, aerial: str, target: Path) -> bytes:
    """The overlay as a picture file."""
    return encode(
        overlay(rectified, aerial), target, 95, note_of("compared with an aerial picture")
    )[0]


def mosaic(rectified: RectifiedPicture, other: str) -> Picture:
    """The rectified picture blended with another on the same grid, softly at their edges.

    Raises:
        OptionError: the other has another size, depth or number of colours.
    """
    theirs = decode(read_bytes(other), other)
    colours, shown = _colours(theirs)
    ours, _ = _colours(rectified.picture)
    if ours.shape != colours.shape or ours.dtype != colours.dtype:
        raise OptionError(
            f"{other} has another size, depth or number of colours",
            hint="give the picture of --grid-like that plumbline rectified",
        )
    weights = [_inwards(each) for each in (rectified.rendered.shown, shown)]
    total = np.maximum(weights[0] + weights[1], 1e-9)
    shares = [weight / total for weight in weights]
    if ours.ndim == 3:
        shares = [share[..., None] for share in shares]
    blended = shares[0] * ours + shares[1] * colours
    pixels = np.rint(blended).astype(ours.dtype)
    if rectified.picture.alpha:
        full = np.iinfo(pixels.dtype).max
        alpha = np.where(rectified.rendered.shown | shown, full, 0).astype(pixels.dtype)
        pixels = np.dstack((pixels, alpha))
    return replace(rectified.picture, pixels=pixels)


def _colours(picture: Picture) -> tuple[Pixels, NDArray[np.bool_]]:
    """Colours without alpha, and where the picture shows anything."""
    pixels = picture.pixels
    if picture.alpha:
        alpha = np.asarray(pixels[..., -1] > 0)
        bare = pixels[..., :-1]
        return (bare[..., 0] if bare.shape[2] == 1 else bare), alpha
    shown = np.asarray(pixels.any(axis=-1) if pixels.ndim == 3 else pixels > 0)
    return pixels, shown


def _inwards(shown: NDArray[np.bool_]) -> Array:
    """Weight of each pixel by its distance from the edge of what is shown."""
    padded = np.pad(shown, 1).astype(np.uint8)
    away = cv2.distanceTransform(padded, cv2.DIST_L2, 5)[1:-1, 1:-1]
    return np.minimum(np.asarray(away, dtype=np.float64) / _FEATHER_PX, 1.0)


def _onto(grid: Grid, path: str) -> tuple[Pixels, NDArray[np.bool_]]:
    """A picture with a world file, grey, laid over a grid; and where it shows anything."""
    world = read_world(path)
    grey = _grey(decode(read_bytes(path), path).pixels)
    width, height = grid.size
    columns, rows = np.meshgrid(np.arange(width, dtype=float), np.arange(height, dtype=float))
    at = world.pixels(grid.world.places(np.stack((columns, rows), axis=-1)))
    x, y = at[..., 0].astype(np.float32), at[..., 1].astype(np.float32)
    laid = cv2.remap(grey, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    inside = (x >= -0.5) & (x <= grey.shape[1] - 0.5) & (y >= -0.5) & (y <= grey.shape[0] - 0.5)
    return np.asarray(laid), inside


def _grey(pixels: Pixels) -> NDArray[np.uint8]:
    """8-bit grey values of any picture."""
    if pixels.dtype == np.uint16:
        pixels = (pixels >> 8).astype(np.uint8)
    if pixels.ndim == 2:
        return pixels
    if pixels.shape[2] == 2:
        return np.ascontiguousarray(pixels[..., 0])
    grey = cv2.cvtColor(np.ascontiguousarray(pixels[..., :3]), cv2.COLOR_BGR2GRAY)
    return np.asarray(grey, dtype=np.uint8)

"""Take the pixels of a picture from elsewhere, tile by tile.

OpenCV's cubic kernel has a = −0.75 and so moves what it draws by up to 0.05 px, depending on
the place t between two pixels: its first moment is t³ − 1.5 t² + 1.5 t instead of t. Here it is
asked for the place whose moment is the wanted one, which leaves straight ramps straight. That
OpenCV rounds places to 1/32 px, with Lanczos and before version 5, has no bias.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Literal, get_args

import cv2
import numpy as np
from numpy.typing import NDArray

from plumbline.imaging.maps.sampling_map import Coordinates, SamplingMap, Tile

Pixels = NDArray[Any]
Interpolation = Literal["nearest", "linear", "cubic", "lanczos"]
Border = Literal["black", "white", "transparent", "edge"]

INTERPOLATIONS: tuple[Interpolation, ...] = get_args(Interpolation)
BORDERS: tuple[Border, ...] = get_args(Border)

_FLAGS = {
    "nearest": cv2.INTER_NEAREST,
    "linear": cv2.INTER_LINEAR,
    "cubic": cv2.INTER_CUBIC,
    "lanczos": cv2.INTER_LANCZOS4,
}
_KERNEL = 5  # pixels that the widest kernel reaches, and one for rounding
_UNBIASED = (1.307366, -1.941807, 2.849372)
"""Odd polynomial for u of u³ + 0.75 u = s, |s| ≤ 1/2, good to 0.0016 and exact at the ends."""


def resample(
    pixels: Pixels,
    sampling: SamplingMap,
    interpolation: Interpolation = "cubic",
    outside: tuple[float, ...] | None = None,
    *,
    alpha: bool = False,
    threads: int | None = None,
) -> Pixels:
    """Pixels taken from where the map says.

    Args:
        pixels: Shape (rows, columns) or (rows, columns, channels), 8 or 16 bit.
        sampling: The map, of the same size.
        interpolation: The interpolation method.
        outside: Value of each channel where the picture shows nothing; None repeats its edge.
        alpha: Whether the last channel is alpha; then colours are weighted by it.
        threads: Number of threads; one a core by default.

    Returns:
        The corrected picture, same shape and type.
    """
    result = np.empty_like(pixels)
    sampling.prepare()

    def fill(tile: Tile) -> None:
        x, y = sampling.coordinates(tile)
        result[tile] = one_tile(pixels, x, y, interpolation, outside, alpha=alpha)

    with ThreadPoolExecutor(threads or cores()) as pool:
        for _ in pool.map(fill, sampling.tiles()):
            pass
    return result


def cores() -> int:
    """Number of processor cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def one_tile(
    pixels: Pixels,
    x: NDArray[np.float32],
    y: NDArray[np.float32],
    interpolation: Interpolation,
    outside: tuple[float, ...] | None,
    *,
    alpha: bool,
) -> Pixels:
    """The pixels of one tile; see `resample`. The coordinates x and y, float32, are changed."""
    height, width = pixels.shape[:2]
    left, right = _reach(x, width)
    top, bottom = _reach(y, height)
    part = pixels[top:bottom, left:right]
    x -= np.float32(left)
    y -= np.float32(top)
    lost = None if outside is None else _outside(x, y, (left, top), (width, height))
    if interpolation == "cubic":
        _unbias(x)
        _unbias(y)
    weighted = alpha and interpolation != "nearest" and not _opaque(part)
    tile = (_weighted_by_alpha if weighted else _remap)(part, (x, y), interpolation)
    if lost is not None:
        tile[lost] = np.array(outside, dtype=pixels.dtype)
    return tile


def _outside(
    x: NDArray[np.float32], y: NDArray[np.float32], first: tuple[int, int], size: tuple[int, int]
) -> NDArray[np.bool_] | None:
    """Which coordinates, counted from a pixel of the picture, leave its area; None if none do."""
    lost = None
    for at, start, side in zip((x, y), first, size, strict=True):
        low, high = -0.5 - start, side - 0.5 - start
        if at.min() < low or at.max() > high:
            beyond = (at < low) | (at > high)
            lost = beyond if lost is None else lost | beyond
    return lost


def _unbias(at: NDArray[np.float32]) -> None:
    """Move coordinates, in place, to where OpenCV's cubic kernel has the wanted moment."""
    at -= np.float32(0.5)
    whole = np.rint(at)
    at -= whole
    square = at * at
    shift = square * np.float32(_UNBIASED[2])
    shift += np.float32(_UNBIASED[1])
    shift *= square
    shift += np.float32(_UNBIASED[0])
    at *= shift
    at += whole
    at += np.float32(0.5)


def _reach(at: NDArray[np.float32], side: int) -> tuple[int, int]:
    """The rows or columns that a tile needs, at least one."""
    first, last = (float(np.clip(end, 0, side - 1)) for end in (at.min(), at.max()))
    return max(int(first) - _KERNEL, 0), min(int(last) + 1 + _KERNEL, side)


def _opaque(pixels: Pixels) -> bool:
    return bool(pixels[..., -1].min() == np.iinfo(pixels.dtype).max)


def _remap(pixels: Pixels, at: Coordinates, interpolation: Interpolation) -> Pixels:
    flag = _FLAGS[interpolation]
    return cv2.remap(pixels, *at, interpolation=flag, borderMode=cv2.BORDER_REPLICATE)


def _weighted_by_alpha(pixels: Pixels, at: Coordinates, interpolation: Interpolation) -> Pixels:
    """Remap with colours counting by their opacity, so that hidden ones do not bleed."""
    full = float(np.iinfo(pixels.dtype).max)
    layers = pixels.astype(np.float32)
    layers[..., :-1] *= layers[..., -1:] / full
    moved = _remap(layers, at, interpolation)
    opacity = np.clip(moved[..., -1:], 0, full)
    moved[..., :-1] *= full / np.maximum(opacity, 0.5)
    moved[..., -1:] = opacity
    return np.clip(np.rint(moved), 0, full).astype(pixels.dtype)

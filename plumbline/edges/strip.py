"""A strip of a photo along a curve, straightened: one row a stretch of the curve.

Pixels are read at whole pixels of the curve's own axis and interpolated across it only, by a
cubic with exact weights. OpenCV's remap places its samples to 1/32 px, which moves an edge that
follows the axis by up to 0.016 px.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plumbline.edges.guide import Guide
from plumbline.edges.light import Light
from plumbline.frame import Array


@dataclass(frozen=True, eq=False)
class Strip:
    """Linear light along a curve and across it.

    Attributes:
        values: Shape (rows, m): means over stretches of the curve, NaN outside the photo.
        offset: Places across the curve, in pixels of the photo's other axis, shape (m,).
        along: Middle of each stretch on the curve's axis, shape (rows,).
        length: Pixels along the axis in each stretch, shape (rows,).
    """

    values: Light
    offset: Array
    along: Array
    length: Array

    @property
    def step(self) -> float:
        """Pixels from one column to the next."""
        return float(self.offset[1] - self.offset[0])


def cut(image: Light, guide: Guide, reach_px: int, rows: int, per_px: int = 1) -> Strip:
    """Cut the strip along a curve.

    Args:
        image: Linear light, shape (height, width).
        guide: The curve.
        reach_px: Pixels to either side.
        rows: Number of stretches that the curve is divided into.
        per_px: Columns a pixel.
    """
    plane = image.T if guide.steep else image
    base = np.floor(guide.across).astype(np.int64)
    part = guide.across - base
    near = base[:, None] + np.arange(-reach_px - 1, reach_px + 4)
    outside = (near < 0) | (near >= len(plane))
    columns = guide.first + np.arange(len(base))
    raw = plane[np.clip(near, 0, len(plane) - 1), columns[:, None]]
    if outside.any():
        raw[outside] = np.nan
    ends = np.linspace(0, len(base), min(rows, len(base)) + 1).astype(np.int64)
    length = np.diff(ends).astype(np.float64)
    values = np.empty((len(length), (2 * reach_px + 1) * per_px), dtype=np.float32)
    for number in range(per_px):
        fine = _interpolated(raw, part + number / per_px)
        values[:, number::per_px] = np.add.reduceat(fine, ends[:-1]) / length[:, None]
    offset = np.arange(values.shape[1]) / per_px - reach_px
    middle = guide.first + (ends[:-1] + ends[1:] - 1) / 2
    return Strip(values, offset, middle, length)


def _interpolated(raw: Light, part: Array) -> Light:
    """Values at a part of a pixel, 0 to 2, beyond the second column of each row (Keys 1981)."""
    whole = part >= 1
    raw = np.where(whole[:, None], raw[:, 1:], raw[:, :-1])
    t = (part - whole)[:, None].astype(np.float32)
    weights = (
        ((2 - t) * t - 1) * t / 2,
        ((3 * t - 5) * t * t + 2) / 2,
        ((4 - 3 * t) * t + 1) * t / 2,
        (t - 1) * t * t / 2,
    )
    width = raw.shape[1] - 3
    total = (weights[0] * raw[:, :width]).astype(np.float32)
    for shift, weight in enumerate(weights[1:], start=1):
        total += weight * raw[:, shift : shift + width]
    return total


def filtered(strip: Strip, kernel: Array) -> tuple[NDArray[np.float64], Array]:
    """Every row correlated with a kernel of odd length, and the places its values stand for.

    NaN where the kernel reaches out of the photo.
    """
    windows = np.lib.stride_tricks.sliding_window_view(strip.values, len(kernel), axis=1)
    half = len(kernel) // 2
    return windows @ kernel, strip.offset[half : len(strip.offset) - half]

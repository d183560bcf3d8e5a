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

_TAPS = 5
"""Pixels that a cubic at a part of a pixel up to 2 reaches over."""


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
    ends = np.linspace(0, len(base), min(rows, len(base)) + 1).astype(np.int64)
    length = np.diff(ends).astype(np.float64)
    # Stretches of one length, the shorter filled up with their last pixel, which weighs nothing.
    within = np.arange(int(length.max()))
    at = np.minimum(ends[:-1, None] + within, ends[1:, None] - 1)
    weighs = (within < length[:, None]) / length[:, None]
    values = np.empty((len(length), (2 * reach_px + 1) * per_px), dtype=np.float32)
    stretches = raw[at]
    for number in range(per_px):
        weights = _weights(part[at] + number / per_px) * weighs[:, None]
        mean = _summed(weights.astype(np.float32) @ stretches)
        if outside.any():
            missing = _summed((weights != 0).astype(np.float32) @ outside[at].astype(np.float32))
            mean[missing > 0] = np.nan
        values[:, number::per_px] = mean
    offset = np.arange(values.shape[1]) / per_px - reach_px
    middle = guide.first + (ends[:-1] + ends[1:] - 1) / 2
    return Strip(values, offset, middle, length)


def _summed(taps: Light) -> Light:
    """What taps make of the pixels that each of them is moved to, (rows, 5, n) to (rows, n − 4)."""
    width = taps.shape[2] - _TAPS + 1
    total = taps[:, 0, :width].copy()
    for tap in range(1, _TAPS):
        total += taps[:, tap, tap : tap + width]
    return total


def _weights(part: Array) -> Array:
    """What pixels weigh at a part of a pixel, 0 to 2, beyond the second (Keys 1981).

    Args:
        part: Shape (rows, n).

    Returns:
        Shape (rows, 5, n).
    """
    whole = part >= 1
    t = part - whole
    weights = (
        ((2 - t) * t - 1) * t / 2,
        ((3 * t - 5) * t * t + 2) / 2,
        ((4 - 3 * t) * t + 1) * t / 2,
        (t - 1) * t * t / 2,
    )
    out = np.zeros((part.shape[0], _TAPS, part.shape[1]))
    for tap, weight in enumerate(weights):
        out[:, tap] += np.where(whole, 0.0, weight)
        out[:, tap + 1] += np.where(whole, weight, 0.0)
    return out


def filtered(strip: Strip, kernel: Array) -> tuple[NDArray[np.float64], Array]:
    """Every row correlated with a kernel of odd length, and the places its values stand for.

    NaN where the kernel reaches out of the photo.
    """
    import cv2

    half = len(kernel) // 2
    inside = slice(half, len(strip.offset) - half)
    # One dimension at a time: OpenCV's other filter goes through frequencies, which NaN floods.
    values = cv2.sepFilter2D(strip.values, cv2.CV_64F, kernel, np.ones(1))
    return np.asarray(values[:, inside], dtype=np.float64), strip.offset[inside]

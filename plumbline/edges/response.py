"""What an edge, a groove or a change of either sign answers to, and how sure an answer is.

A step answers to the first derivative of a Gaussian, a groove or a wire to the second
(J. Canny, "A computational approach to edge detection", 1986; C. Steger, "An unbiased detector
of curvilinear structures", 1998).
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from plumbline.edges.strip import Strip, filtered
from plumbline.frame import Array

Kind = Literal["rising", "falling", "either", "dark", "bright"]
"""Light that rises or falls across the curve, that does one here and the other there, a groove,
and a wire."""

KINDS: tuple[Kind, ...] = ("rising", "falling", "dark", "bright", "either")

_SIGN: dict[Kind, float] = {"rising": 1.0, "falling": -1.0, "dark": 1.0, "bright": -1.0}
_MAD = 1.4826
"""Standard deviation of normal numbers over their median absolute deviation."""


def derivative(scale_px: float, step: float) -> Array:
    """Kernel whose correlation is the first derivative of light blurred by a Gaussian."""
    reach = int(np.ceil(3.5 * scale_px / step))
    at = np.arange(-reach, reach + 1) * step
    kernel = at * np.exp(-0.5 * (at / scale_px) ** 2)
    return kernel / (kernel @ at)


def second_derivative(scale_px: float, step: float) -> Array:
    """Kernel whose correlation is the second derivative of light blurred by a Gaussian."""
    reach = int(np.ceil(4 * scale_px / step))
    at = np.arange(-reach, reach + 1) * step
    bell = np.exp(-0.5 * (at / scale_px) ** 2)
    kernel = (at**2 / scale_px**2 - 1) * bell
    kernel -= kernel.mean()
    return kernel / (kernel @ at**2 / 2)


def answer(strip: Strip, kind: Kind, scale_px: float) -> tuple[Array, Array]:
    """How strongly each place of a strip is of a kind, shape (rows, k), and the places, (k,).

    NaN outside the photo.
    """
    of_groove = kind in ("dark", "bright")
    kernel = (second_derivative if of_groove else derivative)(scale_px, strip.step)
    slope, offset = filtered(strip, kernel)
    return (np.abs(slope) if kind == "either" else _SIGN[kind] * slope), offset


def spread(values: Array) -> float:
    """Robust standard deviation of answers (rows, k) by noise and texture.

    From row to row, so that what runs along the strip does not count.
    """
    change = values[1:] - values[:-1]
    known = change[np.isfinite(change)]
    return float(_MAD * np.median(np.abs(known)) / np.sqrt(2)) if len(known) else 0.0


def peaks(values: Array) -> NDArray[np.bool_]:
    """Which values of each row are larger than both neighbours, shape (rows, k)."""
    found = np.zeros(values.shape, dtype=np.bool_)
    with np.errstate(invalid="ignore"):
        left, right = values[:, 1:-1] > values[:, :-2], values[:, 1:-1] >= values[:, 2:]
    found[:, 1:-1] = left & right
    return found


def vertex(values: Array, where: NDArray[np.int64], step: float) -> tuple[Array, Array]:
    """Vertex of the parabola through three values of each row about a peak.

    Args:
        values: Shape (rows, k).
        where: Column of the peak in each row, neither the first nor the last, shape (rows,).
        step: Pixels from column to column.

    Returns:
        How far the vertex is from the peak in pixels, and the curvature there, both (rows,).
    """
    row = np.arange(len(values))
    left, middle, right = (values[row, where + shift] for shift in (-1, 0, 1))
    bend = left - 2 * middle + right
    with np.errstate(divide="ignore", invalid="ignore"):
        shift = np.where(bend < 0, (left - right) / (2 * bend), np.nan)
    return shift * step, bend / step**2

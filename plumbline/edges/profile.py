"""What an edge looks like across: how wide it is, and whether it is one side of a groove."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from plumbline.edges.response import Kind, answer, peaks
from plumbline.edges.strip import Strip
from plumbline.frame import Array

_WIDER = 1.5
"""Width of the derivative over that of the edge. For a width of k the scatter over the bound is
√(3 (1 + k²)³ / 8 k⁵): 1.48 for 1.2, 1.30 for 1.5, 1.20 at best for 2.2, where neighbours of the
edge disturb more."""

_WIDTHS_PX = (0.45, 2.4)
"""Least and largest width (standard deviation) that an edge is taken to have: a pixel's own with
a perfect lens, and the softest where neighbours of 10 px still stand apart."""

_PAIR_PX = (0.8, 1.9)
"""Widths of the two derivatives whose answers tell the width of an edge (chosen, because they
enclose the widths of edges that are looked for)."""

_FLANK = 0.55
"""How strong the other flank of a groove is at least, relative to the one that was found."""

_GROOVE = 4.5
"""Distance of two flanks in units of the width of their answers, below which each moves the
other's peak by more than 0.01 px, and the groove's middle is taken."""

_WIDEST_PX = 5.0
"""Distance of two flanks up to which they are those of a groove: where they are farther apart,
each can be measured by itself."""

_NEAR_PX = 2.5
"""How far from the curve the edge itself may be: what the search leaves."""


class Profile(NamedTuple):
    """What an edge looks like.

    Attributes:
        kind: Its kind; a groove or a wire where the curve followed one flank of it.
        width_px: Standard deviation of its blur.
        scale_px: Width of the derivative to measure it with.
        shift_px: From the curve to the groove's middle where it followed a flank, else 0.
    """

    kind: Kind
    width_px: float
    scale_px: float
    shift_px: float = 0.0


def profile_of(strip: Strip, kind: Kind) -> Profile:
    """Look at the answers of a strip that runs along an edge, on the median over its rows."""
    width = _width_px(strip, kind)
    scale = _WIDER * width
    if kind in ("dark", "bright"):
        return Profile(kind, width, max(scale, 1.0))
    if kind != "either":
        slope, offset = answer(strip, kind, scale)
        reach = min(_GROOVE * float(np.hypot(width, scale)), _WIDEST_PX)
        here, other = _flanks(_middle(slope), offset, reach)
        if other is not None:
            groove: Kind = "dark" if (kind == "rising") == (other < here) else "bright"
            wide = max(scale, 0.6 * abs(other - here), 1.0)
            return Profile(groove, width, wide, (here + other) / 2)
    return Profile(kind, width, scale)


def _middle(values: Array) -> Array:
    """Median over rows; 0 where half of them are outside the photo."""
    return np.nan_to_num(np.median(values, axis=0))


def _width_px(strip: Strip, kind: Kind) -> float:
    """Width of an edge by how its answer falls where the derivative widens.

    A step of blur σ answers C / √(2π (σ² + s²)) to a derivative of width s, a line its cube.
    """
    power = 2 / 3 if kind in ("dark", "bright") else 2
    narrow, wide = (answer(strip, kind, scale) for scale in _PAIR_PX)
    middle = _middle(narrow[0])
    peak = peaks(middle[None])[0] & (np.abs(narrow[1]) <= _NEAR_PX)
    if not peak.any():
        return _WIDTHS_PX[1]
    here = int(np.argmax(np.where(peak, middle, -np.inf)))
    top = float(np.interp(narrow[1][here], wide[1], _middle(wide[0])))
    if not 0 < top < middle[here]:
        return _WIDTHS_PX[1]
    ratio = (float(middle[here]) / top) ** power
    square = (_PAIR_PX[1] ** 2 - ratio * _PAIR_PX[0] ** 2) / (ratio - 1)
    return float(np.clip(np.sqrt(max(square, 0.0)), *_WIDTHS_PX))


def _flanks(slope: Array, offset: Array, reach_px: float) -> tuple[float, float | None]:
    """Where the flank is that was followed, and the opposite one if it is near and as strong."""
    near = np.abs(offset) <= _NEAR_PX
    here = int(np.argmax(np.where(near, slope, -np.inf)))
    if not near[max(here - 1, 0)] or not near[min(here + 1, len(near) - 1)]:
        return float(offset[here]), None  # its peak is farther out
    around = np.abs(offset - offset[here]) <= reach_px
    other = int(np.argmin(np.where(around, slope, np.inf)))
    if -slope[other] < _FLANK * slope[here]:
        return float(offset[here]), None
    return float(offset[here]), float(offset[other])

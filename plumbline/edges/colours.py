"""Lateral chromatic aberration: the same edges measured in red, green and blue.

    r_red = r (v + b r²),  r the radius in green, 1 at half the shorter side

and alike for blue: LensFun's `<tca model="poly3">` with c = 0; `linear` has v alone, called k.
Source: LensFun, `tca`; as in Hugin's tca_correct, green is the reference.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plumbline.edges.guide import GuideError, through_nodes
from plumbline.edges.light import Channel, Light, linear_channel
from plumbline.edges.profile import profile_of
from plumbline.edges.refine import Samples, measured, rows_for
from plumbline.edges.strip import cut
from plumbline.edges.trace import Traced
from plumbline.errors import DegenerateLinesError
from plumbline.frame import Array, Frame
from plumbline.wording import number

_WINDOW_PX = 3.0
"""How far red and blue edges may be from green ones: 0.2 % of a 3,000 px radius; lenses that
Hugin's users measured stay below 0.15 %."""

_REACH_PX = 18
_PER_PX = 4
"""Steps a pixel of the strip: chosen, the shift is interpolated between them."""
_NODES = 64
"""Samples along an edge for one channel: chosen, the blur makes closer ones alike."""
_LEAST_LINES = 4
"""Lines below which leaving one out says nothing of the error (chosen, because two coefficients
need two)."""

_ROUNDS = 6
"""Chosen: weights settle in three."""
_USUAL = 2.0
"""Times the median rms of lines from which a line counts less: its colours change beside it."""


@dataclass(frozen=True)
class ColourShift:
    """How a colour is magnified against green.

    Attributes:
        k: The magnification where it is the same everywhere (LensFun's `linear`).
        v: The magnification at the centre (LensFun's `poly3`).
        b: Its growth with the square of the radius (`poly3`).
        errors: Standard errors of k, v and b, from leaving out one line at a time.
        corner_px: How far the colour is outside of green in the photo's corner, by v and b.
        corner_error_px: Its standard error.
    """

    k: float
    v: float
    b: float
    errors: tuple[float, float, float]
    corner_px: float
    corner_error_px: float


@dataclass(frozen=True)
class LateralColour:
    """The lateral chromatic aberration of a photo.

    Attributes:
        red: How red is magnified against green.
        blue: How blue is.
        n_lines: Number of edges it was measured on.
        halved_colours: Whether the photo stores colours at half resolution (JPEG 4:2:0), which
            makes errors of 0.3 px and more that the standard errors do not know of.
    """

    red: ColourShift
    blue: ColourShift
    n_lines: int
    halved_colours: bool = False

    @property
    def note(self) -> str:
        """What was found, in a sentence."""
        parts = [
            f"{name} {number(shift.corner_px, '+.2f')} ± {shift.corner_error_px:.2f} px"
            for name, shift in (("red", self.red), ("blue", self.blue))
        ]
        told = f"lateral colour at the corner: {' and '.join(parts)} outside of green"
        if self.halved_colours:
            told += (
                "; the JPEG stores colours at half resolution (4:2:0), so trust this to 0.3 px "
                "only, and write no tca from it"
            )
        return told


def lateral_colour(
    pixels: NDArray[Any], lines: Sequence[Traced], *, halved_colours: bool = False
) -> LateralColour:
    """Measure the lateral chromatic aberration on edges that were traced.

    Args:
        pixels: Blue, green, red, shape (rows, columns, 3), 8 or 16 bit.
        lines: Edges of that photo; those that were refused do not count.
        halved_colours: Whether the photo stores colours at half resolution.

    Raises:
        DegenerateLinesError: the photo is grey, or fewer than four edges show all three colours.
    """
    if pixels.ndim != 3 or pixels.shape[2] < 3:
        raise DegenerateLinesError(
            "a grey photo has no lateral colour", hint="give the photo in colour"
        )
    frame = Frame(pixels.shape[1], pixels.shape[0])
    names: tuple[Channel, ...] = ("green", "red", "blue")
    lights = {name: linear_channel(pixels, name) for name in names}
    found = [line for line in lines if line.found]
    shifts: dict[Channel, ColourShift] = {}
    counts: list[int] = []
    for name in ("red", "blue"):
        parts = [_compared(lights["green"], lights[name], line, frame) for line in found]
        good = [part for part in parts if part is not None]
        if len(good) < _LEAST_LINES:
            raise DegenerateLinesError(
                f"only {len(good)} edges show both green and {name}, and lateral colour needs "
                f"{_LEAST_LINES}",
                hint="snap more lines, at different distances from the centre",
            )
        shifts[name] = _fitted(good, frame)
        counts.append(len(good))
    return LateralColour(shifts["red"], shifts["blue"], min(counts), halved_colours)


@dataclass(frozen=True, eq=False)
class _Compared:
    """One edge in two colours: distances across, and what each coefficient does to them."""

    gap_px: Array
    effect_px: Array


def _compared(green: Light, other: Light, line: Traced, frame: Frame) -> _Compared | None:
    try:
        guide = through_nodes(_smooth(line.points_px), frame.size)
    except GuideError:
        return None
    strips = [cut(image, guide, _REACH_PX, rows_for(guide), _PER_PX) for image in (green, other)]
    profile = profile_of(strips[0], line.kind or "either")
    seen = [measured(guide, strip, profile, _WINDOW_PX) for strip in strips]
    both = seen[0].good & seen[1].good
    if both.sum() < 3:
        return None
    points, normal = _with_normals(seen[0], both)
    gap = (seen[1].offset - seen[0].offset)[both] * normal[:, 1 - int(guide.steep)]
    at = frame.normalise(points)
    outwards = np.sum(at * normal, axis=1) * frame.radius_px
    r2 = np.sum(at**2, axis=1)
    return _Compared(gap, np.stack((outwards, outwards * r2), axis=-1))


def _smooth(points: Array) -> Array:
    """Points without the scatter of single samples, so that they follow each other."""
    order = np.argsort(points[:, int(np.ptp(points[:, 1]) > np.ptp(points[:, 0]))])
    points = points[order]
    number = min(_NODES, len(points))
    ends = np.linspace(0, len(points), number + 1).astype(np.int64)
    means = np.add.reduceat(points, ends[:-1]) / np.diff(ends)[:, None]
    return np.concatenate((points[:1], means[1:-1], points[-1:]))


def _with_normals(samples: Samples, which: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Points of samples and unit normals there, both (n, 2); normals point along the offsets."""
    guide = samples.guide
    slope = np.interp(samples.along[which], guide.along, np.gradient(guide.across))
    points = guide.points(samples.along[which], samples.offset[which])
    long = np.hypot(1.0, slope)
    across, along = 1 / long, -slope / long
    return points, np.stack((across, along) if guide.steep else (along, across), axis=-1)


def _fitted(parts: Sequence[_Compared], frame: Frame) -> ColourShift:
    weight = np.ones(len(parts))
    for _ in range(_ROUNDS):
        c = _solved(parts, weight, 2)
        rms = np.array([float(np.sqrt(np.mean((p.gap_px - p.effect_px @ c) ** 2))) for p in parts])
        weight = 1 / (1 + (rms / (_USUAL * max(float(np.median(rms)), 1e-6))) ** 4)
    corner = frame.corner_radius
    to_corner = np.array([corner, corner**3]) * frame.radius_px
    k, c = _solved(parts, weight, 1)[0], _solved(parts, weight, 2)
    left_out: list[Array] = []
    for index in range(len(parts)):
        fewer = weight.copy()
        fewer[index] = 0.0
        two = _solved(parts, fewer, 2)
        left_out.append(np.array([_solved(parts, fewer, 1)[0], *two, two @ to_corner]))
    gaps = np.array(left_out) - np.mean(left_out, axis=0)
    n = len(parts)
    errors = np.sqrt((n - 1) / n * np.sum(gaps**2, axis=0))  # the jackknife (Tukey 1958)
    return ColourShift(
        1 + float(k),
        1 + float(c[0]),
        float(c[1]),
        (float(errors[0]), float(errors[1]), float(errors[2])),
        float(c @ to_corner),
        float(errors[3]),
    )


def _solved(parts: Sequence[_Compared], weight: Array, number: int) -> Array:
    """Least squares for the first coefficients; every line counts alike but for its weight."""
    normal, right = np.zeros((number, number)), np.zeros(number)
    for part, each in zip(parts, weight, strict=True):
        effect = part.effect_px[:, :number]
        normal += each / len(effect) * effect.T @ effect
        right += each / len(effect) * effect.T @ part.gap_px
    return np.asarray(np.linalg.lstsq(normal, right, rcond=None)[0], dtype=np.float64)

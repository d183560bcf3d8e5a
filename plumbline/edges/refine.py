"""An edge's place to a small part of a pixel, stretch by stretch, along a curve that is near it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from plumbline.edges.guide import Guide
from plumbline.edges.light import CLIPPED, Light
from plumbline.edges.profile import Profile, profile_of
from plumbline.edges.response import answer, peaks, spread, vertex
from plumbline.edges.search import Curve
from plumbline.edges.strip import Strip, cut
from plumbline.frame import Array

ROWS = 200
"""Samples along a line: with more, neighbours share the blur of a short line."""

LEAST_STRETCH_PX = 4
"""Pixels averaged for a sample at least: twice the blur of a sharp photo."""

_PER_PX = 4
"""Columns a pixel: the parabola through three of them is right to 0.001 px."""

_REACH_PX = 15
"""Pixels to either side of the curve: room for the widest kernel, 4 × 3 px, and a peak."""

_WINDOWS_PX = (2.5, 1.5, 1.0)
"""How far from the curve peaks are looked for, pass after pass: what the search leaves, what a
cubic leaves of a bent guide, and what edges bend by themselves."""

_SIGNIFICANT = 3.0
"""Times the spread of answers from which a peak counts as a sample."""

_LEAST = 0.15
"""A sample's answer relative to the edge's median at least (chosen, because a window's frame or a
shadow takes away five sixths of an edge's contrast at most)."""

_TUKEY = 4.685
"""Tukey's biweight with 95 % efficiency (Holland and Welsch 1977)."""

_FLOOR_PX = 0.03
"""Least scatter that samples are weighed by, so that perfect ones do not reject each other."""


@dataclass(frozen=True, eq=False)
class Samples:
    """Places of an edge along a guide.

    Attributes:
        guide: The guide they are measured from.
        along: Place on the guide's axis of each stretch, shape (n,).
        offset: Distance from the guide across its axis, pixels; NaN where there is no edge.
        error_px: Standard error of each across the edge, pixels.
        good: Which are of the edge, shape (n,).
        clipped: Share of them whose light is clipped on one side.
        profile: What the edge looks like.
    """

    guide: Guide
    along: Array
    offset: Array
    error_px: Array
    good: NDArray[np.bool_]
    clipped: float
    profile: Profile

    @property
    def support(self) -> float:
        """Share of the guide with an edge under it."""
        return float(np.mean(self.good))

    def smooth(self, along: Array) -> Array:
        """Place across the guide's axis of a robust cubic through the good samples."""
        fit = _robust_fit(self)
        return self.guide.at(along) + (0.0 if fit is None else fit(along))

    @property
    def points_px(self) -> Array:
        """The good samples' points, shape (m, 2)."""
        return self.guide.points(self.along[self.good], self.offset[self.good])


def rows_for(guide: Guide) -> int:
    """How many stretches a guide is divided into."""
    return int(np.clip(len(guide.across) // LEAST_STRETCH_PX, 3, ROWS))


def refined(image: Light, guide: Guide, curve: Curve) -> Samples | None:
    """Measure the edge that follows a curve; None where too little is seen of it.

    The strip is cut again along what was measured, until it runs along the edge.
    """
    moved = guide.moved(curve.offset(guide.share(guide.along)))
    kind = curve.kind
    found: Samples | None = None
    for window in _WINDOWS_PX:
        strip = cut(image, moved, _REACH_PX, rows_for(moved), _PER_PX)
        profile = profile_of(strip, kind)
        if profile.shift_px:  # along a groove's middle, where one of its flanks was found
            moved = moved.moved(np.full(len(moved.across), profile.shift_px))
            strip = cut(image, moved, _REACH_PX, rows_for(moved), _PER_PX)
        kind = profile.kind
        found = measured(moved, strip, profile, window)
        smooth = _robust_fit(found)
        if smooth is None:
            return None
        moved = moved.moved(smooth(moved.along))
    return found


def measured(guide: Guide, strip: Strip, profile: Profile, window_px: float) -> Samples:
    """Measure the edge in a strip along a guide, no farther from it than a window."""
    values, offset = answer(strip, profile.kind, profile.scale_px)
    near = np.abs(offset) <= window_px
    seen = np.where(near & peaks(values), values, -np.inf)
    where = np.clip(np.argmax(seen, axis=1), 1, len(offset) - 2)
    shift, bend = vertex(values, where, strip.step)
    row = np.arange(len(values))
    strength = np.nan_to_num(values[row, where])
    inside = near[where] & (np.abs(shift) <= strip.step)
    significant = inside & (strength > _SIGNIFICANT * spread(values))
    usual = float(np.median(strength[significant])) if significant.any() else 0.0
    place = np.where(significant & (strength > _LEAST * usual), offset[where] + shift, np.nan)
    good = np.isfinite(place)
    steepness = np.where(good, -bend, np.nan)
    error = (
        _errors(place, steepness, strip)
        * guide.cosine[
            np.clip((strip.along - guide.first).astype(np.int64), 0, len(guide.across) - 1)
        ]
    )
    clipped = _clipped(strip, good)
    samples = Samples(guide, strip.along, place, error, good, clipped, profile)
    return _without_strays(samples)


def _errors(place: Array, steepness: Array, strip: Strip) -> Array:
    """Standard errors: as neighbours differ on the whole, larger where the answer is flatter.

    Second differences are deaf to an edge's own bends. Those of independent numbers have a
    standard deviation of √6.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        relative = 1 / (steepness * np.sqrt(strip.length))
    relative = relative / np.nanmedian(relative) if np.isfinite(relative).any() else relative
    second = place[:-2] - 2 * place[1:-1] + place[2:]
    scale = np.sqrt(relative[:-2] ** 2 + 4 * relative[1:-1] ** 2 + relative[2:] ** 2)
    ratio = (second / scale)[np.isfinite(second / scale)]
    unit = 1.4826 * float(np.median(np.abs(ratio))) if len(ratio) >= 3 else np.nan
    return unit * relative


def _clipped(strip: Strip, good: NDArray[np.bool_]) -> float:
    """Share of the good samples whose brighter side is clipped."""
    if not good.any():
        return 0.0
    near = np.abs(strip.offset) <= 4
    brightest = np.nanmax(np.where(near, strip.values, -1.0), axis=1)
    return float(np.mean(brightest[good] >= CLIPPED))


def _without_strays(samples: Samples) -> Samples:
    """The same without samples far from a robust cubic through all."""
    smooth = _robust_fit(samples)
    if smooth is None:
        return samples
    gap = np.abs(samples.offset - smooth(samples.along))
    scatter = max(_FLOOR_PX, 1.4826 * float(np.nanmedian(gap)))
    with np.errstate(invalid="ignore"):
        good = samples.good & (gap <= 5 * scatter)
    return replace(samples, good=good)


@dataclass(frozen=True, eq=False)
class _Smooth:
    """A polynomial in places along a guide."""

    c: Array
    low: float
    high: float

    def __call__(self, along: Array) -> Array:
        return _powers(along, self.low, self.high, len(self.c)) @ self.c


def _powers(along: Array, low: float, high: float, number: int) -> Array:
    at = (2 * along - low - high) / (high - low)
    return np.asarray(np.polynomial.legendre.legvander(at, number - 1), dtype=np.float64)


def _robust_fit(samples: Samples) -> _Smooth | None:
    """A cubic through the good samples, or a straight line through few, strays left out."""
    along, offset = samples.along[samples.good], samples.offset[samples.good]
    if len(along) < 4:
        return None
    low, high = float(samples.along[0]), float(samples.along[-1])
    number = 4 if np.ptp(along) > 0.5 * (high - low) and len(along) >= 12 else 2
    powers = _powers(along, low, high, number)
    weight: Array = np.ones(len(along))
    c: Array = np.zeros(number)
    for _ in range(8):
        normal = (powers * weight[:, None]).T @ powers + 1e-9 * np.eye(number)
        solved = np.linalg.solve(normal, (powers * weight[:, None]).T @ offset)
        c = np.asarray(solved, dtype=np.float64)
        gap = offset - powers @ c
        scatter = max(_FLOOR_PX, 1.4826 * float(np.median(np.abs(gap))))
        weight = np.maximum(1 - (gap / (_TUKEY * scatter)) ** 2, 1e-6) ** 2
    return _Smooth(c, low, high)

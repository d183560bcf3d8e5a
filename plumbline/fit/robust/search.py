"""Where a robust fit begins: lenses under which many picks may agree, before any lens is known.

Lenses of the division model with two coefficients are tried over the whole range in which they
neither fold nor have a pole, by how likely the picks are under each
(`plumbline.fit.robust.agreement`): first with a σ as coarse as the grid, then σ and the steps
between lenses are halved around the best, until σ is as fine as people pick.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from plumbline.fit.problem import Problem
from plumbline.fit.robust.agreement import Alike, alike, evidence
from plumbline.fit.robust.pixels import shape_across
from plumbline.fit.robust.screening import Picks
from plumbline.frame import Array
from plumbline.geometry.derivatives import Ideal
from plumbline.geometry.lines import line_numbers
from plumbline.models import CENTRE, get_model

_STEPS = np.array((0.03, 0.0375))
"""Steps of l1 and l2 at the farthest pick: chosen, so that the coarsest σ covers one."""
_COARSEST, _FINEST_PX = 0.008, 0.6
"""σ to begin with as a share of R, and the one to end below."""
_BEST, _STARTS = 32, 10
"""Lenses that are refined and begun with: chosen (`tests.benchmarks.spoiled`)."""
_APART, _STARTS_APART = 6.0, 24.0
"""How many σ two lenses differ by to count as two: chosen."""
_MOST_PICKS, _MOST_OF_LINE = 240, 16
"""Picks that lenses are tried on: chosen, because more change the best one hardly."""
_CHUNK = 1 << 21
"""Distances held at a time: chosen, 16 MiB."""
_AROUND = np.array([(i, j) for i in (-1, 0, 1) for j in (-2, -1, 0, 1, 2)])
"""Steps around a good start: one in the first bend, two in the second, which is known less."""
_FEASIBLE = np.linspace(0.0, 1.0, 33)
"""Squared radii over the corner's, at which a bend must not fold; chosen, a fold is wider."""


class Begun(NamedTuple):
    """A lens to begin with.

    Attributes:
        picks: The picks under it.
        sigma_px: The σ with which they are likeliest.
    """

    picks: Picks
    sigma_px: float


class _Seen(NamedTuple):
    """Observed picks of some lines from the distortion centre, normalised.

    Attributes:
        observed: The picks, line after line, shape (n, 2).
        sizes: Number of picks of each line.
        far: Largest radius of all picks.
        unit_px: Square pixels to a normalised radius of 1.
        aspect: Width over height of the photograph's pixels.
    """

    observed: Array
    sizes: NDArray[np.int64]
    far: float
    unit_px: float
    aspect: float


def beginnings(problem: Problem, wrong_px: float) -> list[Begun]:
    """The likeliest of many lenses.

    Args:
        problem: The problem; its lens does not matter.
        wrong_px: Width of the band that wrong picks fall into.
    """
    every = _seen(problem)
    telling = _telling(every)
    groups = list(alike(telling.sizes))
    sigma_px, steps = _COARSEST * problem.blank.frame.radius_px, _STEPS
    bends = _whole_range()
    one_px = 1 / (every.far * every.unit_px)
    found: list[tuple[Array, Array, Array]] = []
    while True:
        likely = _evidence(telling, groups, bends, sigma_px, wrong_px)
        best = _unlike(bends, likely, _APART * sigma_px * one_px, _BEST)
        found.append((bends[best], likely[best], np.full(len(best), sigma_px)))
        if sigma_px < _FINEST_PX:
            break
        sigma_px, steps = sigma_px / 2, steps / 2
        around = (bends[best][:, None] + _AROUND * steps).reshape(-1, 2)
        bends = _possible(np.unique(np.round(around, 9), axis=0))
    bends, likely, sigmas_px = (np.concatenate(each) for each in zip(*found, strict=True))
    starts = _unlike(bends, likely, _STARTS_APART * sigma_px * one_px, _STARTS)
    return [Begun(_bent(every, bends[n]), float(sigmas_px[n])) for n in starts]


def _unlike(bends: Array, likely: Array, apart: float, most: int) -> list[int]:
    """The likeliest lenses that differ from each other, whatever their scale, by so much."""
    r = np.linspace(0.1, 1.0, 10)
    curves = r / (1 + bends[:, :1] * r**2 + bends[:, 1:] * r**4)
    curves *= (r @ r) / (curves @ r)[:, None]
    chosen: list[int] = []
    rest = np.argsort(-likely, kind="stable")
    while len(rest) and len(chosen) < most:
        chosen.append(int(rest[0]))
        rest = rest[np.max(np.abs(curves[rest] - curves[rest[0]]), axis=1) > apart]
    return chosen


def _seen(problem: Problem) -> _Seen:
    packed = problem.packed
    held = np.array([problem.plan.start[name] for name in CENTRE])
    observed = packed.unpack(packed.block.xy) - held / problem.to_px[-2:]
    far = float(np.max(np.hypot(*observed.T)))
    blank = problem.blank
    return _Seen(observed, packed.sizes, far, blank.unit_px, blank.frame.pixel_aspect)


def _telling(seen: _Seen) -> _Seen:
    """The lines that a lens bends most, and of long ones some picks; all, unless they are many."""
    sizes, starts = seen.sizes, np.cumsum(seen.sizes) - seen.sizes
    first, last = seen.observed[starts], seen.observed[starts + sizes - 1]
    length = np.hypot(*(last - first).T)
    area = np.abs(first[:, 0] * last[:, 1] - first[:, 1] * last[:, 0])
    fewer = np.minimum(sizes, _MOST_OF_LINE)
    order = np.argsort(-area * length)
    chosen = np.sort(order[np.cumsum(fewer[order]) <= _MOST_PICKS])
    rows = [
        start + np.unique(np.linspace(0, size - 1, few).astype(np.int64))
        for start, size, few in zip(
            *(each[chosen].tolist() for each in (starts, sizes, fewer)), strict=True
        )
    ]
    return seen._replace(observed=seen.observed[np.concatenate(rows)], sizes=fewer[chosen])


def _whole_range() -> Array:
    """A grid over l1 and l2 of the division model, at a reach of 1."""
    one, two = np.arange(-32, 33) * _STEPS[0], np.arange(-4, 5) * 2 * _STEPS[1]
    return _possible(np.stack(np.meshgrid(one, two, indexing="ij"), axis=-1).reshape(-1, 2))


def _possible(bends: Array) -> Array:
    """Those that neither fold nor have a pole."""
    one, two, s = bends[:, :1], bends[:, 1:], _FEASIBLE
    pole, fold = 1 + one * s + two * s**2, 1 - one * s - 3 * two * s**2
    return bends[np.all((pole > 0.03) & (fold > 0.03), axis=1)]


def _evidence(
    seen: _Seen, groups: list[Alike], bends: Array, sigma_px: float, wrong_px: float
) -> Array:
    """How likely the picks are under lenses of the division model."""
    s = np.sum(seen.observed**2, axis=1) / seen.far**2
    shape = shape_across(seen.observed, seen.sizes, seen.aspect)
    room = max(1, _CHUNK // (len(s) * 64))
    likely: list[Array] = []
    for some in np.array_split(bends, -(-len(bends) // room)):
        one, two = some[:, :1], some[:, 1:]
        below = 1 + one * s + two * s**2
        slope = (1 - one * s - 3 * two * s**2) / below**2
        uv = seen.observed * (seen.unit_px / below[..., None])
        likely.append(evidence(uv, np.sqrt(slope / below) * shape, groups, sigma_px, wrong_px))
    return np.concatenate(likely)


def _bent(seen: _Seen, bend: Array) -> Picks:
    """The picks under a lens of the division model."""
    c = bend[0] / seen.far**2, bend[1] / seen.far**4
    r2 = np.sum(seen.observed**2, axis=1)
    ideal = seen.observed / (1 + c[0] * r2 + c[1] * r2**2)[:, None]
    slopes = get_model("division").stretch(seen.observed, ideal, c)
    one, line = np.zeros(len(r2), dtype=np.int64), line_numbers(seen.sizes)
    placed = Ideal(ideal * seen.unit_px, slopes, seen.aspect)
    return Picks(placed, seen.sizes, line, one, np.array([1]), np.zeros(1))

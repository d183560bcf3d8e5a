"""A glance at a fit: do all its picks lie on straight lines, if its lens is right?

For each line the pair of its picks with the least median distance of all its picks is found
(P. Rousseeuw, "Least median of squares regression", 1984). From there lines are fitted by least
squares to the picks within reach of them, with one σ for the whole photo that follows from these
picks, and once more. Many problems are screened in one go: everything runs over flat arrays of
picks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np
from numpy.typing import NDArray

from plumbline.fit.problem import Problem
from plumbline.fit.program.blocks import unpack
from plumbline.fit.program.task import Solution
from plumbline.fit.robust.pixels import stretch_of_lines
from plumbline.fit.robust.worth import ROUNDED_PX
from plumbline.frame import Array
from plumbline.geometry.derivatives import Ideal
from plumbline.geometry.lines import Lines, fit_lines, line_numbers
from plumbline.trust.linearised import across_stretch
from plumbline.trust.student import quantile

_PAIRS = 10
"""Chosen, because one good pair of ten is certain but for 1 in 1,000 with half the picks wrong."""
_CHUNK = 1 << 15
"""Distances held at a time: chosen, to fit a processor's cache."""
_ROUNDS = 2
"""Chosen, because the kept picks no longer change after two."""
BEYOND = 2.5
"""How far beyond a line's own spread a pick may lie along it and still belong to it."""
_MOST_VOTES = 256
"""Picks of a line that take part in the median: chosen, enough to know it to a tenth."""
_MOST_OF_MIDDLE, _MOST_OF_FIRST = 1.3, 1.6
"""How much larger than from the middle of the residuals σ may be: chosen, because good picks
scatter the ratio by less (`tests.benchmarks.spoiled`)."""
_EXACT = 2  # each least-median line runs through two picks, which tell nothing of σ
FINEST_PX = 0.01
"""Nobody picks better than this; below, rounding is not a reason for suspicion."""


@dataclass(frozen=True, eq=False)
class Picks:
    """Picks of one or several problems under a lens each, problem after problem.

    Attributes:
        ideal: Where they are undistorted, in square pixels.
        sizes: Number of picks of each line.
        line: Line of each pick, counted over all problems.
        problem: Problem of each pick.
        n_free: Number of free coefficients of each problem.
        finest_px: The least σ that the picks of each problem can have.
    """

    ideal: Ideal
    sizes: NDArray[np.int64]
    line: NDArray[np.int64]
    problem: NDArray[np.int64]
    n_free: NDArray[np.int64]
    finest_px: Array


@dataclass(frozen=True, eq=False)
class Screened:
    """What screening found.

    Attributes:
        kept: Which picks lie on their lines, shape (n,).
        sigma_px: σ of the kept picks of each problem, in pixels of the photograph.
        lines: The lines through the kept picks.
        distance_px: Signed distance of every pick from its line in the photograph, shape (n,).
    """

    kept: NDArray[np.bool_]
    sigma_px: Array
    lines: Lines
    distance_px: Array


def picks_at(problems: Sequence[Problem], solutions: Sequence[Solution]) -> Picks:
    """The picks of problems of one model, undistorted by what the solver found."""
    model = problems[0].model
    counts = [len(problem.packed.cells) for problem in problems]
    of_problem = np.repeat(np.arange(len(problems)), counts)
    units = np.array([problem.blank.unit_px for problem in problems])[of_problem, None]
    found = np.stack([solution.coefficients for solution in solutions])[of_problem]
    packed = [problem.packed for problem in problems]
    observed = unpack(packed, [each.block.xy for each in packed])
    ideal = np.stack(
        (unpack(packed, [s.u for s in solutions]), unpack(packed, [s.v for s in solutions])), axis=1
    )
    slopes = model.stretch(observed - found[:, -2:], ideal, found[:, :-2].T)
    sizes = np.concatenate([problem.packed.sizes for problem in problems])
    n_free = np.array([len(problem.plan.free) for problem in problems])
    finest_px = np.array([finest(problem) for problem in problems])
    aspects = np.array([problem.blank.frame.pixel_aspect for problem in problems])[of_problem]
    ideal_px = Ideal(ideal * units, slopes, aspects)
    return Picks(ideal_px, sizes, line_numbers(sizes), of_problem, n_free, finest_px)


def finest(problem: Problem) -> float:
    """The least σ that picks can have: rounding, where all coordinates are whole numbers."""
    whole = all(
        np.array_equal(line.points_px, np.rint(line.points_px))
        for line in problem.observations.lines
    )
    return ROUNDED_PX if whole else FINEST_PX


def screen(picks: Picks) -> Screened:
    """Find the picks that lie on straight lines with the others, of one or several problems."""
    lines = _least_median_lines(picks.ideal, picks.sizes)
    distance_px = distances(picks, lines)
    sigma_px = _middle(picks, np.abs(distance_px), _EXACT)
    most_px = _MOST_OF_FIRST * sigma_px
    kept = np.isfinite(distance_px)
    room = np.ones(len(kept))
    for _ in range(_ROUNDS):
        reach = _reach(picks, kept)[picks.problem]
        kept = np.abs(distance_px) < reach * sigma_px[picks.problem] * np.sqrt(room)
        kept &= (np.bincount(picks.line, kept, len(picks.sizes)) >= 2)[picks.line]
        lines = fit_lines(picks.ideal.uv, picks.sizes, kept.astype(np.float64))
        along, distance_px = _placed(picks, lines)
        spread = np.where(lines.spread > 0, lines.spread, np.inf)[picks.line]
        leverage = 1 / np.maximum(lines.count, 1.0)[picks.line] + along**2 / spread
        room = np.where(kept, np.maximum(1 - leverage, 0.05), 1 + leverage)
        # Where many picks are wrong, σ of the kept ones alone would grow to take them all in.
        middle = _middle(picks, np.abs(distance_px) / np.sqrt(room), 0)
        sigma_px = np.minimum(_sigma(picks, kept, distance_px), _MOST_OF_MIDDLE * middle)
        sigma_px = np.minimum(sigma_px, most_px)
    return Screened(kept, sigma_px, lines, distance_px)


def _least_median_lines(ideal: Ideal, sizes: NDArray[np.int64]) -> Lines:
    """For every line that through the pair of its picks with the least median distance."""
    starts = np.cumsum(sizes) - sizes
    scale = stretch_of_lines(ideal, sizes)
    scale = np.where(scale > 0, scale, np.inf)
    origin, along = np.zeros((len(sizes), 2)), np.zeros((len(sizes), 2))
    for size in np.unique(sizes):
        members = np.flatnonzero(sizes == size)
        votes = np.unique(np.linspace(0, size - 1, min(int(size), _MOST_VOTES)).astype(np.int64))
        step = max(1, _CHUNK // (len(votes) * _PAIRS))
        for first in range(0, len(members), step):
            chosen = members[first : first + step]
            rows = starts[chosen, None] + votes
            found = _least_median(ideal.uv[rows], scale[rows], pairs(len(votes), _PAIRS))
            origin[chosen], along[chosen] = found
    return Lines(origin, along, sizes.astype(np.float64), np.ones(len(sizes)))


def _least_median(
    uv: Array, scale: Array, pair: tuple[NDArray[np.int64], NDArray[np.int64]]
) -> tuple[Array, Array]:
    """The same for lines of one size: shapes (l, n, 2) and (l, n)."""
    first, second = pair
    origin = uv[:, first]
    along = uv[:, second] - origin
    length = np.hypot(along[..., 0], along[..., 1])
    along = along / np.where(length > 0, length, np.nan)[..., None]
    x = uv[:, None, :, 0] - origin[:, :, None, 0]
    y = uv[:, None, :, 1] - origin[:, :, None, 1]
    distance = np.abs(along[:, :, None, 0] * y - along[:, :, None, 1] * x) / scale[:, None]
    middle = uv.shape[1] // 2
    medians = np.partition(np.where(np.isnan(distance), np.inf, distance), middle, axis=2)
    medians = medians[:, :, middle]
    best = np.argmin(medians, axis=1)
    each = np.arange(len(uv))
    along = np.where(np.isfinite(along[each, best]), along[each, best], 0.0)
    return np.nan_to_num(origin[each, best]), along


@cache
def pairs(n: int, most: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Pairs of picks to draw lines through: all of few, else some that lie well apart."""
    picks = np.unique(np.linspace(0, n - 1, min(n, _MOST_VOTES)).astype(np.int64))
    first, second = (picks[each] for each in np.triu_indices(len(picks), 1))
    if len(first) > most:
        far = second - first >= n / 3
        first, second = first[far], second[far]
        some = np.random.default_rng(n).permutation(len(first))[:most]
        first, second = first[some], second[some]
    return first, second


def distance_from(picks: Picks, which: NDArray[np.int64], lines: Lines, other: int) -> Array:
    """Distances of some picks from one line in the photograph, without sign."""
    line = np.full(len(which), other)
    _, across = lines.place(picks.ideal.uv[which], line)
    ideal = picks.ideal.at(which)
    with np.errstate(invalid="ignore", divide="ignore"):
        image = np.abs(across) / across_stretch(ideal, lines, line)
    return np.where(np.isfinite(image), image, np.inf)


def within(lines: Lines, uv: Array, other: int) -> NDArray[np.bool_]:
    """Which points lie along the stretch of photo that a line was picked in, or a little beyond."""
    along, _ = lines.place(uv, np.full(len(uv), other))
    spread = np.sqrt(lines.spread[other] / max(float(lines.count[other]), 1.0))
    return np.abs(along) <= BEYOND * spread


def distances(picks: Picks, lines: Lines) -> Array:
    """Distances in the photograph; infinite beyond the fold of the model."""
    return _placed(picks, lines)[1]


def _placed(picks: Picks, lines: Lines) -> tuple[Array, Array]:
    """Positions along the lines in the corrected photo, and distances in the photograph."""
    along, distance = lines.place(picks.ideal.uv, picks.line)
    with np.errstate(invalid="ignore", divide="ignore"):
        image = distance / across_stretch(picks.ideal, lines, picks.line)
    return along, np.where(np.isfinite(image), image, np.inf)


def _middle(picks: Picks, distance_px: Array, exact: int) -> Array:
    """σ of each problem from the middle of its distances, `exact` a line that are 0 left aside."""
    n_problems = len(picks.n_free)
    counts = np.bincount(picks.problem, minlength=n_problems)
    ordered = np.full((n_problems, int(counts.max())), np.inf)
    ordered[np.arange(ordered.shape[1]) < counts[:, None]] = distance_px
    ordered.sort(axis=1)
    lines_of = np.bincount(
        picks.problem[np.cumsum(picks.sizes) - picks.sizes], minlength=n_problems
    )
    nothing = exact * lines_of
    rank = np.minimum(nothing + (counts - nothing) // 2, counts - 1)
    middle = ordered[np.arange(n_problems), rank]
    return np.maximum(np.where(np.isfinite(middle), 1.4826 * middle, np.inf), picks.finest_px)


def _sigma(picks: Picks, kept: NDArray[np.bool_], distance_px: Array) -> Array:
    square = np.where(kept, distance_px, 0.0) ** 2
    total = np.bincount(picks.problem, square, len(picks.n_free))
    return np.maximum(np.sqrt(total / _dof(picks, kept)), picks.finest_px)


def _dof(picks: Picks, kept: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Degrees of freedom of each problem, at least 1."""
    n_problems = len(picks.n_free)
    counts = np.bincount(picks.problem[kept], minlength=n_problems)
    used = np.bincount(picks.line[kept], minlength=len(picks.sizes)) > 0
    of_line = picks.problem[np.cumsum(picks.sizes) - picks.sizes]
    lines = np.bincount(of_line[used], minlength=n_problems)
    return np.maximum(counts - 2 * lines - picks.n_free, 1)


def _reach(picks: Picks, kept: NDArray[np.bool_]) -> Array:
    counts = np.bincount(picks.problem, minlength=len(picks.n_free)).tolist()
    every = zip(_dof(picks, kept).tolist(), counts, strict=True)
    return np.array([reach(dof, count) for dof, count in every])


@lru_cache(maxsize=4096)
def reach(dof: int, n: int) -> float:
    """The studentised residual beyond which a pick is suspicious.

    One good pick in 2,000 lies farther out, and a pick of one good set in fifty.
    """
    return quantile(1 - min(5e-4, 0.02 / n) / 2, max(dof - 1, 1))

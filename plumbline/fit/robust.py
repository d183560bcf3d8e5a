"""The robust fit: which picks are wrong, whatever they do to the plain fit.

Bad picks hide each other: a plain fit bends towards them, and its residuals name a few of them
and some good ones. The robust fit therefore begins robustly. Where the plain fit's lens leaves
all picks on straight lines (`plumbline.fit.screening`), it is its own robust fit. Else lenses of
the one-coefficient division model are tried over their whole range beside the plain one; that
with the straightest halves of lines decides which picks are believed, the model is fitted to
these, and lens and picks are decided in turn until nothing changes (re-weighting with weights 0
and 1; P. Rousseeuw and A. Leroy, "Robust Regression and Outlier Detection", 1987).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import comb

import numpy as np
from numpy.typing import NDArray

from plumbline.errors import DegenerateLinesError
from plumbline.fit.oddities import bends, twins
from plumbline.fit.outcome import lens_of
from plumbline.fit.problem import Problem, pixels_of_centre
from plumbline.fit.screening import (
    FINEST_PX,
    Picks,
    Screened,
    closest,
    distance_from,
    distances,
    least_median_lines,
    picks_at,
    reach,
    screen,
    within,
)
from plumbline.fit.solve import solve
from plumbline.fit.task import Solution
from plumbline.ideal import Ideal, stretch
from plumbline.linearised import in_frame, linearise
from plumbline.models import CENTRE, get_model
from plumbline.straightness import line_numbers

_MOST_ROUNDS = 12
_SAME = 5.0
_CHANCE = 0.05
_MASKED, _WILD = 0.8, 1 / 300
"""Below this share of the plain fit's σ̂ the believed picks' own, or above this share of R the
plain fit's, bad picks may be hiding each other.
"""
_STARTS = 3
_STEPS, _FINEST_STEP = (0.03, 0.0375), 5e-4
_MOST_LINES = 64
_LEAST_PX, _FAR_PX = 0.3, 1e6


def _bends() -> tuple[tuple[float, float], ...]:
    """l1 and l2 of the division model, at a reach of 1, that neither fold nor have a pole."""
    s = np.linspace(0.0, 1.0, 33)
    return tuple(
        (one, two)
        for one in np.linspace(-0.96, 0.96, 33).tolist()
        for two in np.linspace(-0.3, 0.3, 9).tolist()
        if np.all(1 + one * s + two * s**2 > 0.03) and np.all(1 - one * s - 3 * two * s**2 > 0.03)
    )


_BENDS = _bends()


@dataclass(frozen=True, eq=False)
class Robust:
    """A robust fit.

    Attributes:
        problem: The problem, fitted to the picks that are believed.
        solution: What the solver found.
        picks: All picks under it.
        screened: Where they lie.
    """

    problem: Problem
    solution: Solution
    picks: Picks
    screened: Screened


def robust_fits(
    problems: Sequence[Problem], solutions: Sequence[Solution]
) -> list[Robust | DegenerateLinesError | None]:
    """Robust fits of problems of one model.

    Args:
        problems: The problems, all picks kept.
        solutions: Their plain fits.

    Returns:
        None where nothing is suspicious and the plain fit is the robust one; an error where the
        picks that can be believed are too few.
    """
    picks = picks_at(problems, solutions)
    screened = screen(picks, glance=True)
    spoiled = np.bincount(picks.problem, ~screened.kept, len(problems)) > 0
    odd = _odd(picks, screened)
    made: list[Robust | DegenerateLinesError | None] = []
    for index, (problem, solution) in enumerate(zip(problems, solutions, strict=True)):
        plain_px = float(np.sqrt(np.sum(solution.residual**2) / problem.dof))
        wild = not plain_px < _WILD * problem.blank.frame.radius_px
        if spoiled[index] or wild:
            masked = wild or not screened.sigma_px[index] > _MASKED * plain_px
            kept = screened.kept[picks.problem == index]
            beliefs = _beliefs(problem, solution) if masked else [kept]
            made.append(_best([_fit(problem, belief) for belief in beliefs]))
        elif odd[index]:
            alone = picks_at([problem], [solution])
            made.append(Robust(problem, solution, alone, screen(alone)))
        else:
            made.append(None)
    return made


def _odd(picks: Picks, screened: Screened) -> NDArray[np.bool_]:
    """Which problems have lines that bend by themselves, or places picked twice."""
    of_line = picks.problem[np.cumsum(picks.sizes) - picks.sizes]
    along, _ = screened.lines.place(picks.ideal.uv, picks.line)
    away = screened.distance_px
    _, bent = bends(picks.line, along, away, screened.sigma_px[of_line])
    odd = np.zeros(len(picks.n_free), dtype=np.bool_)
    odd[of_line[bent]] = True
    odd[picks.problem[twins(picks.line, along, away)[:, 0]]] = True
    return odd


def _best(
    found: Sequence[Robust | DegenerateLinesError | None],
) -> Robust | DegenerateLinesError | None:
    """The likeliest fit: good picks scatter by σ, wrong ones anywhere within a tenth of R."""

    def unlikely(each: Robust) -> float:
        kept = int(np.count_nonzero(each.problem.kept))
        square = float(np.sum(np.where(each.problem.kept, each.screened.distance_px, 0.0) ** 2))
        sigma_px = max(float(np.sqrt(square / each.problem.dof)), FINEST_PX)
        wrong_px = each.problem.blank.frame.radius_px / 10
        return each.problem.dof * np.log(sigma_px) + (len(each.problem.kept) - kept) * np.log(
            wrong_px
        )

    fits = [each for each in found if isinstance(each, Robust)]
    return min(fits, key=unlikely) if fits else found[0]


def _fit(problem: Problem, kept: NDArray[np.bool_]) -> Robust | DegenerateLinesError | None:
    """Decide lens and picks in turn, from a first belief."""
    seen: list[NDArray[np.bool_]] = []
    found: Robust | None = None
    by_leverage = False
    while len(seen) < _MOST_ROUNDS and not any(np.array_equal(kept, other) for other in seen):
        seen.append(kept)
        try:
            believed = problem.keeping(kept)
        except DegenerateLinesError as error:
            return found or error
        solution = solve(problem.model, believed.task)
        picks = picks_at([problem], [solution])
        found = Robust(believed, solution, picks, screen(picks))
        lost = _lost(picks, found.screened)[picks.line]
        if not by_leverage:
            kept = found.screened.kept & ~lost
            by_leverage = any(np.array_equal(kept, other) for other in seen)
        if by_leverage:
            kept = _by_leverage(believed, solution) & ~lost
    return found


def _by_leverage(believed: Problem, solution: Solution) -> NDArray[np.bool_]:
    """Which picks lie within reach, with what each of them does to line and lens allowed for.

    A pick at the end of an outer line draws the lens after it and hides its own error; this shows
    once the rest is good.
    """
    lens, free = lens_of(believed, solution), believed.plan.free
    lines_px = in_frame(believed.observations, lens.frame)
    linear = linearise(lens, lines_px, free, believed.kept, image=True)
    square = float(np.sum(linear.residual_px[linear.kept] ** 2))
    sigma_px = max(float(np.sqrt(square / believed.dof)), FINEST_PX)
    return np.abs(linear.studentised(sigma_px)) < reach(believed.dof, len(linear.line))


def _lost(picks: Picks, screened: Screened) -> NDArray[np.bool_]:
    """Lines that nothing can be learnt from.

    So few picks agree that they may do so by chance, or most lie on another line and some do not.
    """
    n = len(picks.sizes)
    counts = np.bincount(picks.line, screened.kept, n)
    lost = counts < 3
    for line in np.flatnonzero(~lost & (2 * counts <= picks.sizes)).tolist():
        lost[line] = _by_chance(picks, screened, line) > _CHANCE
    for line in np.flatnonzero(~lost & (counts + 3 <= picks.sizes)).tolist():
        mine = np.flatnonzero((picks.line == line) & screened.kept)
        for other in np.flatnonzero(~lost & (counts >= counts[line])).tolist():
            if other == line:
                continue
            away = distance_from(picks, mine, screened.lines, other)
            near = within(screened.lines, picks.ideal.uv[mine], other)
            if np.all(near & (away < _SAME * screened.sigma_px[0])):
                lost[line] = True
                break
    return lost


def _by_chance(picks: Picks, screened: Screened, line: int) -> float:
    """How many lines through as many of this line's picks chance would make, at the most."""
    mine = picks.line == line
    away, kept = np.abs(screened.distance_px), mine & screened.kept
    close = max(float(np.max(away[kept], initial=0.0)), float(screened.sigma_px[0]))
    others = max(float(np.median(away[mine & ~kept])), FINEST_PX)
    share = min(1.0, close / others)
    agreeing = int(np.count_nonzero(kept))
    return comb(int(picks.sizes[line]), agreeing) * share ** (agreeing - 2)


def _beliefs(problem: Problem, plain: Solution) -> list[NDArray[np.bool_]]:
    """Which picks lie on straight lines under the best of many lenses, and under the plain one."""
    telling, every = _telling_lines(problem), np.arange(len(problem.packed.sizes))
    costs = [_cost(_bent(problem, bend, telling)) for bend in _BENDS]
    rough = [_BENDS[number] for number in np.argsort(costs)[: 2 * _STARTS].tolist()]
    fine = sorted(_refined(problem, bend, telling) for bend in rough)
    lenses = [_bent(problem, bend, every) for _, bend in fine[:_STARTS]]
    if not int(plain.folded):
        lenses.append(picks_at([problem], [plain]))
    return [closest(lens) for lens in lenses]


def _refined(
    problem: Problem, bend: tuple[float, float], lines: NDArray[np.int64]
) -> tuple[float, tuple[float, float]]:
    """The lowest cost beside a lens of the grid, and the lens, by steps that are halved."""
    steps, best = _STEPS, (_cost(_bent(problem, bend, lines)), bend)
    while steps[0] > _FINEST_STEP:
        around = [
            (best[1][0] + i * steps[0], best[1][1] + j * steps[1])
            for i in (-1, 0, 1)
            for j in (-1, 0, 1)
            if i or j
        ]
        lowest = min((_cost(_bent(problem, each, lines)), each) for each in around)
        if lowest[0] < best[0]:
            best = lowest
        else:
            steps = steps[0] / 2, steps[1] / 2
    return best


def _bent(problem: Problem, bend: tuple[float, float], lines: NDArray[np.int64]) -> Picks:
    """The picks of some lines under a lens of the division model."""
    packed, unit_px = problem.packed, problem.blank.unit_px
    held = np.array([problem.plan.start[name] for name in CENTRE])
    observed = packed.unpack(packed.block.xy) - held / pixels_of_centre(problem.blank)[-2:]
    far2 = float(np.max(np.sum(observed**2, axis=1)))
    c = bend[0] / far2, bend[1] / far2**2
    observed = observed[np.isin(line_numbers(packed.sizes), lines)]
    sizes = packed.sizes[lines]
    r2 = np.sum(observed**2, axis=1)
    ideal = observed / (1 + c[0] * r2 + c[1] * r2**2)[:, None]
    slopes = stretch(get_model("division"), c, observed, ideal)
    one = np.zeros(len(observed), dtype=np.int64)
    return Picks(Ideal(ideal * unit_px, slopes), sizes, line_numbers(sizes), one, np.array([1]))


def _telling_lines(problem: Problem) -> NDArray[np.int64]:
    """The lines that a lens bends most; all, unless they are many."""
    sizes = problem.packed.sizes
    if len(sizes) <= _MOST_LINES:
        return np.arange(len(sizes))
    points = problem.packed.unpack(problem.packed.block.xy)
    first, last = points[np.cumsum(sizes) - sizes], points[np.cumsum(sizes) - 1]
    length = np.hypot(*(last - first).T)
    area = np.abs(first[:, 0] * last[:, 1] - first[:, 1] * last[:, 0])
    return np.sort(np.argsort(-area * length)[:_MOST_LINES])


def _cost(picks: Picks) -> float:
    """How far picks lie from their least-median lines, wrong ones hardly more than others."""
    lines, _ = least_median_lines(picks.ideal, picks.sizes)
    away_px = np.minimum(np.abs(distances(picks, lines)), _FAR_PX)
    return float(np.sum(np.log(away_px + _LEAST_PX)))

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
from dataclasses import dataclass, replace
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
    distance_from,
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
_BENDS = tuple(np.linspace(-0.97, 0.9, 48).tolist())
_MOST_LINES = 64
_LEAST_PX, _FAR_PX = 0.1, 1e6


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


def robust_fits(problems: Sequence[Problem], solutions: Sequence[Solution]) -> list[Robust | None]:
    """Robust fits of problems of one model.

    Args:
        problems: The problems, all picks kept.
        solutions: Their plain fits.

    Returns:
        None where nothing is suspicious and the plain fit is the robust one.
    """
    picks = picks_at(problems, solutions)
    screened = screen(picks)
    spoiled = np.bincount(picks.problem, ~screened.kept, len(problems)) > 0
    odd = _odd(picks, screened)
    made: list[Robust | None] = []
    for index, (problem, solution) in enumerate(zip(problems, solutions, strict=True)):
        plain_px = float(np.sqrt(np.sum(solution.residual**2) / problem.dof))
        wild = not plain_px < _WILD * problem.blank.frame.radius_px
        if spoiled[index] or wild:
            masked = wild or not screened.sigma_px[index] > _MASKED * plain_px
            kept = screened.kept[picks.problem == index]
            made.append(_fit(problem, solution, None if masked else kept))
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


def _fit(problem: Problem, plain: Solution, kept: NDArray[np.bool_] | None) -> Robust | None:
    """Decide lens and picks in turn."""
    if kept is None:
        kept = _first_belief(problem, plain)
    seen: list[NDArray[np.bool_]] = []
    found: Robust | None = None
    settled = False
    while len(seen) < _MOST_ROUNDS:
        if any(np.array_equal(kept, other) for other in seen):
            if settled:
                break
            settled, seen = True, []
        seen.append(kept)
        try:
            believed = problem.keeping(kept)
        except DegenerateLinesError:
            return found
        solution = solve(problem.model, believed.task)
        picks = picks_at([problem], [solution])
        screened = screen(picks)
        if settled:
            screened = replace(screened, kept=_by_leverage(believed, solution))
        found = Robust(believed, solution, picks, screened)
        kept = screened.kept & ~_lost(picks, screened)[picks.line]
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
    for line in np.flatnonzero(2 * counts <= picks.sizes).tolist():
        lost[line] |= _by_chance(picks, screened, line) > _CHANCE
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


def _first_belief(problem: Problem, plain: Solution) -> NDArray[np.bool_]:
    """Which picks lie on straight lines under the best of many lenses."""
    every = np.arange(len(problem.packed.sizes))
    telling = _telling_lines(problem)
    costs = [_cost(_bent(problem, bend, telling)) for bend in _BENDS]
    best = _bent(problem, _BENDS[int(np.argmin(costs))], every)
    plainly = picks_at([problem], [plain])
    if not int(plain.folded) and _cost(_only(plainly, telling)) < min(costs):
        best = plainly
    return screen(best).kept


def _bent(problem: Problem, bend: float, lines: NDArray[np.int64]) -> Picks:
    """The picks of some lines under a lens of the division model."""
    packed, unit_px = problem.packed, problem.blank.unit_px
    held = np.array([problem.plan.start[name] for name in CENTRE])
    observed = packed.unpack(packed.block.xy) - held / pixels_of_centre(problem.blank)[-2:]
    c = (bend / float(np.max(np.sum(observed**2, axis=1))), 0.0)
    observed = observed[np.isin(line_numbers(packed.sizes), lines)]
    sizes = packed.sizes[lines]
    ideal = observed / (1 + c[0] * np.sum(observed**2, axis=1))[:, None]
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
    """How straight the better halves of lines are: Σ n log(median distance)."""
    _, median = least_median_lines(picks.ideal, picks.sizes)
    return float(np.sum(picks.sizes * np.log(np.minimum(median, _FAR_PX) + _LEAST_PX)))


def _only(picks: Picks, lines: NDArray[np.int64]) -> Picks:
    """The picks of some lines of one problem."""
    wanted = np.isin(picks.line, lines)
    sizes = picks.sizes[lines]
    ideal = Ideal(picks.ideal.uv[wanted], picks.ideal.stretch[wanted])
    return Picks(ideal, sizes, line_numbers(sizes), picks.problem[wanted], picks.n_free)

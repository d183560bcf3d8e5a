"""The robust fit: which picks are wrong, whatever they do to the plain fit.

Bad picks hide each other: a plain fit bends towards them, and its residuals name a few of them
and some good ones. The robust fit therefore begins robustly. Where the plain fit's lens leaves
all picks on straight lines (`plumbline.fit.screening`), it is its own robust fit. Else the best of
many lenses (`plumbline.fit.search`) and the plain one decide which picks are believed first; the
model is fitted to these, and lens and picks are decided in turn until nothing changes (re-weighting
with weights 0 and 1; P. Rousseeuw and A. Leroy, "Robust Regression and Outlier Detection", 1987).
Of the fits that are reached the likeliest is taken.
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
from plumbline.fit.problem import Problem
from plumbline.fit.screening import (
    FINEST_PX,
    Picks,
    Screened,
    distance_from,
    picks_at,
    reach,
    screen,
    within,
)
from plumbline.fit.search import beliefs
from plumbline.fit.solve import solve
from plumbline.fit.task import Solution
from plumbline.linearised import in_frame, linearise

_MOST_ROUNDS = 12
_SAME, _ROUGHLY = 5.0, 50.0
_LEAST = 3
_CHANCE = 0.05
_MASKED, _MANY, _WILD = 0.8, 0.02, 1 / 300
"""Bad picks may be hiding each other where they are more than the second share and leave to the
others less than the first share of the plain fit's σ̂, or where that exceeds the third share of R.
"""


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
            kept = screened.kept[picks.problem == index]
            many = np.count_nonzero(kept) < (1 - _MANY) * len(kept)
            masked = wild or (many and not screened.sigma_px[index] > _MASKED * plain_px)
            first = beliefs(problem, solution) if masked else [kept]
            made.append(_best([_fit(problem, belief) for belief in first]))
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
        photos = np.array([line.photo for line in problem.observations.lines])
        lost = _lost(picks, found.screened, photos)[picks.line]
        if not by_leverage:
            kept = found.screened.kept & ~lost
            by_leverage = any(np.array_equal(kept, other) for other in seen)
        if by_leverage:
            kept = _by_leverage(believed, solution) & ~lost
            kept &= (np.bincount(picks.line, kept, len(picks.sizes)) >= _LEAST)[picks.line]
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


def _lost(picks: Picks, screened: Screened, photos: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Lines that nothing can be learnt from.

    So few picks agree that they may do so by chance, or most lie on another line of the photo and
    some do not.
    """
    n = len(picks.sizes)
    counts = np.bincount(picks.line, screened.kept, n)
    lost = counts < _LEAST
    for line in np.flatnonzero(~lost & (2 * counts <= picks.sizes)).tolist():
        lost[line] = _by_chance(picks, screened, line) > _CHANCE
    starts, lines = np.cumsum(picks.sizes) - picks.sizes, screened.lines
    for line in np.flatnonzero(~lost & (counts + _LEAST <= picks.sizes)).tolist():
        first = int(starts[line])
        mine = first + np.flatnonzero(screened.kept[first : first + int(picks.sizes[line])])
        middle = np.broadcast_to(lines.centre[line], (n, 2))
        close = np.abs(lines.place(middle, np.arange(n))[1]) < _ROUGHLY * screened.sigma_px[0]
        close &= ~lost & (counts >= counts[line]) & (np.arange(n) != line)
        close &= photos == photos[line]
        for other in np.flatnonzero(close).tolist():
            away = distance_from(picks, mine, lines, other)
            near = within(lines, picks.ideal.uv[mine], other)
            if np.all(near & (away < _SAME * screened.sigma_px[0])):
                lost[line] = True
                break
    return lost


def _by_chance(picks: Picks, screened: Screened, line: int) -> float:
    """How many lines through as many of this line's picks chance would make, at the most."""
    first = int(np.sum(picks.sizes[:line]))
    mine = slice(first, first + int(picks.sizes[line]))
    away, kept = np.abs(screened.distance_px[mine]), screened.kept[mine]
    close = max(float(np.max(away[kept], initial=0.0)), float(screened.sigma_px[0]))
    others = max(float(np.median(away[~kept])), FINEST_PX)
    share = min(1.0, close / others)
    agreeing = int(np.count_nonzero(kept))
    return comb(int(picks.sizes[line]), agreeing) * share ** (agreeing - 2)

"""The robust fit: which picks are wrong, whatever they do to the plain fit.

Bad picks hide each other: a plain fit bends towards them, and its residuals name a few of them
and some good ones. The robust fit therefore begins robustly. Where the plain fit's lens leaves
all picks on straight lines (`plumbline.fit.robust.screening`), it is its own robust fit. Else the
best of many lenses (`plumbline.fit.robust.search`) and the plain one tell which picks may be
believed first; the model is fitted to these, and lens and picks are decided in turn until nothing
changes (re-weighting with weights 0 and 1; P. Rousseeuw and A. Leroy, "Robust Regression and
Outlier Detection", 1987). Of the fits that are reached the likeliest is taken. Last, what each pick
does to line and lens is allowed for.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from plumbline.errors import DegenerateLinesError
from plumbline.fit.outcome import lens_of
from plumbline.fit.problem import Problem
from plumbline.fit.program.solve import solve
from plumbline.fit.program.task import Solution
from plumbline.fit.robust.agreement import LEAST, Agreed, agree
from plumbline.fit.robust.oddities import Bends, bends, twins
from plumbline.fit.robust.rivals import contested, excuses
from plumbline.fit.robust.screening import Picks, Screened, finest, picks_at, reach, screen
from plumbline.fit.robust.search import beginnings
from plumbline.fit.robust.worth import EVIDENCE, explains_more, rounded
from plumbline.geometry.lens import Lens
from plumbline.trust.linearised import in_frame, linearise

_MOST_ROUNDS = 12
"""Chosen, because lens and picks settle in three to five."""
_MASKED, _MANY, _WILD = 0.8, 0.02, 1 / 300
"""Bad picks may be hiding each other where they are more than the second share and leave to the
others less than the first share of the plain fit's σ̂, or where that exceeds the third share of R.
"""
_SHARES = 1.0, 0.7, 0.5
"""Of σ̂, which wrong picks among the believed ones make too large."""
_NO_EXCUSE = 1e-9
"""Rounding of a logarithm."""
_WRONG = 0.1
"""Width of the band that wrong picks fall into, as a share of R."""


@dataclass(frozen=True, eq=False)
class Robust:
    """A robust fit.

    Attributes:
        problem: The problem, fitted to the picks that are believed.
        solution: What the solver found.
        picks: All picks under it.
        agreed: What they agree on.
        rivals: Lenses under which other picks agree about as well.
    """

    problem: Problem
    solution: Solution
    picks: Picks
    agreed: Agreed
    rivals: tuple[Lens, ...] = ()


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
    screened = screen(picks)
    spoiled = np.bincount(picks.problem, ~screened.kept, len(problems)) > 0
    odd = _odd(picks, screened)
    fits: list[Robust | DegenerateLinesError | None] = []
    for index, (problem, solution) in enumerate(zip(problems, solutions, strict=True)):
        plain_px = _sigma_px(problem, solution)
        wild = not plain_px < _WILD * problem.blank.frame.radius_px
        if spoiled[index] or wild:
            kept = screened.kept[picks.problem == index]
            many = np.count_nonzero(kept) < (1 - _MANY) * len(kept)
            masked = wild or (many and not screened.sigma_px[index] > _MASKED * plain_px)
            beliefs = _beliefs(problem, solution) if masked else [kept]
            best = _best(problem, beliefs, _SHARES if masked else _SHARES[:1])
            spared = isinstance(best, Robust) and not _explains_more(best, problem, solution)
            fits.append(_at(problem, solution, _SHARES[:1]) if spared and odd[index] else best)
            if spared and not odd[index]:
                fits[-1] = None
        elif odd[index]:
            fits.append(_at(problem, solution, _SHARES[:1]))
        else:
            fits.append(None)
    return fits


def _odd(picks: Picks, screened: Screened) -> NDArray[np.bool_]:
    """Which problems have lines that bend by themselves, or places picked twice."""
    of_line = picks.problem[np.cumsum(picks.sizes) - picks.sizes]
    along, _ = screened.lines.place(picks.ideal.uv, picks.line)
    away = screened.distance_px
    bent = bends(
        picks.line, along, away, screened.sigma_px[of_line], rounded(picks.finest_px)[of_line]
    ).bent
    odd = np.zeros(len(picks.n_free), dtype=np.bool_)
    odd[of_line[bent]] = True
    odd[picks.problem[twins(picks.line, along, away)[:, 0]]] = True
    return odd


def _explains_more(best: Robust, problem: Problem, plain: Solution) -> bool:
    """Whether wrong picks, or bent lines, explain the plain fit better than careless picks."""
    if int(plain.folded):
        return True
    finest_px, frame, kept = finest(problem), problem.blank.frame, best.problem.kept
    careless = max(_sigma_px(problem, plain), finest_px), problem.dof
    good = max(_sigma_px(best.problem, best.solution), finest_px), best.problem.dof
    every = problem.packed.sizes, frame.radius_px, _wrong_px(problem)
    if explains_more(careless, good, kept, *every):
        return True
    line, (_, bent, left_square) = best.picks.line, _bends(best)
    bent &= np.bincount(line, ~kept, len(bent)) > 0
    if not bent.any():
        return False
    # Picks of a bent line are good about its curve, which takes a third number of each line.
    fitted = kept & bent[line]
    number, used = (np.bincount(line, each, len(bent)) for each in (bent[line], fitted))
    dof = good[1] + int(np.sum((number - 3)[bent]) - np.sum(np.maximum(used - 2, 0)))
    square = good[0] ** 2 * good[1] + float(np.sum(left_square[bent]))
    square -= float(np.sum(best.agreed.distance_px[fitted] ** 2))
    with_bends = max(float(np.sqrt(max(square, 0.0) / dof)), finest_px), dof
    return explains_more(careless, with_bends, kept | bent[line], *every, int(bent.sum()))


def _bends(best: Robust) -> Bends:
    """What a curve of their own explains of the lines under a fit."""
    along, _ = best.agreed.lines.place(best.picks.ideal.uv, best.picks.line)
    sigma_px = max(_sigma_px(best.problem, best.solution), finest(best.problem))
    of_line = np.full(len(best.picks.sizes), sigma_px)
    rounding_px = rounded(best.picks.finest_px)
    return bends(best.picks.line, along, best.agreed.distance_px, of_line, rounding_px)


def _beliefs(problem: Problem, plain: Solution) -> list[NDArray[np.bool_]]:
    """Which picks agree under the best of many lenses, and under the plain one."""
    wrong_px = _wrong_px(problem)
    begun = beginnings(problem, wrong_px)
    lenses = [(each.picks, each.sigma_px) for each in begun]
    if not int(plain.folded):
        lenses.append((picks_at([problem], [plain]), begun[0].sigma_px))
    far = reach(problem.dof, len(problem.kept))
    return [agree(picks, sigma_px, wrong_px, far).kept for picks, sigma_px in lenses]


def _best(
    problem: Problem, beliefs: Sequence[NDArray[np.bool_]], shares: tuple[float, ...]
) -> Robust | DegenerateLinesError | None:
    """The likeliest fit that is reached from first beliefs, the leverage of picks allowed for."""
    seen: list[NDArray[np.bool_]] = []
    found = [_settled(problem, kept, seen, _agreeing, shares) for kept in beliefs]
    fits = [each for each in found if isinstance(each, Robust)]
    if not fits:
        return next((each for each in found if each), None)
    best = max(fits, key=lambda each: each.agreed.evidence)
    rivals = tuple(
        lens_of(each.problem, each.solution)
        for each in fits
        if each is not best and each.agreed.evidence > best.agreed.evidence - EVIDENCE
    )
    kept = _by_leverage(best)
    better = _settled(problem, kept, [best.problem.kept], _by_leverage, shares)
    return replace(better if isinstance(better, Robust) else best, rivals=rivals)


def _settled(
    problem: Problem,
    kept: NDArray[np.bool_],
    seen: list[NDArray[np.bool_]],
    rule: Callable[[Robust], NDArray[np.bool_]],
    shares: tuple[float, ...],
) -> Robust | DegenerateLinesError | None:
    """Decide lens and picks in turn, until the picks are those of a round before.

    Args:
        problem: The problem.
        kept: The picks believed first.
        seen: Beliefs that need not be tried again; those tried are added.
        rule: Which picks to believe next.
        shares: What σ may be, as shares of σ̂.
    """
    found: Robust | DegenerateLinesError | None = None
    for _ in range(_MOST_ROUNDS):
        if any(np.array_equal(kept, other) for other in seen):
            break
        seen.append(kept)
        try:
            believed = problem.keeping(kept)
        except DegenerateLinesError as error:
            return found or error
        found = _at(believed, solve(problem.model, believed.task), shares)
        kept = rule(found)
    return found


def _at(problem: Problem, solution: Solution, shares: tuple[float, ...]) -> Robust:
    """What the picks agree on under a fit; those on other lines may be theirs."""
    picks = picks_at([problem], [solution])
    wrong_px, far = _wrong_px(problem), reach(problem.dof, len(problem.kept))
    photos = np.array([line.photo for line in problem.observations.lines])
    sigmas = [max(share * _sigma_px(problem, solution), finest(problem)) for share in shares]
    every = [agree(picks, sigma_px, wrong_px, far) for sigma_px in sigmas]
    likeliest = int(np.argmax([each.evidence for each in every]))
    agreed, sigma_px = every[likeliest], sigmas[likeliest]
    if not agreed.kept.all():
        excuse = excuses(picks, agreed, photos, sigma_px, wrong_px)
        if np.any(excuse > _NO_EXCUSE):
            agreed = agree(picks, sigma_px, wrong_px, far, excuse)
        unclear = contested(picks, agreed, photos, far * sigma_px)[picks.line]
        agreed = replace(agreed, wrong=agreed.wrong & ~unclear)
    return Robust(problem, solution, picks, agreed)


def _agreeing(found: Robust) -> NDArray[np.bool_]:
    """The picks that agree."""
    return found.agreed.kept


def _by_leverage(found: Robust) -> NDArray[np.bool_]:
    """Which picks lie within reach, with what each of them does to line and lens allowed for.

    A pick at the end of an outer line draws the lens after it and hides its own error; this shows
    once the rest is good.
    """
    believed = found.problem
    lens, free = lens_of(believed, found.solution), believed.plan.free
    lines_px = in_frame(believed.observations, lens.frame)
    linear = linearise(lens, lines_px, free, believed.kept, image=True)
    square = float(np.sum(linear.residual_px[linear.kept] ** 2))
    sigma_px = max(float(np.sqrt(square / believed.dof)), finest(believed))
    near = np.abs(linear.studentised(sigma_px)) < reach(believed.dof, len(linear.line))
    line, n_lines, agreed = linear.line, linear.n_lines, found.agreed
    known = np.bincount(line, believed.kept & agreed.kept, n_lines) > 0
    near = np.where(known[line], near & (agreed.lines.count >= LEAST)[line], agreed.kept)
    near &= ~agreed.wrong
    return near & (np.bincount(line, near, n_lines) >= LEAST)[line]


def _sigma_px(problem: Problem, solution: Solution) -> float:
    return float(np.sqrt(np.sum(solution.residual**2) / problem.dof))


def _wrong_px(problem: Problem) -> float:
    return _WRONG * problem.blank.frame.radius_px

"""One fit, from observations to a calibration that names its suspicious picks."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import partial
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from plumbline.errors import CollapsedFitError, DegenerateLinesError, PlumblineError, or_error
from plumbline.fit.bends.judged import bent_fits
from plumbline.fit.outcome import finish, finish_many
from plumbline.fit.problem import Problem, Start, prepare
from plumbline.fit.program.solve import solve
from plumbline.fit.program.task import Solution
from plumbline.fit.robust.fits import Robust, robust_fits
from plumbline.fit.robust.screening import reach
from plumbline.fit.robust.suspects import suspects_of
from plumbline.geometry.lens import Lens
from plumbline.models import get_model
from plumbline.observations import Observations
from plumbline.result.calibration import Calibration
from plumbline.trust.assessment import ResidualKind
from plumbline.trust.displacement import difference_px
from plumbline.trust.rival import APART
from plumbline.wording import count, number

_Found: TypeAlias = Robust | DegenerateLinesError | None
"""What `robust_fits` gives for one problem."""


def fit_one(
    observations: Observations,
    model: str,
    *,
    free: Iterable[str] | None,
    hold: Iterable[str] = (),
    start: Start = None,
    residual: ResidualKind = "image",
    robust: bool = False,
) -> Calibration:
    """Fit one model to the picks of one lens; arguments and errors as for `calibrate`."""
    problem = prepare(observations, get_model(model), free, hold, start, residual)
    solution = solve(problem.model, problem.task)
    if problem.plan.staged:
        return _only(finished([problem], [solution], robust=robust))
    from_zero = replace(problem, task=problem.task._replace(staged=True))
    return _compared_with_zero(problem, solution, from_zero, robust=robust)


def _only(outcomes: Sequence[Calibration | PlumblineError]) -> Calibration:
    """The one calibration.

    Raises:
        DegenerateLinesError: there is none; CollapsedFitError: it is nonsense.
    """
    (calibration,) = outcomes
    if isinstance(calibration, PlumblineError):
        raise calibration
    return calibration


def finished(
    problems: Sequence[Problem], solutions: Sequence[Solution], *, robust: bool
) -> list[Calibration | PlumblineError]:
    """Calibrations of one model with their suspects; errors in their place."""
    bent = bent_fits(problems, solutions, robust=robust)
    rest = [number for number, each in enumerate(bent) if each is None]
    others = iter(
        _unbent([problems[n] for n in rest], [solutions[n] for n in rest], robust=robust)
        if rest
        else ()
    )
    return [next(others) if each is None else each for each in bent]


def _unbent(
    problems: Sequence[Problem], solutions: Sequence[Solution], *, robust: bool
) -> list[Calibration | PlumblineError]:
    """The same for edges that are not seen to bend: each pick is judged by itself."""
    found = robust_fits(problems, solutions)
    if not robust:
        plain = zip(finish_many(problems, solutions), found, strict=True)
        return [
            each if other is None or isinstance(each, PlumblineError) else _accused(each, other)
            for each, other in plain
        ]

    def believed(problem: Problem, solution: Solution, other: _Found) -> Calibration:
        one = finish(problem, solution) if other is None else _believed(other, problem, solution)
        return replace(one, robust=True)

    every = zip(problems, solutions, found, strict=True)
    return [or_error(partial(believed, *each)) for each in every]


def _suspecting(found: Robust | DegenerateLinesError) -> Calibration:
    """The robust fit and what it suspects.

    Raises:
        DegenerateLinesError: the picks that can be believed do not determine the lens.
    """
    if isinstance(found, DegenerateLinesError):
        raise found
    calibration = finish(found.problem, found.solution)
    suspects = suspects_of(calibration, found)
    return replace(calibration, suspects=suspects, rival_px=_rival_px(calibration, found.rivals))


def _rival_px(calibration: Calibration, rivals: Sequence[Lens]) -> float | None:
    """How far the farthest of other lenses is from the fitted one; None where that is no news."""
    points_px = calibration.trust.range_px
    perspective = calibration.lens.model.decentred(calibration.free)
    apart_px = max(
        (
            difference_px(calibration.lens, other, points_px, perspective=perspective)
            for other in rivals
        ),
        default=0.0,
    )
    sure = calibration.quoted
    return apart_px if sure is None or apart_px > APART * sure.worst_px else None


def _believed(
    found: Robust | DegenerateLinesError, problem: Problem, solution: Solution
) -> Calibration:
    """The robust fit, or the plain one where a richer model explains what the robust leaves out."""
    calibration = _suspecting(found)
    try:
        plain = finish(problem, solution)
    except DegenerateLinesError:
        return calibration
    note = _explained(plain, calibration)
    return replace(plain, remarks=(*plain.remarks, note)) if note else calibration


def _explained(plain: Calibration, believed: Calibration) -> str:
    """What to say where accused picks are right under a richer model; else empty.

    Args:
        plain: The fit to all picks.
        believed: The robust fit, with the picks that it accuses.
    """
    ends = np.cumsum(plain.observations.sizes)
    accused = np.zeros(plain.observations.n_points, dtype=np.bool_)
    for suspect in believed.suspects:
        if suspect.left_out:
            first = int(ends[suspect.line] - plain.observations.sizes[suspect.line])
            accused[[first + pick for pick in suspect.picks]] = True
    sigma_px = believed.sigma_px
    if not accused.any() or not (
        _right_with_more(plain, accused, sigma_px)
        or plain.trust.besides.explains(accused, sigma_px)
    ):
        return ""
    return (
        f"{count(int(np.count_nonzero(accused)), 'pick')} would look wrong under this model and "
        "right under a richer one: the model is too simple, not the picks wrong; see plumbline "
        "compare"
    )


def _right_with_more(plain: Calibration, accused: NDArray[np.bool_], sigma_px: float) -> bool:
    """Whether accused picks are like the others once all radial coefficients are free."""
    model = plain.lens.model
    free = (*model.radial, *(name for name in plain.free if name not in model.radial))
    if set(free) == set(plain.free):
        return False
    try:
        problem = prepare(plain.observations, model, free, (), None, plain.residual)
        calibration = finish(problem, solve(model, problem.task))
    except PlumblineError:
        return False
    # Wrong picks would make the richer model's σ̂ as large as they are, and be right by it.
    sigma_px = min(calibration.sigma_px, sigma_px)
    away = np.abs(calibration.linearised.studentised(sigma_px)[accused])
    return bool(calibration.converged and np.max(away) < reach(calibration.dof, len(accused)))


def _accused(plain: Calibration, found: Robust | DegenerateLinesError) -> Calibration:
    """The plain fit with the picks that the robust one suspects."""
    try:
        believed = _suspecting(found)
        if note := _explained(plain, believed):
            return replace(plain, remarks=(*plain.remarks, note))
        return replace(plain, suspects=believed.suspects, rival_px=believed.rival_px)
    except DegenerateLinesError as error:
        note = f"which picks are wrong cannot be told: without the suspicious ones {error.message}"
        return replace(plain, remarks=(*plain.remarks, note))


def _compared_with_zero(
    problem: Problem, solution: Solution, staged: Problem, *, robust: bool
) -> Calibration:
    """The fit from the user's start vector; if the one from zero ends lower, both are told."""

    def fitted(which: Problem, found: Solution) -> Calibration:
        return _only(finished([which], [found], robust=robust))

    try:
        from_zero = fitted(staged, solve(staged.model, staged.task))
    except PlumblineError:
        return fitted(problem, solution)
    values = ", ".join(f"{n} = {number(from_zero.coefficients[n], '.6g')}" for n in from_zero.free)
    reached = f"starting from zero reaches {from_zero.rms_after_px:.4g} px with {values}"
    try:
        calibration = fitted(problem, solution)
    except DegenerateLinesError as error:
        raise CollapsedFitError(
            f"this start vector does not lead to a fit ({error.message}), while {reached}",
            hint="leave out --start",
        ) from None
    if from_zero.rms_after_px > calibration.rms_after_px * (1 - 1e-6) - 1e-9:
        return calibration
    note = (
        f"this start vector leads to a worse fit ({calibration.rms_after_px:.4g} px): {reached}; "
        "leave out --start"
    )
    return replace(calibration, remarks=(*calibration.remarks, note))

"""One fit, from observations to a calibration that names its suspicious picks."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from plumbline.errors import About, CollapsedFitError, DegenerateLinesError, PlumblineError
from plumbline.fit.bends.judged import bent_fits
from plumbline.fit.outcome import finish, finish_many
from plumbline.fit.problem import Problem, Start, prepare
from plumbline.fit.program.solve import solve
from plumbline.fit.program.task import Solution
from plumbline.fit.robust.fits import Robust, robust_fits
from plumbline.fit.robust.screening import reach
from plumbline.fit.robust.suspects import suspects_of
from plumbline.models import get_model
from plumbline.observations import Observations
from plumbline.result.calibration import Calibration
from plumbline.trust.assessment import ResidualKind
from plumbline.trust.suspect import Suspect
from plumbline.wording import count, number


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
        return finished([problem], [solution], [""], robust=robust)[0]
    from_zero = replace(problem, task=problem.task._replace(staged=True))
    return _compared_with_zero(problem, solution, from_zero, robust=robust)


def finished(
    problems: Sequence[Problem],
    solutions: Sequence[Solution],
    names: Sequence[str],
    *,
    robust: bool,
) -> list[Calibration]:
    """Calibrations of one model with their suspects; errors begin with the lens's name."""
    bent = bent_fits(problems, solutions, robust=robust)
    rest = [number for number, each in enumerate(bent) if each is None]
    others = iter(
        _unbent(
            [problems[number] for number in rest],
            [solutions[number] for number in rest],
            [names[number] for number in rest],
            robust=robust,
        )
        if rest
        else ()
    )
    return [next(others) if each is None else each for each in bent]


def _unbent(
    problems: Sequence[Problem],
    solutions: Sequence[Solution],
    names: Sequence[str],
    *,
    robust: bool,
) -> list[Calibration]:
    """The same for edges that are not seen to bend: each pick is judged by itself."""
    found = robust_fits(problems, solutions)
    if not robust:
        plain = zip(finish_many(problems, solutions, names), found, strict=True)
        return [each if other is None else _accused(each, other) for each, other in plain]
    calibrations: list[Calibration] = []
    for problem, solution, other, name in zip(problems, solutions, found, names, strict=True):
        with About(name):
            one = (
                finish(problem, solution) if other is None else _believed(other, problem, solution)
            )
        calibrations.append(replace(one, robust=True))
    return calibrations


def _suspecting(found: Robust | DegenerateLinesError) -> Calibration:
    """The robust fit and what it suspects.

    Raises:
        DegenerateLinesError: the picks that can be believed do not determine the lens.
    """
    if isinstance(found, DegenerateLinesError):
        raise found
    calibration = finish(found.problem, found.solution)
    return replace(calibration, suspects=suspects_of(calibration, found))


def _believed(
    found: Robust | DegenerateLinesError, problem: Problem, solution: Solution
) -> Calibration:
    """The robust fit, or the plain one where a richer model explains what the robust leaves out."""
    calibration = _suspecting(found)
    try:
        plain = finish(problem, solution)
    except DegenerateLinesError:
        return calibration
    note = _explained(plain, calibration.suspects)
    return replace(plain, remarks=(*plain.remarks, note)) if note else calibration


def _explained(plain: Calibration, suspects: Sequence[Suspect]) -> str:
    """What to say where accused picks are right under a richer model; else empty."""
    ends = np.cumsum(plain.observations.sizes)
    accused = np.zeros(plain.observations.n_points, dtype=np.bool_)
    for suspect in suspects:
        if suspect.left_out:
            first = int(ends[suspect.line] - plain.observations.sizes[suspect.line])
            accused[[first + pick for pick in suspect.picks]] = True
    if not accused.any() or not (
        _right_with_more(plain, accused) or plain.trust.besides.explains(accused)
    ):
        return ""
    return (
        f"{count(int(np.count_nonzero(accused)), 'pick')} would look wrong under this model and "
        "right under a richer one: the model is too simple, not the picks wrong; see plumbline "
        "compare"
    )


def _right_with_more(plain: Calibration, accused: NDArray[np.bool_]) -> bool:
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
    away = np.abs(calibration.linearised.studentised(calibration.sigma_px)[accused])
    return bool(calibration.converged and np.max(away) < reach(calibration.dof, len(accused)))


def _accused(plain: Calibration, found: Robust | DegenerateLinesError) -> Calibration:
    """The plain fit with the picks that the robust one suspects."""
    try:
        suspects = _suspecting(found).suspects
        if note := _explained(plain, suspects):
            return replace(plain, remarks=(*plain.remarks, note))
        return replace(plain, suspects=suspects)
    except DegenerateLinesError as error:
        note = f"which picks are wrong cannot be told: without the suspicious ones {error.message}"
        return replace(plain, remarks=(*plain.remarks, note))


def _compared_with_zero(
    problem: Problem, solution: Solution, staged: Problem, *, robust: bool
) -> Calibration:
    """The fit from the user's start vector; if the one from zero ends lower, both are told."""

    def fitted(which: Problem, found: Solution) -> Calibration:
        return finished([which], [found], [""], robust=robust)[0]

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

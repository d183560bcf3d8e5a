"""From what the solver found to calibrations, unless that would be nonsense."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from plumbline.errors import PlumblineError, or_error
from plumbline.fit.bends.generalised import bending
from plumbline.fit.problem import Problem
from plumbline.fit.program.blocks import unpack
from plumbline.fit.program.task import Solution
from plumbline.fit.refusals import (
    refuse_bent,
    refuse_collapsed,
    refuse_undetermined,
    refuse_unobservable,
)
from plumbline.fit.uncertainty import corner_errors
from plumbline.frame import Array
from plumbline.geometry.lens import Lens
from plumbline.geometry.lines import by_line
from plumbline.models import CENTRE
from plumbline.result.calibration import Calibration
from plumbline.trust.covariance import sandwich, unit_covariances

_SETTLED_PX = 1e-4
"""Change of all residuals together by the last step: chosen, since nobody sees it."""

_SETTLED_SHARE = 1e-3
"""The same as a share of σ̂: a step of one standard error changes the residuals by σ̂, so that what
is left is a thousandth of the error of any coefficient."""


def finish(problem: Problem, solution: Solution) -> Calibration:
    """Make a calibration of what the solver found.

    Args:
        problem: What it was given.
        solution: What it found.

    Raises:
        DegenerateLinesError: the lines do not determine the free coefficients.
        CollapsedFitError: the fit reached a small residual by a nonsensical lens.
    """
    (calibration,) = finish_many([problem], [solution])
    if isinstance(calibration, PlumblineError):
        raise calibration
    return calibration


def finish_many(
    problems: Sequence[Problem], solutions: Sequence[Solution]
) -> list[Calibration | PlumblineError]:
    """The same for problems of one model whose blocks have one shape; errors in their place."""
    chosen = np.stack([problem.task.free for problem in problems])
    unit = unit_covariances(np.stack([solution.normal for solution in solutions]), chosen)
    found = np.stack([solution.coefficients for solution in solutions])
    corner = np.array([problem.task.corner for problem in problems])
    model, k = problems[0].model, len(problems[0].model.coefficients)
    corners = corner_errors(model, found[:, :k], unit.covariance[:, :k, :k], corner)
    residuals_px = unpack(
        [problem.packed for problem in problems], [solution.residual for solution in solutions]
    )
    ends = np.cumsum([len(problem.kept) for problem in problems])[:-1]

    def finished(index: int, residual_px: Array) -> Calibration:
        problem, solution = problems[index], solutions[index]
        lens, radius_px = lens_of(problem, solution), problem.blank.frame.radius_px
        refuse_collapsed(lens, float(solution.scale), int(solution.folded))
        sigma_px = float(np.sqrt(residual_px @ residual_px / problem.dof))
        by_lines_px = by_line(residual_px.copy(), problem.packed.sizes)
        refuse_bent(sigma_px, radius_px, problem.observations.lines, by_lines_px)
        refuse_undetermined(unseen=bool(unit.unseen[index]), mixed=bool(unit.mixed[index]))
        covariance = unit.covariance[index] * np.outer(problem.to_px, problem.to_px)
        centre_px = float(np.sqrt(np.max(np.diagonal(covariance)[-2:])))
        corner_px = float(corners[index]) * lens.unit_px
        refuse_unobservable(centre_px, corner_px, radius_px, sigma_px)
        free = problem.task.free
        covariance = sigma_px**2 * covariance[free][:, free]
        return _assembled(problem, solution, lens, covariance, sigma_px, by_lines_px)

    return [
        or_error(partial(finished, index, residual_px))
        for index, residual_px in enumerate(np.split(residuals_px, ends))
    ]


def _assembled(
    problem: Problem,
    solution: Solution,
    lens: Lens,
    covariance: Array,
    sigma_px: float,
    residuals_px: tuple[Array, ...],
) -> Calibration:
    converged = is_settled(solution, problem.dof)
    n_kept = int(np.count_nonzero(problem.kept))
    calibration = Calibration(
        observations=problem.observations,
        lens=lens,
        free=problem.plan.free,
        start=dict(problem.plan.start),
        residual=problem.residual,
        covariance=covariance,
        sigma_px=sigma_px,
        dof=problem.dof,
        residuals_px=residuals_px,
        rms_corrected_px=float(np.sqrt(solution.corrected_square / n_kept)),
        converged=converged,
        reason="the fit ended in a minimum"
        if converged
        else f"the fit stopped after {int(solution.steps)} steps without reaching a minimum",
        remarks=problem.plan.notes,
        kept=by_line(problem.kept, problem.packed.sizes),
    )
    if problem.residual == "corrected":
        calibration = _with_sandwich(calibration)
    calibration = bending(calibration)
    return calibration if n_kept == len(problem.kept) else _with_left_out(calibration)


def is_settled(solution: Solution, dof: int) -> bool:
    """Whether the fit ended in a minimum."""
    sigma_px = float(np.sqrt(np.sum(np.square(solution.residual)) / dof))
    limit_px = max(_SETTLED_PX, _SETTLED_SHARE * sigma_px)
    return bool(float(solution.last_step_px) < limit_px)


def lens_of(problem: Problem, solution: Solution) -> Lens:
    """The lens that the solver found."""
    blank, plan = problem.blank, problem.plan
    values = (solution.coefficients * problem.to_px).tolist()
    found = dict(zip((*problem.model.coefficients, *CENTRE), values, strict=True))
    held = {name: value for name, value in plan.start.items() if name not in plan.free}
    return Lens(blank.model, blank.frame, found | held, blank.focal_px)


def _with_sandwich(calibration: Calibration) -> Calibration:
    """Residuals of the corrected photo have unequal variances: σ̂ and covariance that know it."""
    covariance, sigma_px = sandwich(calibration.linearised, calibration.dof)
    return replace(calibration, covariance=covariance, sigma_px=sigma_px)


def _with_left_out(calibration: Calibration) -> Calibration:
    """Residuals of the picks left out, which the solver gives as 0."""
    sizes = np.array([len(values) for values in calibration.residuals_px])
    every = np.where(
        np.concatenate(calibration.kept),
        np.concatenate(calibration.residuals_px),
        calibration.linearised.residual_px,
    )
    return replace(calibration, residuals_px=by_line(every, sizes))

"""From what the solver found to a calibration, unless that would be nonsense."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from plumbline.calibration import Calibration
from plumbline.fit.problem import Problem, pixels_of_centre
from plumbline.fit.task import Solution
from plumbline.fit.uncertainty import (
    refuse_bent,
    refuse_collapsed,
    refuse_unobservable,
    sandwich,
    unit_covariance,
)
from plumbline.lens import Lens
from plumbline.models import CENTRE
from plumbline.straightness import by_line

_SETTLED_PX = 1e-4


def finish(problem: Problem, solution: Solution) -> Calibration:
    """Make a calibration of what the solver found.

    Args:
        problem: What it was given.
        solution: What it found.

    Raises:
        DegenerateLinesError: the lines do not determine the free coefficients.
        CollapsedFitError: the fit reached a small residual by a nonsensical lens.
    """
    packed, chosen = problem.packed, problem.plan
    lens = lens_of(problem, solution)
    refuse_collapsed(lens, float(solution.scale), int(solution.folded))
    fitted = packed.unpack(solution.residual)
    residuals_px = by_line(fitted, packed.sizes)
    sigma_px = float(np.sqrt(fitted @ fitted / problem.dof))
    labels = [line.label for line in problem.observations.lines]
    refuse_bent(sigma_px, lens.frame.radius_px, labels, residuals_px)
    free, to_px = problem.task.free, pixels_of_centre(problem.blank)
    unit = unit_covariance(solution.normal[np.ix_(free, free)])
    unit = unit * np.outer(to_px[free], to_px[free])
    refuse_unobservable(lens, chosen.free, unit, sigma_px)
    converged = is_settled(solution, lens)
    made = Calibration(
        observations=problem.observations,
        lens=lens,
        free=chosen.free,
        start=dict(chosen.start),
        residual=problem.residual,
        covariance=sigma_px**2 * unit,
        sigma_px=sigma_px,
        dof=problem.dof,
        residuals_px=residuals_px,
        rms_corrected_px=float(np.sqrt(solution.corrected_square / np.count_nonzero(problem.kept))),
        converged=converged,
        reason="the fit ended in a minimum"
        if converged
        else f"the fit stopped after {int(solution.steps)} steps without reaching a minimum",
        remarks=chosen.notes,
        kept=by_line(problem.kept, packed.sizes),
    )
    if problem.residual == "corrected":
        made = _with_sandwich(made)
    return made if problem.kept.all() else _with_left_out(made)


def is_settled(solution: Solution, lens: Lens) -> bool:
    """Whether the fit ended in a minimum."""
    return bool(float(solution.last_step) * lens.unit_px < _SETTLED_PX)


def lens_of(problem: Problem, solution: Solution) -> Lens:
    """The lens that the solver found."""
    names = (*problem.model.coefficients, *CENTRE)
    to_px = pixels_of_centre(problem.blank)
    found = dict(zip(names, (solution.coefficients * to_px).tolist(), strict=True))
    plan = problem.plan
    held = {name: value for name, value in plan.start.items() if name not in plan.free}
    return replace(problem.blank, coefficients=found | held)


def _with_sandwich(made: Calibration) -> Calibration:
    """Residuals of the corrected photo have unequal variances: σ̂ and covariance that know it."""
    covariance, sigma_px = sandwich(made.linearised, made.dof)
    return replace(made, covariance=covariance, sigma_px=sigma_px)


def _with_left_out(made: Calibration) -> Calibration:
    """Residuals of the picks left out, which the solver gives as 0."""
    sizes = np.array([len(values) for values in made.residuals_px])
    every = np.where(
        np.concatenate(made.kept), np.concatenate(made.residuals_px), made.linearised.residual_px
    )
    return replace(made, residuals_px=by_line(every, sizes))

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
    unit_covariance,
)
from plumbline.models import CENTRE

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
    model, packed, chosen = problem.model, problem.packed, problem.plan
    names = (*model.coefficients, *CENTRE)
    to_px = pixels_of_centre(problem.blank)
    found = dict(zip(names, (solution.coefficients * to_px).tolist(), strict=True))
    held = {name: value for name, value in chosen.start.items() if name not in chosen.free}
    lens = replace(problem.blank, coefficients=found | held)
    at = solution.residuals
    refuse_collapsed(lens, packed.unpack(at.determinant), packed.unpack(at.excess))
    corrected = packed.unpack(at.corrected)
    fitted = packed.unpack(at.image) if problem.residual == "image" else corrected
    sigma_px = float(np.sqrt(fitted @ fitted / problem.dof))
    residuals_px = tuple(np.split(fitted, np.cumsum(packed.sizes)[:-1]))
    labels = [line.label for line in problem.observations.lines]
    refuse_bent(sigma_px, lens.frame.radius_px, labels, residuals_px)
    free = problem.task.free
    unit = unit_covariance(solution.normal[np.ix_(free, free)])
    unit = unit * np.outer(to_px[free], to_px[free])
    refuse_unobservable(lens, chosen.free, unit, sigma_px)
    converged = bool(float(solution.last_step) * lens.unit_px < _SETTLED_PX)
    return Calibration(
        observations=problem.observations,
        lens=lens,
        free=chosen.free,
        start=dict(chosen.start),
        residual=problem.residual,
        covariance=sigma_px**2 * unit,
        sigma_px=sigma_px,
        dof=problem.dof,
        residuals_px=residuals_px,
        rms_corrected_px=float(np.sqrt(corrected @ corrected / len(corrected))),
        converged=converged,
        reason="the fit ended in a minimum"
        if converged
        else f"the fit stopped after {int(solution.steps)} steps without reaching a minimum",
        remarks=chosen.notes,
    )

"""Fits of dense samples, whose suspects are judged by how edges bend."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from plumbline.errors import PlumblineError
from plumbline.fit.bends.generalised import is_dense
from plumbline.fit.bends.suspects import named, strays
from plumbline.fit.outcome import finish
from plumbline.fit.problem import Problem
from plumbline.fit.program.solve import solve
from plumbline.fit.program.task import Solution
from plumbline.result.calibration import Calibration


def bent_fits(
    problems: Sequence[Problem], solutions: Sequence[Solution], *, robust: bool
) -> list[Calibration | None]:
    """Calibrations of problems whose edges are seen to bend, with their suspects.

    Args:
        problems: The problems, all picks kept.
        solutions: Their ordinary fits.
        robust: Leave strays out; a stretch or a line that bends stays, and weighs as it bends.

    Returns:
        None for each of the others, which know no bends.
    """
    return [
        _bent_fit(problem, solution, robust=robust)
        for problem, solution in zip(problems, solutions, strict=True)
    ]


def _bent_fit(problem: Problem, solution: Solution, *, robust: bool) -> Calibration | None:
    if problem.residual != "image" or not is_dense(problem.packed.sizes):
        return None
    try:
        plain = finish(problem, solution)
        wrong = strays(plain.linearised)
        clean = plain
        if wrong.any():
            others = problem.keeping(problem.kept & ~wrong)
            clean = finish(others, solve(problem.model, others.task))
    except PlumblineError:
        return None  # the search for wrong picks says why
    if clean.bends is None:
        return None
    return replace(
        clean if robust else plain, suspects=named(clean, np.asarray(wrong)), robust=robust
    )

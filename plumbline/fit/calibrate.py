"""Calibrate a lens from straight lines: the entry points of the fit."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from plumbline.errors import About, CollapsedFitError, DegenerateLinesError, PlumblineError
from plumbline.fit.outcome import finish, finish_many
from plumbline.fit.problem import Problem, Start, prepare, prepare_many
from plumbline.fit.program.blocks import shape_of
from plumbline.fit.program.solve import BATCH, launch, solve
from plumbline.fit.program.task import Solution
from plumbline.fit.robust.fits import Robust, robust_fits
from plumbline.fit.robust.suspects import suspects_of
from plumbline.models import get_model
from plumbline.observations import Observations
from plumbline.result.calibration import Calibration
from plumbline.trust.assessment import ResidualKind

_CHUNK = 4 * BATCH
"""Problems that are prepared, fitted, screened and finished in one go."""

_AHEAD = 2
"""How many of these are prepared while JAX fits those before and a thread finishes others."""


def calibrate(
    observations: Observations,
    model: str = "ptlens",
    *,
    free: Iterable[str] | None = None,
    hold: Iterable[str] = (),
    start: Start = None,
    residual: ResidualKind = "image",
    robust: bool = False,
) -> Calibration:
    """Find the distortion that makes every picked line straight.

    Args:
        observations: Photos of one lens and the lines picked in them.
        model: Name of the distortion model, see `plumbline.MODELS`.
        free: Coefficients to fit; None for what the project asks for, else all of the model's.
            `d` and `e`, the distortion centre in pixels, may be among them.
        hold: Coefficients to hold nevertheless.
        start: Start vector by name; coefficients it leaves out start at 0. None starts from
            nothing and cannot end in a wrong minimum; "file" takes the project's values. Held
            coefficients stay at their start value; `d` and `e` at the project's.
        residual: "image" minimises distances in the photograph's own pixels, where picking
            errors live; "corrected" those in the corrected photo, as Hugin does.
        robust: Leave suspicious picks out. A plain fit uses all, and names these in `suspects`.

    Returns:
        The calibration. One that did not end in a minimum says so in `converged`. Its `lens` is
        for photos of the first photo's size and orientation.

    Raises:
        OptionError: an argument is unknown or contradicts the observations.
        DegenerateLinesError: the lines cannot determine the free coefficients.
        CollapsedFitError: they would, but only by a nonsensical lens.

    Example:
        >>> import plumbline
        >>> obs = plumbline.read("building.pto")  # doctest: +SKIP
        >>> plumbline.calibrate(obs).coefficients  # doctest: +SKIP
        {'a': 0.032, 'b': -0.098, 'c': 0.042, 'd': 0.0, 'e': 0.0}
    """
    problem = prepare(observations, get_model(model), free, hold, start, residual)
    solution = solve(problem.model, problem.task)
    if problem.plan.staged:
        return _finished([problem], [solution], [""], robust=robust)[0]
    from_zero = replace(problem, task=problem.task._replace(staged=True))
    return _compared_with_zero(problem, solution, from_zero, robust=robust)


def calibrate_many(
    observations: Sequence[Observations],
    model: str = "ptlens",
    *,
    free: Iterable[str] | None = None,
    hold: Iterable[str] = (),
    residual: ResidualKind = "image",
    robust: bool = False,
) -> list[Calibration]:
    """Calibrate many lenses at once, in compiled batches of problems of like size.

    Args:
        observations: Each the photos and lines of one lens.
        model: As for `calibrate`.
        free: As for `calibrate`.
        hold: As for `calibrate`.
        residual: As for `calibrate`.
        robust: As for `calibrate`.

    Returns:
        One calibration each, in the same order, the same as `calibrate` gives.

    Raises:
        PlumblineError: as `calibrate`, for one of the lenses that fail; the sentence names its
            number from 0. None of the results is returned then.
    """
    chosen, held = None if free is None else tuple(free), tuple(hold)
    batches: dict[tuple[int, int], list[int]] = {}
    for index, each in enumerate(observations):
        batches.setdefault(shape_of(each), []).append(index)
    chunks = [
        members[first : first + _CHUNK]
        for members in batches.values()
        for first in range(0, len(members), _CHUNK)
    ]

    made: list[Calibration] = []
    running: deque[Future[list[Calibration]]] = deque()
    with ThreadPoolExecutor(1) as pool:
        for chunk in chunks:
            some, names = [observations[index] for index in chunk], [f"lens {i}: " for i in chunk]
            problems = prepare_many(some, names, get_model(model), chosen, held, None, residual)
            solutions = launch(get_model(model), [problem.task for problem in problems])
            running.append(pool.submit(_finished_later, problems, solutions, names, robust=robust))
            if len(running) > _AHEAD:
                made += running.popleft().result()
        for last in running:
            made += last.result()
    order = np.argsort([index for chunk in chunks for index in chunk])
    return [made[place] for place in order.tolist()]


def _finished_later(
    problems: Sequence[Problem],
    solutions: Callable[[], list[Solution]],
    names: Sequence[str],
    *,
    robust: bool,
) -> list[Calibration]:
    return _finished(problems, solutions(), names, robust=robust)


def _finished(
    problems: Sequence[Problem],
    solutions: Sequence[Solution],
    names: Sequence[str],
    *,
    robust: bool,
) -> list[Calibration]:
    """Calibrations of one model with their suspects; errors begin with the lens's name."""
    found = robust_fits(problems, solutions)
    if not robust:
        plain = zip(finish_many(problems, solutions, names), found, strict=True)
        return [made if other is None else _accused(made, other) for made, other in plain]
    made: list[Calibration] = []
    for problem, solution, other, name in zip(problems, solutions, found, names, strict=True):
        with About(name):
            one = finish(problem, solution) if other is None else _suspecting(other)
        made.append(replace(one, robust=True))
    return made


def _suspecting(found: Robust | DegenerateLinesError) -> Calibration:
    """The robust fit and what it suspects.

    Raises:
        DegenerateLinesError: the picks that can be believed do not determine the lens.
    """
    if isinstance(found, DegenerateLinesError):
        raise found
    made = finish(found.problem, found.solution)
    return replace(made, suspects=suspects_of(made, found))


def _accused(plain: Calibration, found: Robust | DegenerateLinesError) -> Calibration:
    """The plain fit with the picks that the robust one suspects."""
    try:
        return replace(plain, suspects=_suspecting(found).suspects)
    except DegenerateLinesError as error:
        note = f"which picks are wrong cannot be told: without the suspicious ones {error.message}"
        return replace(plain, remarks=(*plain.remarks, note))


def _compared_with_zero(
    problem: Problem, solution: Solution, staged: Problem, *, robust: bool
) -> Calibration:
    """The fit from the user's start vector; if the one from zero ends lower, both are told."""

    def fitted(which: Problem, found: Solution) -> Calibration:
        return _finished([which], [found], [""], robust=robust)[0]

    try:
        from_zero = fitted(staged, solve(staged.model, staged.task))
    except PlumblineError:
        return fitted(problem, solution)
    values = ", ".join(f"{n} = {from_zero.coefficients[n]:.6g}" for n in from_zero.free)
    reached = f"starting from zero reaches {from_zero.rms_after_px:.4g} px with {values}"
    try:
        made = fitted(problem, solution)
    except DegenerateLinesError as error:
        raise CollapsedFitError(
            f"this start vector leads nowhere ({error.message}), while {reached}",
            hint="leave out --start",
        ) from None
    if from_zero.rms_after_px > made.rms_after_px * (1 - 1e-6) - 1e-9:
        return made
    note = (
        f"this start vector leads to a worse fit ({made.rms_after_px:.4g} px): {reached}; leave "
        "out --start"
    )
    return replace(made, remarks=(*made.remarks, note))

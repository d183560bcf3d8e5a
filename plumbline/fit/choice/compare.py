"""Fit all models to the same picks: which is enough?

Every model is fitted to the same picks; what counts is how straight it leaves lines that did not
take part in its fit, and by how many pixels of the corrected photo its curve differs from the
others'. `plumbline.fit.choice.recommend` chooses among them.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from plumbline.errors import DegenerateLinesError, PlumblineError
from plumbline.fit.choice.determined import determined
from plumbline.fit.choice.reasons import beyond, left_out, quote, reason
from plumbline.fit.choice.recommend import choose
from plumbline.fit.choice.rows import ROWS, Row
from plumbline.fit.outcome import finish
from plumbline.fit.problem import Problem, prepare
from plumbline.fit.program.solve import solve
from plumbline.fit.single import fit_one
from plumbline.frame import Array
from plumbline.models import CENTRE, get_model
from plumbline.observations import Observations
from plumbline.result.calibration import Calibration
from plumbline.result.comparison import Candidate, Comparison
from plumbline.trust.displacement import displacement_errors, grid_px
from plumbline.trust.picked import picked_range_px
from plumbline.wording import listed, number

_GRID = 17
"""Points along a side of the photo: chosen, as for the range of the picks."""
_MOST_NAMED = 3
"""Chosen, because a sentence that names more is not read."""
_FINEST_PX = 0.001
"""Residuals below this are rounding, and no reason to prefer a model."""


_HELD, _FREED = "ptlens a, b, c", "ptlens with centre"


def compare(
    observations: Observations,
    done: Callable[[], object] | None = None,
    *,
    robust: bool = False,
) -> Comparison:
    """Fit every model to the picks of one lens and recommend one.

    All picks are used, suspicious ones included, unless it is robust; the recommended fit names
    these.

    Args:
        observations: Photos and lines of one lens.
        done: Called after each fit, for progress.
        robust: Compare on the picks that a robust fit of ptlens a, b, c (of b alone where there
            is none) believes, and make the recommended fit a robust one.

    Returns:
        The table and the recommendation.

    Raises:
        OptionError: the observations are of several lenses, or contradict themselves.
        DegenerateLinesError: no model can be fitted.

    Example:
        >>> import plumbline
        >>> obs = plumbline.read("building.pto")  # doctest: +SKIP
        >>> plumbline.compare(obs).reason  # doctest: +SKIP
        'b alone is not enough: …'
    """
    _prepared(observations, ROWS[0])  # what no model can be fitted to is refused at once
    picks = _believed(observations) if robust else observations

    def fitted(row: Row) -> Candidate:
        calibration = _fitted(picks, row)
        if done is not None:
            done()
        return calibration

    with ThreadPoolExecutor(2) as pool:
        candidates = list(pool.map(fitted, ROWS))
    usable = [each.calibration for each in candidates if each.aicc is not None]
    if not usable or usable[0] is None:
        raise _refusal(candidates[0].failure, _robust(picks))
    points_px = _range_px(usable[0])
    choice = choose(determined(candidates, points_px), points_px)
    table = list(choice.candidates)
    taken = table[choice.recommended]
    # The same fit again, now with its suspicious picks.
    named = fit_one(observations, taken.model, free=taken.free, robust=robust)
    table[choice.recommended] = replace(taken, calibration=named)
    return Comparison(
        candidates=tuple(map(_quoting, table)),
        best=choice.best,
        recommended=choice.recommended,
        reason=reason(choice),
        quote=quote(named),
        beyond=beyond(choice, points_px, grid_px(usable[0].lens, _GRID)),
        centre=_centre(choice.candidates),
    )


def _quoting(candidate: Candidate) -> Candidate:
    """The row with the one error to quote, that of its fit."""
    quoted = None if candidate.calibration is None else candidate.calibration.quoted
    if quoted is None or candidate.aicc is None:
        return replace(candidate, overall_error_px=None)
    return replace(candidate, overall_error_px=quoted.worst_px)


def _believed(observations: Observations) -> Observations:
    """The picks that a robust fit believes, for a comparison that wrong ones do not decide.

    Raises:
        DegenerateLinesError: there is no robust fit.
    """
    found = _robust(observations)
    if isinstance(found, PlumblineError):
        raise _refusal(found.message, found)
    return found.kept_observations


def _robust(observations: Observations) -> Calibration | PlumblineError:
    """The robust fit of the richest model that has one, or why even b alone has none."""
    try:
        return fit_one(observations, "ptlens", free=("a", "b", "c"), robust=True)
    except PlumblineError:
        pass
    try:
        return fit_one(observations, "ptlens", free=("b",), robust=True)
    except PlumblineError as error:
        return error


def _refusal(failure: str, found: Calibration | PlumblineError) -> DegenerateLinesError:
    """Why no model can be fitted, and which picks a robust fit finds wrong."""
    suspects = () if isinstance(found, PlumblineError) else found.suspects
    worst_first = sorted(suspects, key=lambda each: -each.residual_px)
    wrong = [each.sentence for each in worst_first if each.left_out]
    if not wrong:
        return DegenerateLinesError(
            f"no model can be fitted: {failure}",
            hint="check that every pick is on its line; else pick more lines, longer ones and "
            "nearer to the edges of the photo",
        )
    return DegenerateLinesError(
        f"no model can be fitted: {failure}; suspicious: {listed(wrong, _MOST_NAMED)}",
        hint="correct these picks, or leave them out with --robust",
    )


def _range_px(calibration: Calibration) -> Array:
    """Points within the range of the picks, shape (n, 2)."""
    return picked_range_px(calibration.lens, calibration.observations)


def _prepared(observations: Observations, row: Row) -> Problem:
    return prepare(observations, get_model(row.model), row.free, (), None, "image")


def _fitted(observations: Observations, row: Row) -> Candidate:
    candidate = Candidate(row.name, row.equals, row.model, row.free, None)
    try:
        problem = _prepared(observations, row)
        calibration = finish(problem, solve(problem.model, problem.task))
    except PlumblineError as error:
        return replace(candidate, failure=error.message)
    candidate = replace(
        candidate, calibration=calibration, fold_px=calibration.lens.fold_radius_px()
    )
    if not calibration.converged:
        return replace(candidate, failure=calibration.reason)
    error_px = _error_px(calibration)
    if error_px is None:
        return replace(candidate, failure="it folds within the range of the picks")
    return replace(
        candidate,
        aicc=_criterion(calibration),
        left_out_px=left_out_px(calibration),
        error_px=error_px,
    )


def _criterion(calibration: Calibration) -> float:
    """AICc of the residual contrasts that are left once the line parameters are eliminated."""
    k = len(calibration.free) + 1
    n = calibration.dof + len(calibration.free)
    square = max(float(np.sum(np.concatenate(calibration.residuals_px) ** 2)), n * _FINEST_PX**2)
    correction = 2 * k * (k + 1) / (n - k - 1) if n > k + 1 else np.inf
    return n * float(np.log(square / n)) + 2 * k + correction


def _error_px(calibration: Calibration) -> float | None:
    """The largest standard error within the range of the picks; None if the model folds there."""
    points_px = _range_px(calibration)
    covariances = [calibration.covariance]
    if calibration.jackknife is not None:
        covariances.append(calibration.jackknife.covariance)
    stated = [
        displacement_errors(
            calibration.lens, calibration.free, covariance, points_px, gauge_px=points_px
        )
        for covariance in covariances
    ]
    known = [float(np.max(errors_px)) for errors_px in stated if errors_px is not None]
    return max(known) if known else None


def left_out_px(calibration: Calibration) -> float | None:
    """Root mean square residual of lines that took no part in the fit."""
    linear = calibration.linearised
    shifts = linear.without_each_line()
    if shifts is None:
        return None
    values = linear.left_out_px(shifts)[linear.kept]
    return float(np.sqrt(np.mean(values**2)))


def _centre(candidates: tuple[Candidate, ...]) -> str:
    """What freeing the distortion centre does."""
    by_name = {each.name: each for each in candidates}
    freed, held = by_name[_FREED], by_name[_HELD]
    calibration = freed.calibration
    if calibration is None or freed.failure or held.failure:
        why = freed.failure or f"with it held, {held.failure}"
        return f"what a free distortion centre would do is not known: {why}"
    values, errors = calibration.coefficients, calibration.standard_errors
    where = " and ".join(
        f"{name} = {number(values[name], '+.1f')} ± {errors[name]:.1f} px" for name in CENTRE
    )
    straight = left_out(freed, held)
    return f"the distortion centre of {_HELD}, if freed, lies at {where}" + (
        f"{straight} with it held" if straight else ""
    )

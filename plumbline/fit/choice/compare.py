"""Fit all models to the same picks: which is enough?

Every model is fitted to the same picks; what counts is how straight it leaves lines that did not
take part in its fit, and by how many pixels of the corrected photo its curve differs from the
others'. `plumbline.fit.choice.recommend` chooses among them.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from plumbline.errors import DegenerateLinesError, PlumblineError
from plumbline.fit.choice.reasons import beyond, left_out, quote, reason
from plumbline.fit.choice.recommend import choose
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
from plumbline.trust.linearised import in_frame
from plumbline.wording import listed

_GRID = 17
_MOST_NAMED = 3
_FINEST_PX = 0.001
"""Residuals below this are rounding, and no reason to prefer a model."""


@dataclass(frozen=True)
class _Row:
    name: str
    model: str
    free: tuple[str, ...]

    @property
    def equals(self) -> tuple[str, ...]:
        """The same in other words."""
        others = get_model(self.model).in_other_words(self.free)
        return (f"{self.model} {', '.join(self.free)}",) if self.name in others else others


ROWS = (
    _Row("ptlens b", "ptlens", ("b",)),
    _Row("radial:2", "brown", ("k1",)),
    _Row("division l1", "division", ("l1",)),
    _Row("poly5", "poly5", ("k1", "k2")),
    _Row("radial:2,4", "brown", ("k1", "k2")),
    _Row("division l1, l2", "division", ("l1", "l2")),
    _Row("ptlens a, b, c", "ptlens", ("a", "b", "c")),
    _Row("radial:2,4,6", "brown", ("k1", "k2", "k3")),
    _Row("ptlens b with centre", "ptlens", ("b", *CENTRE)),
    _Row("ptlens with centre", "ptlens", ("a", "b", "c", *CENTRE)),
    _Row("radial:2,4,6 with centre", "brown", ("k1", "k2", "k3", *CENTRE)),
    _Row("brown", "brown", ("k1", "k2", "k3", "p1", "p2")),
    _Row("brown with centre", "brown", ("k1", "k2", "k3", "p1", "p2", *CENTRE)),
)
"""What is compared, simple models first. Models that are the same in other words are one row."""

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

    def fitted(row: _Row) -> Candidate:
        made = _fitted(picks, row)
        if done is not None:
            done()
        return made

    with ThreadPoolExecutor(2) as pool:
        candidates = list(pool.map(fitted, ROWS))
    usable = [each.calibration for each in candidates if each.aicc is not None]
    if not usable or usable[0] is None:
        raise _refusal(candidates[0].failure, _robust(picks))
    points_px = picked_range_px(usable[0])
    choice = choose(candidates, points_px)
    table = list(choice.candidates)
    taken = table[choice.recommended]
    # The same fit again, now with its suspicious picks.
    named = fit_one(observations, taken.model, free=taken.free, robust=robust)
    table[choice.recommended] = replace(taken, calibration=named)
    return Comparison(
        candidates=tuple(table),
        best=choice.best,
        recommended=choice.recommended,
        reason=reason(choice),
        quote=quote(choice),
        beyond=beyond(choice, points_px, grid_px(usable[0].lens, _GRID)),
        centre=_centre(choice.candidates),
    )


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
        hint="mend these picks, or leave them out with --robust",
    )


def picked_range_px(made: Calibration) -> Array:
    """Points all over the photo, as far out as picks reach, shape (n, 2)."""
    frame = made.lens.frame
    grid = frame.normalise(grid_px(made.lens, _GRID))
    picks = frame.normalise(np.concatenate(in_frame(made.observations, frame)))
    reached = float(np.max(np.hypot(*picks.T)))
    # Where no pick comes near the photo's edges the grid is laid over what they reach.
    grid *= np.minimum(1.0, reached / np.max(grid, axis=0))
    return frame.to_pixels(grid[np.hypot(*grid.T) <= reached])


def _prepared(observations: Observations, row: _Row) -> Problem:
    return prepare(observations, get_model(row.model), row.free, (), None, "image")


def _fitted(observations: Observations, row: _Row) -> Candidate:
    candidate = Candidate(row.name, row.equals, row.model, row.free, None)
    try:
        problem = _prepared(observations, row)
        made = finish(problem, solve(problem.model, problem.task))
    except PlumblineError as error:
        return replace(candidate, failure=error.message)
    candidate = replace(candidate, calibration=made, fold_px=made.lens.fold_radius_px())
    if not made.converged:
        return replace(candidate, failure=made.reason)
    error_px = _error_px(made)
    if error_px is None:
        return replace(candidate, failure="it folds within the range of the picks")
    return replace(
        candidate, aicc=_criterion(made), left_out_px=left_out_px(made), error_px=error_px
    )


def _criterion(made: Calibration) -> float:
    """AICc of the residual contrasts that are left once the line parameters are eliminated."""
    k = len(made.free) + 1
    n = made.dof + len(made.free)
    square = max(float(np.sum(np.concatenate(made.residuals_px) ** 2)), n * _FINEST_PX**2)
    correction = 2 * k * (k + 1) / (n - k - 1) if n > k + 1 else np.inf
    return n * float(np.log(square / n)) + 2 * k + correction


def _error_px(made: Calibration) -> float | None:
    """The largest standard error within the range of the picks; None if the model folds there."""
    points_px = picked_range_px(made)
    covariances = [made.covariance]
    if made.jackknife is not None:
        covariances.append(made.jackknife.covariance)
    stated = [
        displacement_errors(made.lens, made.free, covariance, points_px, gauge_px=points_px)
        for covariance in covariances
    ]
    known = [float(np.max(errors_px)) for errors_px in stated if errors_px is not None]
    return max(known) if known else None


def left_out_px(made: Calibration) -> float | None:
    """Root mean square residual of lines that took no part in the fit."""
    linear = made.linearised
    shifts = linear.without_each_line()
    if shifts is None:
        return None
    values = linear.left_out_px(shifts)[linear.kept]
    return float(np.sqrt(np.mean(values**2)))


def _centre(candidates: tuple[Candidate, ...]) -> str:
    """What freeing the distortion centre does."""
    by_name = {each.name: each for each in candidates}
    freed, held = by_name[_FREED], by_name[_HELD]
    made = freed.calibration
    if made is None or freed.failure or held.failure:
        why = freed.failure or f"with it held, {held.failure}"
        return f"what a free distortion centre would do is not known: {why}"
    where = " and ".join(
        f"{name} = {made.coefficients[name]:+.1f} ± {made.standard_errors[name]:.1f} px"
        for name in CENTRE
    )
    straight = left_out(freed, held)
    return f"the distortion centre of {_HELD}, if freed, lies at {where}" + (
        f"{straight} with it held" if straight else ""
    )

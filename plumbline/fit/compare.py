"""Which model is enough for these picks?

Every model is fitted to the same picks; what counts is how straight it leaves lines that did not
take part in its fit, and by how many pixels of the corrected photo its curve differs from the
others'. A simpler model is taken where the difference does not matter.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from plumbline.calibration import Calibration
from plumbline.comparison import Candidate, Comparison
from plumbline.displacement import difference_px, displacement_errors, grid_px
from plumbline.errors import DegenerateLinesError, PlumblineError
from plumbline.fit.calibrate import calibrate
from plumbline.frame import Array
from plumbline.linearised import in_frame
from plumbline.models import CENTRE
from plumbline.observations import Observations
from plumbline.wording import px

_MATTERS_PX = 0.1
_WORSE_AICC = 4.0
_CENTRE_AICC = 6.0
_GRID = 17


@dataclass(frozen=True)
class _Row:
    name: str
    equals: tuple[str, ...]
    model: str
    free: tuple[str, ...]


ROWS = (
    _Row("ptlens b", ("poly3",), "ptlens", ("b",)),
    _Row("radial:2", ("brown k1",), "brown", ("k1",)),
    _Row("division l1", (), "division", ("l1",)),
    _Row("poly5", ("opencv k1, k2",), "poly5", ("k1", "k2")),
    _Row("radial:2,4", ("brown k1, k2",), "brown", ("k1", "k2")),
    _Row("division l1, l2", (), "division", ("l1", "l2")),
    _Row("ptlens a, b, c", (), "ptlens", ("a", "b", "c")),
    _Row("radial:2,4,6", ("brown k1, k2, k3",), "brown", ("k1", "k2", "k3")),
    _Row("ptlens with centre", (), "ptlens", ("a", "b", "c", *CENTRE)),
    _Row("radial:2,4,6 with centre", (), "brown", ("k1", "k2", "k3", *CENTRE)),
    _Row("brown", (), "brown", ("k1", "k2", "k3", "p1", "p2")),
    _Row("brown with centre", (), "brown", ("k1", "k2", "k3", "p1", "p2", *CENTRE)),
)
"""What is compared, simple models first. Models that are the same in other words are one row."""

_DEFAULT = "ptlens a, b, c"


def compare(observations: Observations, done: Callable[[], object] | None = None) -> Comparison:
    """Fit every model to the picks of one lens and recommend one.

    Args:
        observations: Photos and lines of one lens.
        done: Called after each fit, for progress.

    Returns:
        The table and the recommendation.

    Raises:
        DegenerateLinesError: no model can be fitted; the sentence is that of the last.

    Example:
        >>> import plumbline
        >>> obs = plumbline.read("building.pto")  # doctest: +SKIP
        >>> plumbline.compare(obs).reason  # doctest: +SKIP
        'b alone is not enough: …'
    """

    def fitted(row: _Row) -> Candidate:
        made = _fitted(observations, row)
        if done is not None:
            done()
        return made

    with ThreadPoolExecutor(2) as pool:
        candidates = list(pool.map(fitted, ROWS))
    usable = [i for i, each in enumerate(candidates) if each.aicc is not None]
    if not usable:
        raise DegenerateLinesError(
            f"no model can be fitted: {candidates[0].failure}",
            hint="pick more lines, longer ones and nearer to the edges of the photo",
        )
    points_px = picked_range_px(_made(candidates[usable[0]]))
    best = _best(candidates, usable)
    candidates = [
        replace(each, difference_px=_difference(each, candidates[best], points_px))
        if each.calibration
        else each
        for each in candidates
    ]
    chosen = _simplest(candidates, usable, best, points_px)
    return Comparison(
        tuple(candidates),
        best,
        chosen,
        _reason(candidates, best, chosen),
        _centre(candidates),
    )


def picked_range_px(made: Calibration) -> Array:
    """Points all over the photo, as far out as picks reach, shape (n, 2)."""
    lens = made.lens
    grid = grid_px(lens, _GRID)
    picks = np.concatenate(in_frame(made.observations, lens.frame))
    reached = float(np.max(np.hypot(*lens.frame.normalise(picks).T)))
    return grid[np.hypot(*lens.frame.normalise(grid).T) <= reached]


def _fitted(observations: Observations, row: _Row) -> Candidate:
    candidate = Candidate(row.name, row.equals, row.model, row.free, None)
    try:
        made = calibrate(observations, row.model, free=row.free)
    except PlumblineError as error:
        return replace(candidate, failure=error.message)
    fold_px = made.lens.fold_radius_px()
    candidate = replace(candidate, calibration=made, fold_px=fold_px)
    if not made.converged:
        return replace(candidate, failure=made.reason)
    if not np.all(np.isfinite(made.lens.undistort_or_nan(picked_range_px(made)))):
        return replace(candidate, failure="the model folds within the range of the picks")
    return replace(candidate, aicc=_criterion(made), left_out_px=left_out_px(made))


def _criterion(made: Calibration) -> float:
    """AICc of the residual contrasts that are left once the line parameters are eliminated."""
    k = len(made.free) + 1
    n = made.dof + len(made.free)
    square = max(float(np.sum(np.concatenate(made.residuals_px) ** 2)), 1e-12)
    correction = 2 * k * (k + 1) / (n - k - 1) if n > k + 1 else np.inf
    return n * float(np.log(square / n)) + 2 * k + correction


def left_out_px(made: Calibration) -> float | None:
    """Root mean square residual of lines that took no part in the fit."""
    linear = made.linearised
    shifts = linear.without_each_line()
    if shifts is None:
        return None
    values = linear.left_out_px(shifts)[linear.kept]
    return float(np.sqrt(np.mean(values**2)))


def _made(candidate: Candidate) -> Calibration:
    if candidate.calibration is None:
        raise ValueError(f"{candidate.name} was not fitted: {candidate.failure}")
    return candidate.calibration


def _aicc(candidate: Candidate) -> float:
    return np.inf if candidate.aicc is None else candidate.aicc


def _difference(one: Candidate, other: Candidate, points_px: Array) -> float:
    here, there = _made(one), _made(other)
    tangential = {*here.lens.model.tangential, *there.lens.model.tangential}
    perspective = bool(tangential & {*one.free, *other.free})
    return difference_px(here.lens, there.lens, points_px, perspective=perspective)


def _best(candidates: list[Candidate], usable: Sequence[int]) -> int:
    """The row with the lowest AICc; one with a free centre only where lines left out gain by it."""
    best = min(usable, key=lambda index: _aicc(candidates[index]))

    def decentred(index: int) -> bool:
        return bool({*CENTRE, "p1", "p2"} & {*candidates[index].free})

    plain = [index for index in usable if not decentred(index)]
    if not decentred(best) or not plain:
        return best
    other = min(plain, key=lambda index: _aicc(candidates[index]))
    mine, theirs = candidates[best].left_out_px, candidates[other].left_out_px
    gains = mine is not None and theirs is not None and mine < theirs
    clearly = _aicc(candidates[best]) < _aicc(candidates[other]) - _CENTRE_AICC
    return best if gains and clearly else other


def _simplest(
    candidates: list[Candidate], usable: Sequence[int], best: int, points_px: Array
) -> int:
    """The row with the fewest coefficients whose difference from the best does not matter."""
    for index in sorted(usable, key=lambda i: (len(candidates[i].free), _aicc(candidates[i]))):
        if len(candidates[index].free) >= len(candidates[best].free):
            break
        made = _made(candidates[index])
        errors_px = displacement_errors(
            made.lens, made.free, made.covariance, points_px, gauge_px=points_px
        )
        own_px = 0.0 if errors_px is None else float(np.max(errors_px))
        matters = _difference(candidates[index], candidates[best], points_px) > max(
            _MATTERS_PX, own_px
        )
        if not matters and _aicc(candidates[index]) <= _aicc(candidates[best]) + _WORSE_AICC:
            return index
    return best


def _reason(candidates: list[Candidate], best: int, chosen: int) -> str:
    """Why that row, and whether b alone is enough."""
    alone, taken = candidates[0], candidates[chosen]
    parts: list[str] = []
    if chosen == 0:
        parts.append("b alone is enough")
    elif alone.calibration is None or alone.difference_px is None:
        parts.append(f"b alone cannot be fitted ({alone.failure})")
    else:
        parts.append(
            f"b alone is not enough: its curve is {px(alone.difference_px)} off that of "
            f"{candidates[best].name} within the range of the picks" + _left_out(alone, taken)
        )
    if chosen == best:
        parts.append(f"{taken.name} fits best for its number of coefficients")
    else:
        parts.append(
            f"{taken.name} differs from {candidates[best].name}, which fits best, by no more than "
            f"{px(taken.difference_px or 0.0)}, and is simpler"
        )
    return "; ".join(parts)


def _left_out(one: Candidate, other: Candidate) -> str:
    if one.left_out_px is None or other.left_out_px is None:
        return ""
    return (
        f", and lines left out of the fit are straight to {px(one.left_out_px)} against "
        f"{px(other.left_out_px)}"
    )


def _centre(candidates: list[Candidate]) -> str:
    """What freeing the distortion centre does."""
    by_name = {each.name: each for each in candidates}
    free, held = by_name["ptlens with centre"], by_name[_DEFAULT]
    if free.calibration is None or held.calibration is None:
        return f"the distortion centre cannot be freed: {free.failure or held.failure}"
    made = free.calibration
    where = " and ".join(
        f"{name} = {made.coefficients[name]:+.1f} ± {made.standard_errors[name]:.1f} px"
        for name in CENTRE
    )
    return f"the distortion centre, if freed, lies at {where}{_left_out(free, held)} with it held"

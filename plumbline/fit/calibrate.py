"""Calibrate a lens from straight lines: the entry point of the fit."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import NamedTuple

from plumbline.errors import DegenerateLinesError, OptionError, PlumblineError
from plumbline.fit.choice.compare import compare
from plumbline.fit.options import as_names
from plumbline.fit.problem import Start
from plumbline.fit.single import fit_one
from plumbline.observations import Observations
from plumbline.result.calibration import Calibration
from plumbline.trust.assessment import ResidualKind
from plumbline.trust.suspect import Suspect
from plumbline.trust.verdicts import suspects_check

AUTO = "auto"
"""Stands for the model that the comparison recommends."""


def calibrate(
    observations: Observations,
    model: str = "ptlens",
    *,
    free: Iterable[str] | None = None,
    hold: Iterable[str] = (),
    start: Start = None,
    residual: ResidualKind = "image",
    robust: bool = False,
    done: Callable[[], object] | None = None,
) -> Calibration:
    """Find the distortion that makes every picked line straight.

    Args:
        observations: Photos of one lens and the lines picked in them.
        model: Name of the distortion model, see `plumbline.MODELS`; "auto" for the one that
            `plumbline.compare` recommends, which chooses what is free as well.
        free: Coefficients to fit; None for what the project asks for, else all of the model's.
            `d` and `e`, the distortion centre in pixels, may be among them.
        hold: Coefficients to hold nevertheless.
        start: Start vector by name; coefficients it leaves out start at 0. None starts from
            nothing, in stages that avoid wrong minima; "file" takes the project's values. Held
            coefficients stay at their start value; `d` and `e` at the project's.
        residual: "image" minimises distances in the photograph's own pixels, where picking
            errors live; "corrected" those in the corrected photo, as Hugin does.
        robust: Leave suspicious picks out. A plain fit uses all, and names these in `suspects`.
        done: Called after each fit of the comparison where the model is "auto", for progress.

    Returns:
        The calibration. One that did not end in a minimum says so in `converged`. Its `lens` is
        for photos of the first photo's size and orientation.

    Raises:
        OptionError: an argument is unknown or contradicts the observations.
        DegenerateLinesError: the lines cannot determine the free coefficients; its `suspects` are
            the picks that a robust fit, if there is one, finds wrong.
        CollapsedFitError: they would, but only by a nonsensical lens.

    Example:
        >>> import plumbline
        >>> obs = plumbline.read("building.pto")  # doctest: +SKIP
        >>> plumbline.calibrate(obs).coefficients  # doctest: +SKIP
        {'a': 0.032, 'b': -0.098, 'c': 0.042, 'd': 0.0, 'e': 0.0}
    """
    chosen = None if free is None else as_names(free, "free")
    how = _How(model, chosen, as_names(hold, "hold"), start, residual)
    if model == AUTO:
        return _recommended(observations, how, done, robust=robust)
    return _fitted(observations, how, robust=robust)


class _How(NamedTuple):
    """How a lens is to be fitted, see `calibrate`."""

    model: str
    free: tuple[str, ...] | None
    hold: tuple[str, ...]
    start: Start
    residual: ResidualKind


def _recommended(
    observations: Observations, how: _How, done: Callable[[], object] | None, *, robust: bool
) -> Calibration:
    """The fit of the model that `compare` recommends."""
    if how.free is not None or how.hold or how.start is not None:
        raise OptionError(
            "model auto chooses its coefficients itself",
            hint="leave out free, hold and start, or name the model",
        )
    comparison = compare(observations, done, robust=robust)
    chosen = comparison.candidates[comparison.recommended]
    calibration = _fitted(
        observations, how._replace(model=chosen.model, free=chosen.free), robust=robust
    )
    notes = (
        f"{chosen.name} was chosen: {comparison.reason}",
        comparison.quote,
        comparison.beyond,
    )
    return replace(calibration, remarks=(*calibration.remarks, *filter(None, notes)))


def _fitted(observations: Observations, how: _How, *, robust: bool) -> Calibration:
    """The fit; where it is refused, a robust one may know which picks are wrong."""
    try:
        return fit_one(observations, **how._asdict(), robust=robust)
    except DegenerateLinesError as error:
        if not robust:
            error.suspects = _suspects_beside(observations, how)
        if error.suspects:
            finding = suspects_check(error.suspects, observations.n_points, robust=False).finding
            error.hint = f"{finding}: --robust fits the others"
        raise


def _suspects_beside(observations: Observations, how: _How) -> tuple[Suspect, ...]:
    """What a robust fit finds wrong where the plain one is refused."""
    try:
        calibration = fit_one(observations, **how._asdict(), robust=True)
    except PlumblineError:
        return ()
    return calibration.suspects if calibration.converged else ()

"""Check the picks of one lens, whether they can be fitted or not."""

from __future__ import annotations

from collections.abc import Iterable

from plumbline.errors import DegenerateLinesError, PlumblineError
from plumbline.fit.calibrate import calibrate
from plumbline.fit.options import as_names, fit_plan
from plumbline.fit.problem import only_lens
from plumbline.models import get_model
from plumbline.observations import Observations
from plumbline.result.checked import Checked
from plumbline.trust.check import Check
from plumbline.trust.placement import before_fit
from plumbline.trust.verdicts import after_fit, suspects_check


def check(
    observations: Observations,
    model: str = "ptlens",
    *,
    free: Iterable[str] | None = None,
    hold: Iterable[str] = (),
) -> Checked:
    """Say whether the picks can tell the distortion, and what to pick next.

    Args:
        observations: Photos of one lens and the lines picked in them.
        model: Name of the distortion model, see `plumbline.MODELS`.
        free: As for `calibrate`.
        hold: As for `calibrate`.

    Returns:
        The checks before the fit and, where it succeeds, those of the fit. Where it is refused,
        the result holds the error instead of raising it, and the picks that a robust fit, if
        there is one, finds wrong.

    Raises:
        OptionError: a coefficient or the model is unknown, or the photo is not rectilinear.

    Example:
        >>> import plumbline
        >>> obs = plumbline.read("building.pto")  # doctest: +SKIP
        >>> plumbline.check(obs).passed  # doctest: +SKIP
        True
    """
    chosen, held = None if free is None else as_names(free, "free"), as_names(hold, "hold")
    radial = get_model(model).radial
    fitted = fit_plan(get_model(model), only_lens(observations), chosen, held, None).free
    before = before_fit(observations, len(fitted), sum(name in radial for name in fitted))
    try:
        calibration = calibrate(observations, model, free=chosen, hold=held)
    except PlumblineError as error:
        return _refused(before, error, observations.n_points)
    return Checked((*before, *after_fit(calibration.trust)), calibration.suspects, calibration)


def _refused(before: tuple[Check, ...], error: PlumblineError, n_points: int) -> Checked:
    """What is known of picks that were not fitted."""
    if not isinstance(error, DegenerateLinesError) or not error.suspects:
        return Checked(before, error=error)
    error.hint = "look at the suspicious picks; plumbline fit --robust leaves them out"
    suspicious = suspects_check(error.suspects, n_points, robust=False)
    return Checked((*before, suspicious), error.suspects, error=error)

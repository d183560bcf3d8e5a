"""Whether a result hangs together: what follows from its lens and picks is computed again."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import msgspec
import numpy as np

from plumbline._version import __version__
from plumbline.frame import Array
from plumbline.result.calibration import Calibration
from plumbline.result.pair import PairCalibration, corrected_px
from plumbline.result.schema import ResultRecord
from plumbline.result.writing import record_of
from plumbline.trust.covariance import covariance_of, sigma_of
from plumbline.trust.linearised import Linearised
from plumbline.trust.matched import UNSEEN, derivatives

_ROUNDING = 1e-6
"""Chosen, because figures are written exactly: two computers round apart by far less, and nobody
quotes a millionth of a pixel."""

_ROUNDING_OF_ERRORS = 1e-4
"""The same for what is solved from nearly equal numbers, which magnify rounding."""

_STRETCH, _STRETCH_OF_RESIDUALS = 0.02, 30.0
"""How far a covariance may be from σ̂² (JᵀJ)⁻¹, as a share of its standard errors, and what is
added for σ̂ over half the shorter side. The fit's derivative of a residual holds that of the local
stretch, which grows with the residual; here it does not. Over the sample projects with seven
models they were apart by 0.0001 to 0.017, at most 10 times that quotient."""

_FIXED = (
    *("standard_errors", "intervals", "rms_before_px", "rms_after_px"),
    *("largest_before_px", "largest_after_px", "finding", "lines"),
)
"""Figures whose definition stays."""

_OF_THIS_VERSION = ("displacement", "quoted", "jackknife", "model_error")
"""Figures that a later version may compute better: they are compared within one version."""

_PLACES = ("quote_at_px", "at_px", "quoted", "names", "label")
"""Where two figures are all but equal, rounding decides these."""


def contradiction(calibration: Calibration, record: ResultRecord) -> str:
    """What does not go together in a result that was read, or nothing.

    Args:
        calibration: The result.
        record: What its file says.
    """
    return _of_the_fit(calibration) or _of_what_follows(calibration, record)


def _of_the_fit(calibration: Calibration) -> str:
    """Lens, picks, residuals, σ̂ and covariance against one another."""
    if isinstance(calibration, PairCalibration):
        return _of_the_matches(calibration)
    kept, linear = np.concatenate(calibration.kept), calibration.linearised
    centre = float(calibration.lens.model.factor(np.float64(0.0), calibration.lens.vector))
    if not centre > 0 or not np.array_equal(linear.kept, kept):
        return "the lens does not go with the picks"
    used = sum(bool(which.any()) for which in calibration.kept)
    if calibration.dof != int(np.count_nonzero(kept)) - 2 * used - len(calibration.free):
        return "the degrees of freedom are not those of the picks"
    if not _near(np.concatenate(calibration.residuals_px), linear.residual_px):
        return "the lens does not leave the picks the residuals that are stored"
    weighed = calibration.trust.weighed
    corrected_px = linear.image_px[kept] * linear.stretch[kept]
    holds = {
        "σ̂ is not that of the residuals": _near(
            calibration.sigma_px, sigma_of(weighed, calibration.dof)
        ),
        "the error in the corrected photo is not that of the residuals": _near(
            calibration.rms_corrected_px, np.sqrt(np.mean(corrected_px**2))
        ),
        "the covariance is not that of the picks": _covariance_follows(calibration, weighed),
    }
    return next((sentence for sentence, true in holds.items() if not true), "")


def _of_the_matches(calibration: PairCalibration) -> str:
    """The same for a pair."""
    kept, stored = np.concatenate(calibration.kept), np.concatenate(calibration.residuals_px)
    distance_px = np.nan_to_num(np.linalg.norm(calibration.vectors_px, axis=1), nan=np.inf)
    if not _near(stored, distance_px):
        return "the lens does not leave the matches the residuals that are stored"
    if calibration.dof != 2 * int(np.count_nonzero(kept)) - len(calibration.free) - UNSEEN:
        return "the degrees of freedom are not those of the matches"
    if not _near(calibration.sigma_px, np.sqrt(np.sum(distance_px[kept] ** 2) / calibration.dof)):
        return "σ̂ is not that of the residuals"
    slopes = derivatives(
        calibration.setting, calibration.free, corrected_px(calibration.observations)[kept]
    )
    whole = calibration.sigma_px**2 * np.linalg.inv(np.einsum("nik,nil->kl", slopes, slopes))
    computed = whole[: len(calibration.free), : len(calibration.free)]
    errors = np.sqrt(np.diag(computed))
    if np.any(np.abs(calibration.covariance - computed) > _STRETCH * np.outer(errors, errors)):
        return "the covariance is not that of the matches"
    return ""


def _covariance_follows(calibration: Calibration, linear: Linearised) -> bool:
    if not calibration.free:
        return True
    computed, sigma_px = covariance_of(linear, calibration.dof)
    errors = np.sqrt(np.diag(computed))
    share = _STRETCH + _STRETCH_OF_RESIDUALS * sigma_px / calibration.lens.frame.radius_px
    allowed = share * np.outer(errors, errors)
    return bool(np.all(np.abs(calibration.covariance - computed) <= allowed + np.finfo(float).tiny))


def _of_what_follows(calibration: Calibration, record: ResultRecord) -> str:
    """The first figure that does not follow from the fit."""
    again = record_of(calibration)
    names = dict.fromkeys(_FIXED, _ROUNDING)
    if record.plumbline == __version__:
        names |= dict.fromkeys(_OF_THIS_VERSION, _ROUNDING_OF_ERRORS)
    for name, rounding in names.items():
        stored, follows = (msgspec.to_builtins(getattr(each, name)) for each in (record, again))
        if stored is not None and (apart := next(_apart(stored, follows, name, rounding), "")):
            return apart
    lines = zip(record.observations.lines, again.observations.lines, strict=True)
    for number, (line, same) in enumerate(lines):
        if line.before_px is not None and not _near(line.before_px, same.before_px or ()):
            return f"observations.lines[{number}].before_px is not that of its points"
    return ""


def _apart(stored: Any, follows: Any, place: str, rounding: float) -> Iterator[str]:
    """Places where what is stored is not what follows."""
    if isinstance(stored, Mapping) and isinstance(follows, Mapping):
        if set(stored) != set(follows):
            yield f"{place} has other names than follow from the fit"
        for name in set(stored) - set(_PLACES):
            yield from _apart(stored[name], follows.get(name), f"{place}.{name}", rounding)
    elif isinstance(stored, list | tuple) and isinstance(follows, list | tuple):
        if len(stored) != len(follows):
            yield f"{place} has {len(stored)} entries where {len(follows)} follow from the fit"
        for number, (one, other) in enumerate(zip(stored, follows, strict=False)):
            yield from _apart(one, other, f"{place}[{number}]", rounding)
    elif isinstance(stored, float) and isinstance(follows, float):
        if not np.isclose(stored, follows, rtol=rounding, atol=rounding):
            yield f"{place} is {stored:.6g} where {follows:.6g} follows from the fit"
    elif stored != follows:
        yield f"{place} does not follow from the fit"


def _near(
    stored: float | Sequence[float] | Array, follows: float | Sequence[float] | Array
) -> bool:
    return np.shape(stored) == np.shape(follows) and np.allclose(
        stored, follows, rtol=_ROUNDING, atol=_ROUNDING
    )

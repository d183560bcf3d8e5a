"""Whether a result that was read hangs together: lens, picks, residuals and σ̂ are of one fit."""

from __future__ import annotations

import numpy as np

from plumbline.calibration import Calibration
from plumbline.errors import ReadError
from plumbline.result_reading import from_json

_ROUNDING = 1e-6


def consistent_results(text: str, path: str) -> tuple[Calibration, ...]:
    """Read back what `to_json` wrote, and compute again what follows from lens and picks.

    Raises:
        ReadError: the text is no such JSON, or it contradicts itself.
    """
    calibrations = from_json(text, path)
    for made in calibrations:
        wrong = _contradiction(made)
        if wrong:
            raise ReadError(
                f"this result was changed since it was written: {wrong}",
                path=path,
                hint="fit again: plumbline fit POINTS -o result.json",
            )
    return calibrations


def _contradiction(made: Calibration) -> str:
    """What does not go together, or nothing."""
    kept, residuals_px = np.concatenate(made.kept), np.concatenate(made.residuals_px)
    centre = float(made.lens.model.factor(np.float64(0.0), made.lens.vector))
    if not centre > 0 or not np.array_equal(made.linearised.kept, kept):
        return "the lens does not go with the picks"
    used = sum(bool(which.any()) for which in made.kept)
    if made.dof != int(np.count_nonzero(kept)) - 2 * used - len(made.free):
        return "the degrees of freedom are not those of the picks"
    linear = made.linearised
    if not np.allclose(residuals_px, linear.residual_px, rtol=_ROUNDING, atol=_ROUNDING):
        return "the lens does not leave the picks the residuals that are stored"
    sigma_px = np.sqrt(np.sum(linear.image_px[kept] ** 2) / made.dof)
    if not np.isclose(made.sigma_px, sigma_px, rtol=_ROUNDING, atol=_ROUNDING):
        return "σ̂ is not that of the residuals"
    corrected_px = linear.image_px[kept] * linear.stretch[kept]
    rms_px = np.sqrt(np.mean(corrected_px**2))
    if not np.isclose(made.rms_corrected_px, rms_px, rtol=_ROUNDING, atol=_ROUNDING):
        return "the error in the corrected photo is not that of the residuals"
    return ""

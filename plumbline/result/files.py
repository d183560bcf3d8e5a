"""The one door to results in files: every reader of a result comes through here.

What is read must hang together: lens, picks, residuals and σ̂ are of one fit.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from plumbline.errors import ReadError
from plumbline.files import ZOOM, read_bytes
from plumbline.formats.base import Source
from plumbline.result.calibration import Calibration
from plumbline.result.pair import PairCalibration
from plumbline.result.reading import from_json
from plumbline.trust.matched import UNSEEN

_ROUNDING = 1e-6


def read_calibrations(path: str | Path) -> tuple[Calibration, ...]:
    """Read the calibrations of a JSON file that plumbline wrote, one a lens.

    Raises:
        ReadError: it is missing, damaged or another file, or was changed since it was written.
    """
    source = Source(str(path), read_bytes(path))
    head = source.head.lstrip()
    if not head.startswith("{"):
        raise source.error(
            "only plumbline's JSON holds the residuals and error bars of a fit",
            hint="write it with plumbline fit POINTS -o building.json",
        )
    if f'"{ZOOM}"' in head[:1024]:
        raise source.error(
            "this is a zoom lens, which was joined from several calibrations",
            hint="give the RESULT.json of one focal length",
        )
    return consistent_results(source.text(), source.path)


def read_calibration(path: str | Path) -> Calibration:
    """Read the one calibration of a JSON file that plumbline wrote.

    Raises:
        ReadError: as `read_calibrations`, or it holds several lenses.
    """
    found = read_calibrations(path)
    if len(found) != 1:
        raise ReadError(
            f"the file holds {len(found)} calibrations",
            path=path,
            hint="take them all with plumbline.read_calibrations",
        )
    return found[0]


def consistent_results(text: str, path: str) -> tuple[Calibration, ...]:
    """Read back what `to_json` wrote, and compute again what follows from lens and picks.

    Raises:
        ReadError: the text is no such JSON, or it contradicts itself.
    """
    calibrations = from_json(text, path)
    for made in calibrations:
        paired = isinstance(made, PairCalibration)
        wrong = _contradiction_of_matches(made) if paired else _contradiction(made)
        if wrong:
            raise ReadError(
                f"this result was changed since it was written: {wrong}",
                path=path,
                hint="fit again: plumbline fit POINTS -o result.json",
            )
    return calibrations


def _contradiction_of_matches(made: PairCalibration) -> str:
    """As `_contradiction`, for matches."""
    kept, stored = np.concatenate(made.kept), np.concatenate(made.residuals_px)
    distance = np.nan_to_num(np.linalg.norm(made.vectors_px, axis=1), nan=np.inf)
    if not np.allclose(distance, stored, rtol=_ROUNDING, atol=_ROUNDING):
        return "the lens does not leave the matches the residuals that are stored"
    if made.dof != 2 * int(kept.sum()) - len(made.free) - UNSEEN:
        return "the degrees of freedom are not those of the matches"
    sigma_px = np.sqrt(np.sum(distance[kept] ** 2) / made.dof)
    if not np.isclose(made.sigma_px, sigma_px, rtol=_ROUNDING, atol=_ROUNDING):
        return "σ̂ is not that of the residuals"
    return ""


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

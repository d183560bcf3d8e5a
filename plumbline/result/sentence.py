"""The finding of a calibration in one sentence, for every place that tells it."""

from __future__ import annotations

from plumbline.result.calibration import Calibration
from plumbline.result.pair import PairCalibration
from plumbline.trust.placement import worth_of_error_bars
from plumbline.wording import number

_KINDS = {
    "barrel": "Barrel distortion",
    "pincushion": "Pincushion distortion",
    "wavy": "Wavy (moustache) distortion",
    "none": "No distortion to speak of",
}


def finding_sentence(calibration: Calibration) -> str:
    """The finding in one line: kind and size of the distortion, straightness, and any doubt."""
    doubt = calibration.doubt
    return measured_sentence(calibration) + (f"; {doubt}" if doubt else "")


def measured_sentence(calibration: Calibration) -> str:
    """The finding without what costs more than the fit: whether the model is to be trusted."""
    finding = calibration.finding
    place = "at the corner"
    if finding.folds_at_px is not None:
        place = f"{finding.folds_at_px:.0f} px from the centre, where the polynomial folds"
    size = f": {number(finding.percent, '+.2f')} % ({number(finding.corner_px, '+.1f')} px) {place}"
    of_matches = isinstance(calibration, PairCalibration)
    strays = "matches disagree" if of_matches else "picks stray from straight lines"
    doubt = worth_of_error_bars(calibration.dof)
    return (
        f"{_KINDS[finding.kind]}{'' if finding.kind == 'none' else size}; "
        f"{strays} by {calibration.rms_before_px:.2f} px (rms) before, "
        f"{calibration.rms_after_px:.2f} px after{f'; {doubt}' if doubt else ''}"
    )

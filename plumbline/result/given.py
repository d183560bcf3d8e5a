"""Calibrations as they are given: one or several, and settled or not."""

from __future__ import annotations

from collections.abc import Sequence

from plumbline.errors import UnsettledError, refuse_other_type
from plumbline.result.calibration import Calibration


def as_calibrations(result: Calibration | Sequence[Calibration]) -> list[Calibration]:
    """One calibration or several as a list.

    Raises:
        OptionError: these are none.
    """
    several = [result] if isinstance(result, Calibration) else result
    hint = "fit one with plumbline.calibrate"
    refuse_other_type(several, Sequence, "a Calibration", hint)
    for each in several:
        refuse_other_type(each, Calibration, "a Calibration", hint)
    return list(several)


def refuse_unsettled(calibrations: Sequence[Calibration]) -> None:
    """Refuse fits that did not reach a minimum.

    Raises:
        UnsettledError: there is one; the sentence names its worst line.
    """
    for calibration in calibrations:
        if calibration.converged:
            continue
        worst = max(
            (line for line in calibration.lines if not line.left_out),
            key=lambda line: line.rms_after_px,
        )
        raise UnsettledError(
            f"{calibration.observations.named}the fit did not converge: {calibration.reason}; line "
            f"{worst.label} is farthest from straight, by {worst.rms_after_px:.3g} px (rms)",
            hint="check that every pick is on its line and that the photo's size (and --grid) is "
            "right",
        )

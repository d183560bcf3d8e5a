"""Which model is enough: the models side by side, and the one to take."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from typing import Any

from plumbline.result.calibration import Calibration


@dataclass(frozen=True, eq=False)
class Candidate:
    """One model fitted to the picks.

    Attributes:
        name: What was fitted, as in "ptlens b".
        equals: Models that are the same in other words, as in "poly3".
        model: Name of the model, for `--model`.
        free: Its free coefficients, for `--free`.
        calibration: The fit; None where there is none.
        failure: Why there is none, or why it cannot be taken; else empty.
        aicc: Akaike's information criterion for small samples (C. Hurvich and C.-L. Tsai 1989),
            for residual contrasts after the line parameters.
        left_out_px: Root mean square residual of lines that did not take part in the fit.
        difference_px: Largest difference from the best row over the range of the picks, after
            the best common scale and translation (homography with tangential terms).
        error_px: Largest standard error of its curve over the range of the picks, the larger of
            that for independent picking errors and the jackknife's.
        overall_error_px: The error to quote, that of the fit: see `Calibration.quoted`.
        fold_px: Radius at which the model folds inside the photo, or None.
    """

    name: str
    equals: tuple[str, ...]
    model: str
    free: tuple[str, ...]
    calibration: Calibration | None
    failure: str = ""
    aicc: float | None = None
    left_out_px: float | None = None
    difference_px: float | None = None
    error_px: float | None = None
    overall_error_px: float | None = None
    fold_px: float | None = None


@dataclass(frozen=True, eq=False)
class Comparison:
    """All models, and the recommended one.

    Attributes:
        candidates: One row a model, simple ones first.
        best: Index of the row that fits best for its number of coefficients (lowest AICc; a free
            centre counts only where lines left out gain by it).
        recommended: Index of the row to take.
        reason: Why.
        centre: What freeing the distortion centre would do, in a sentence.
        quote: Which error to quote with the recommended row, in a sentence, as its fit has it;
            empty where the model folds among the picks.
        beyond: How far models that the picks do not rule out part from the recommended one where
            there are no picks, in a sentence; empty where they do not part.
    """

    candidates: tuple[Candidate, ...]
    best: int
    recommended: int
    reason: str
    centre: str = ""
    quote: str = ""
    beyond: str = ""

    @property
    def notes(self) -> tuple[str, ...]:
        """What there is to say beside the reason, in sentences."""
        return tuple(filter(None, (self.quote, self.beyond, self.centre)))

    def delta_aicc(self, candidate: Candidate) -> float | None:
        """AICc above the lowest of all rows; None where a row has none that is finite."""
        if candidate.aicc is None or not isfinite(candidate.aicc):
            return None
        return candidate.aicc - min(each.aicc for each in self.candidates if each.aicc is not None)

    @property
    def calibration(self) -> Calibration:
        """The recommended fit."""
        calibration = self.candidates[self.recommended].calibration
        if calibration is None:
            raise ValueError("the recommended model was not fitted")
        return calibration


def as_dict(comparison: Comparison) -> dict[str, Any]:
    """A comparison as plain lists, dicts, strings and numbers."""
    return {
        "recommended": comparison.candidates[comparison.recommended].name,
        "best": comparison.candidates[comparison.best].name,
        "reason": comparison.reason,
        "quote": comparison.quote,
        "beyond": comparison.beyond,
        "centre": comparison.centre,
        "candidates": [_row(comparison, candidate) for candidate in comparison.candidates],
    }


def _row(comparison: Comparison, candidate: Candidate) -> dict[str, Any]:
    calibration = candidate.calibration
    return {
        "name": candidate.name,
        "equals": list(candidate.equals),
        "model": candidate.model,
        "free": list(candidate.free),
        "failure": candidate.failure,
        "coefficients": None if calibration is None else calibration.coefficients,
        "standard_errors": None if calibration is None else calibration.standard_errors,
        "rms_after_px": None if calibration is None else calibration.rms_after_px,
        "aicc": _finite(candidate.aicc),
        "delta_aicc": comparison.delta_aicc(candidate),
        "left_out_px": _finite(candidate.left_out_px),
        "difference_px": _finite(candidate.difference_px),
        "error_px": _finite(candidate.error_px),
        "overall_error_px": _finite(candidate.overall_error_px),
        "fold_px": candidate.fold_px,
    }


def _finite(value: float | None) -> float | None:
    """A number that JSON has; None for what so few picks do not tell, or a lens that folds."""
    return value if value is not None and isfinite(value) else None

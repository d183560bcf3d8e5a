"""What a report says of a calibration in one sentence, and where that sentence ends to hold."""

from __future__ import annotations

from collections.abc import Iterator

from plumbline.report.page.figures import photo_name
from plumbline.result.calibration import Calibration
from plumbline.result.comparison import Candidate, Comparison
from plumbline.wording import count, joined, px

_BEHIND = 4.0
"""ΔAICc from which a model has considerably less support than another: K. Burnham and
D. Anderson 2002, section 2.6."""


def verdict(calibration: Calibration, compared: Comparison | None) -> str:
    """Whether the calibration can be used, in one sentence."""
    failed = [check.name for check in calibration.checks if not check.passed]
    doubtful = [check.name for check in calibration.checks if check.passed and check.doubtful]
    n = count(len(calibration.checks), "check")
    if failed:
        word = "usable within the limits below"
        why = f"{len(failed)} of {n} failed ({joined(failed)})"
    elif doubtful:
        word = "usable"
        why = f"no check failed; {len(doubtful)} of {n} left a doubt ({joined(doubtful)})"
    else:
        word, why = "usable", f"all {n} passed"
    better = _better(calibration, compared)
    return f"Verdict: {word}: {_error(calibration)}; {why}{better}."


def _error(calibration: Calibration) -> str:
    sure = calibration.quoted_displacement
    if sure is None:
        return "the model folds inside the photo, and the error of the correction is not known"
    interval = px(calibration.trust.interval_factor * sure.worst_px)
    return (
        f"the correction is uncertain by at most {px(sure.worst_px)} ({sure.worst_place}; one "
        f"standard error; 95 %: ±{interval})"
    )


def _better(calibration: Calibration, compared: Comparison | None) -> str:
    """The model that fits better, if one does."""
    own = None if compared is None else _row_of(calibration, compared)
    if compared is None or own is None:
        return ""
    taken = compared.candidates[compared.recommended]
    if taken is own or own.aicc is None or taken.aicc is None or own.aicc - taken.aicc < _BEHIND:
        return ""
    return (
        f"; {taken.name} follows the picks better (AICc lower by {own.aicc - taken.aicc:.0f}): fit "
        "with --model auto"
    )


def _row_of(calibration: Calibration, compared: Comparison) -> Candidate | None:
    """The fitted model's row."""
    alike = (
        row
        for row in compared.candidates
        if (row.model, row.free) == (calibration.model, calibration.free)
    )
    return next(alike, None)


def recommends_the_fitted(calibration: Calibration, compared: Comparison) -> bool:
    """Whether the comparison recommends the model that was fitted."""
    return compared.candidates[compared.recommended] is _row_of(calibration, compared)


def limits(calibration: Calibration) -> Iterator[str]:
    """What the calibration does not cover, in sentences."""
    facts, frame = calibration.observations.lenses[0], calibration.lens.frame
    focal_mm = facts.focal_length_mm(frame)
    at = f"at {focal_mm:.4g} mm, " if focal_mm else ""
    names = joined([photo_name(photo) for photo in calibration.observations.photos])
    yield (
        f"It holds for this lens {at}focused as for {names}, and for whole photos of the same "
        "camera: zooming, focusing, stabilisation and cropping change the distortion."
    )
    yield (
        "The errors hold if edges are straight but for what leaving out lines shows, if picks of "
        "different lines err independently, and if the model can follow the lens."
    )
    yield "No method sees a pick that is displaced along its own line."
    yield (
        "Straight lines give neither the scale nor the position of the corrected photo, nor its "
        "perspective: distances cannot be measured from this calibration alone."
    )
    for check in calibration.checks:
        if check.name == "radius":
            yield f"{check.finding[:1].upper()}{check.finding[1:]}."

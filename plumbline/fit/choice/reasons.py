"""Why a model is recommended, and what its recommendation leaves open: in sentences."""

from __future__ import annotations

from math import isfinite

from plumbline.fit.choice.recommend import (
    MATTERS_PX,
    Choice,
    aicc,
    curves_apart_px,
    error_px,
    ruled_out,
)
from plumbline.frame import Array
from plumbline.result.calibration import Calibration
from plumbline.result.comparison import Candidate
from plumbline.wording import px

_MUCH = 2.0
"""How many times farther models part beyond the picks before it is told: chosen."""


def reason(choice: Choice) -> str:
    """Whether b alone is enough and why, and why that row is taken: one sentence."""
    taken = choice.candidates[choice.recommended]
    if choice.recommended == 0 and not isfinite(aicc(taken)):
        return (
            "whether b alone is enough cannot be told from so few picks; it is taken since no "
            "model has fewer coefficients"
        )
    why = _why_taken(choice)
    if choice.recommended == 0:
        return f"b alone is enough: {why}"
    return f"{_why_not_alone(choice)}; {taken.name} is recommended: {why}"


def _why_taken(choice: Choice) -> str:
    best, taken = choice.candidates[choice.best], choice.candidates[choice.recommended]
    if not isfinite(aicc(taken)):
        return "no model has fewer coefficients, and so few picks cannot tell models apart"
    if taken is best:
        if any(aicc(each) < aicc(taken) for each in choice.candidates if each.aicc is not None):
            return (
                "of the models without tangential terms or a free centre none fits better for its "
                "number of coefficients, and for these terms the evidence is too weak"
            )
        return "no model fits better for its number of coefficients"
    off_px = taken.difference_px or 0.0
    where = (
        f"within the range of the picks its curve is up to {px(off_px)} off that of {best.name}, "
        "which fits best"
    )
    if off_px <= MATTERS_PX:
        return f"{where}, which is less than {px(MATTERS_PX)} and does not matter"
    return (
        f"{where}, but no model has an error much smaller once the models that the picks do not "
        "rule out are allowed for, and none with fewer coefficients has one as small"
    )


def _why_not_alone(choice: Choice) -> str:
    alone, taken = choice.candidates[0], choice.candidates[choice.recommended]
    if alone.calibration is None:
        return f"b alone cannot be fitted: {alone.failure}"
    if alone.failure:
        return f"b alone cannot be taken: {alone.failure}"
    rival = choice.candidates[choice.against_first]
    better = "fits better" if aicc(alone) > aicc(rival) else "the picks do not rule out"
    return (
        "b alone is not enough: within the range of the picks its curve is up to "
        f"{px(choice.against_first_px)} off that of {rival.name}, which {better}"
        + left_out(alone, taken)
    )


def left_out(one: Candidate, other: Candidate) -> str:
    """How straight either leaves lines that took no part in its fit."""
    if one.left_out_px is None or other.left_out_px is None:
        return ""
    return (
        f", and lines left out of the fit stray by {px(one.left_out_px)} (rms), against "
        f"{px(other.left_out_px)}"
    )


def quote(calibration: Calibration) -> str:
    """Which error to quote with a fit; empty where its model folds among the picks."""
    return "" if calibration.quoted is None else calibration.quoted.sentence


def beyond(choice: Choice, points_px: Array, photo_px: Array) -> str:
    """How far the models part where there are no picks.

    Args:
        choice: What is recommended.
        points_px: Observed points within the range of the picks, shape (n, 2).
        photo_px: The same all over the photo.
    """
    taken, best = choice.candidates[choice.recommended], choice.candidates[choice.best]
    allowed_px = max(MATTERS_PX, 2 * error_px(taken))
    rivals = [
        each
        for each in choice.candidates
        if each is not taken
        and each.aicc is not None
        and not ruled_out(each, best)
        and curves_apart_px(taken, each, points_px) <= allowed_px
    ]
    if not rivals:
        return ""
    apart = [(curves_apart_px(taken, each, photo_px), each) for each in rivals]
    far_px, rival = max(apart, key=lambda pair: pair[0])
    if far_px <= _MUCH * max(curves_apart_px(taken, rival, points_px), MATTERS_PX):
        return ""
    remedy = "pick lines there before trusting the correction there"
    if not isfinite(far_px):
        return f"beyond the picks, {rival.name} or {taken.name} folds before the corners: {remedy}"
    return (
        f"beyond the picks, up to the corners, it differs from {rival.name}, which agrees with it "
        f"where the picks are, by up to {px(far_px)}: {remedy}"
    )

"""Which of the models the picks determine at all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from plumbline.frame import Array
from plumbline.geometry.lens import Lens
from plumbline.result.comparison import Candidate
from plumbline.trust.displacement import difference_px
from plumbline.wording import px

_LEAST_SHOWN_PX = 2.0
"""The least distortion that a row's error is held against: chosen, because a photo without any
still shows whether it has some pixels of it."""


def determined(candidates: Sequence[Candidate], points_px: Array) -> list[Candidate]:
    """The rows, those marked that the picks cannot determine.

    A curve that is uncertain by more than the distortion there is, as the simplest row sees it,
    says nothing of the lens, and as little of how far other rows are off.

    Args:
        candidates: The rows, simple ones first.
        points_px: Observed points within the range of the picks.
    """
    simplest = next(each.calibration for each in candidates if each.aicc is not None)
    if simplest is None:
        return list(candidates)
    nothing = Lens(
        simplest.lens.model,
        simplest.lens.frame,
        dict.fromkeys(simplest.coefficients, 0.0),
        simplest.lens.focal_px,
    )
    most_px = difference_px(simplest.lens, nothing, points_px, perspective=False)
    most_px = max(most_px, _LEAST_SHOWN_PX)
    return [
        replace(
            each,
            aicc=None,
            failure=f"not determined: uncertain by {px(each.error_px)}, and the distortion among "
            f"the picks is {px(most_px)}",
        )
        if each.error_px is not None
        and each.error_px > most_px
        and each.calibration is not simplest
        else each
        for each in candidates
    ]

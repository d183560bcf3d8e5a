"""The one error to quote, what it consists of, and what is not in it."""

from __future__ import annotations

from dataclasses import dataclass

from plumbline.trust.displacement import Displacement
from plumbline.trust.picked import WHOLE
from plumbline.wording import px

_ABSORBED = 0.8
"""Share of the error above which a rectification is not worth a word: chosen."""


@dataclass(frozen=True, eq=False)
class Quoted:
    """One standard error of the correction within the range of the picks.

    Attributes:
        total: Over that range, after the best common scale and translation (homography with
            tangential terms free).
        picks_px: At the worst point, what the errors of the picks make: the larger of that for
            independent errors and the jackknife's, widened for few degrees of freedom.
        missed_px: There, what the lens may do besides the fitted model.
        centre_px: There, of that what the distortion centre and tangential terms alone may do.
        curve_px: There, what further powers of r alone may do.
        rectified_px: The largest total after the best homography: what is left once the photo is
            rectified to points of a plane. None where the model folds.
        reached: How far the picks reach, as a share of the way to the corner.
    """

    total: Displacement
    picks_px: float
    missed_px: float
    centre_px: float
    curve_px: float
    rectified_px: float | None
    reached: float

    @property
    def worst_px(self) -> float:
        """The figure to quote: the largest standard error."""
        return self.total.worst_px

    @property
    def where(self) -> str:
        """The place in words."""
        return self.total.worst_place

    @property
    def sentence(self) -> str:
        """The figure with its parts."""
        told = f"quote ±{px(self.worst_px)} (one standard error, {self.where})"
        parts = [f"±{px(self.picks_px)} from the picks"]
        if px(self.worst_px) != px(self.picks_px):
            cause = self._main_cause()
            parts.append(f"±{px(self.missed_px)} from what the model may miss{cause}")
        return f"{told}: {', '.join(parts)}{self._rectified()}{self.beyond}"

    @property
    def beyond(self) -> str:
        """What cannot be said, as the end of a sentence; empty where picks reach the corners."""
        if self.reached >= WHOLE:
            return ""
        return (
            f"; beyond {100 * self.reached:.0f} % of the way to the corner, where no picks are, "
            "the error is not known"
        )

    def _main_cause(self) -> str:
        if self.centre_px >= self.curve_px:
            return f" (±{px(self.centre_px)} of it because the distortion centre is not known)"
        return f" (±{px(self.curve_px)} of it because the shape of the curve is not known)"

    def _rectified(self) -> str:
        if self.rectified_px is None or self.rectified_px > _ABSORBED * self.worst_px:
            return ""
        return f"; ±{px(self.rectified_px)} after rectifying the photo to points of a plane"

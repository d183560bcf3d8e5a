"""What the user should be told about a fit, in plain sentences."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plumbline.trust.assessment import Assessment
from plumbline.trust.check import Check
from plumbline.trust.straightness import LineStraightness
from plumbline.wording import number

_CORRELATED = 0.9
"""Chosen: the common mark of two coefficients that stand for each other."""
_OUTSTANDING = 5.0
"""Times the typical line's rms; chosen, sound lines of few picks reach three."""
_CARELESS_PX = 3.0
"""Chosen: hand picks scatter by 0.5 to 2 px."""


def notes_on(
    trust: Assessment,
    checks: Sequence[Check],
    lines: Sequence[LineStraightness],
    unsettled: str,
) -> tuple[str, ...]:
    """Notes on a finished fit, its failed checks among them.

    Args:
        trust: How far to trust the fit.
        checks: Its checks.
        lines: How straight its lines are.
        unsettled: Why it did not converge; empty where it did.
    """
    own = tuple(
        note
        for note in (
            f"{unsettled}: do not use this result" if unsettled else "",
            _folding(trust),
            _outstanding(trust, lines),
            _corrected(trust),
            _uninformative(trust),
            _correlated(trust),
        )
        if note
    )
    return (*own, *(check.sentence for check in checks if not check.passed))


def _folding(trust: Assessment) -> str:
    fold = trust.lens.fold_radius_px()
    if fold is None:
        return ""
    return (
        f"the polynomial folds over {fold:.0f} px from the centre, inside the photo: "
        "what lies farther out cannot be corrected with it"
    )


def _outstanding(trust: Assessment, lines: Sequence[LineStraightness]) -> str:
    fitted = [line for line in lines if not line.left_out]
    if not fitted:
        return ""
    typical = float(np.median([line.rms_after_px for line in fitted]))
    worst = max(fitted, key=lambda line: line.rms_after_px)
    if worst.rms_after_px > max(_OUTSTANDING * typical, 1.0):
        return (
            f"line {worst.label} is off by {worst.rms_after_px:.3g} px (rms) and the others by "
            f"{typical:.2g} px: check whether its picks lie on one straight edge"
        )
    if trust.sigma_px > _CARELESS_PX:
        return (
            f"σ̂ of {trust.sigma_px:.3g} px is more than careful picks leave: check that every pick "
            "is on its line, that the edges are straight, and that the photo's size is right"
        )
    return ""


def _uninformative(trust: Assessment) -> str:
    weak = [
        name
        for name, error in trust.standard_errors.items()
        if error > abs(trust.lens.coefficients[name])
    ]
    if not weak:
        return ""
    verb, whose = ("is", "its") if len(weak) == 1 else ("are", "their")
    return (
        f"{', '.join(weak)} {verb} smaller than {whose} standard error: fewer coefficients may do "
        "(--free, --hold)"
    )


def _correlated(trust: Assessment) -> str:
    correlation = trust.correlation
    pairs = [
        f"{trust.free[i]} and {trust.free[j]} ({number(correlation[i, j], '+.3f')})"
        for i, j in zip(*np.triu_indices(len(trust.free), 1), strict=True)
        if abs(correlation[i, j]) > _CORRELATED
    ]
    if not pairs:
        return ""
    return f"strongly correlated: {', '.join(pairs)}; judge the curve, not single coefficients"


def _corrected(trust: Assessment) -> str:
    if trust.residual == "image":
        return ""
    return (
        "residuals of the corrected photo weigh the picks unevenly; the standard errors allow for "
        "it, and those of --residual image are smaller"
    )

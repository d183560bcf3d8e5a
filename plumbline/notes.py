"""What the user should be told about a fit, in plain sentences."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from plumbline.calibration import Calibration

_CORRELATED = 0.9
_OUTSTANDING = 5.0
_CARELESS_PX = 3.0


def notes_on(made: Calibration) -> tuple[str, ...]:
    """Notes on a finished fit, its failed checks among them."""
    own = tuple(
        note
        for note in (
            _unsettled(made),
            _folding(made),
            _outstanding(made),
            _corrected(made),
            _uninformative(made),
            _correlated(made),
        )
        if note
    )
    return (*own, *(check.sentence for check in made.checks if not check.passed))


def _unsettled(made: Calibration) -> str:
    return "" if made.converged else f"{made.reason}: do not use this result"


def _folding(made: Calibration) -> str:
    fold = made.lens.fold_radius_px()
    if fold is None:
        return ""
    return (
        f"the polynomial folds over {fold:.0f} px from the centre, inside the photo: "
        "what lies farther out cannot be corrected with it"
    )


def _outstanding(made: Calibration) -> str:
    lines = [line for line in made.lines if not line.left_out]
    typical = float(np.median([line.rms_after_px for line in lines]))
    worst = max(lines, key=lambda line: line.rms_after_px)
    if worst.rms_after_px > max(_OUTSTANDING * typical, 1.0):
        return (
            f"line {worst.label} is off by {worst.rms_after_px:.3g} px (rms) and the others by "
            f"{typical:.2g} px: check whether its picks lie on one straight edge"
        )
    if made.sigma_px > _CARELESS_PX:
        return (
            f"σ̂ of {made.sigma_px:.3g} px is more than careful picks leave: check that every pick "
            "is on its line, that the edges are straight, and that the photo's size is right"
        )
    return ""


def _uninformative(made: Calibration) -> str:
    weak = [
        name for name, error in made.standard_errors.items() if error > abs(made.coefficients[name])
    ]
    if not weak:
        return ""
    verb, whose = ("is", "its") if len(weak) == 1 else ("are", "their")
    return (
        f"{', '.join(weak)} {verb} smaller than {whose} standard error: fewer coefficients may do "
        "(--free, --hold)"
    )


def _correlated(made: Calibration) -> str:
    correlation = made.correlation
    pairs = [
        f"{made.free[i]} and {made.free[j]} ({correlation[i, j]:+.3f})"
        for i, j in zip(*np.triu_indices(len(made.free), 1), strict=True)
        if abs(correlation[i, j]) > _CORRELATED
    ]
    if not pairs:
        return ""
    return f"strongly correlated: {', '.join(pairs)}; judge the curve, not single coefficients"


def _corrected(made: Calibration) -> str:
    if made.residual == "image":
        return ""
    return (
        "residuals of the corrected photo weigh the picks unevenly; the standard errors allow for "
        "it, and those of --residual image are smaller"
    )

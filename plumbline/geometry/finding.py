"""What a lens does to a photograph, in one line: barrel, pincushion or wavy, and how much."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from plumbline.frame import Array
from plumbline.geometry.lens import Lens
from plumbline.models.inverse import REACH

Kind = Literal["none", "barrel", "pincushion", "wavy"]

_SAMPLES = 64
"""Radii up to the corner: chosen, far more than the curve has bends."""
_WAVY = 0.2
"""Share of its range by which the magnification turns back before it is called wavy: chosen."""


@dataclass(frozen=True)
class Finding:
    """The size of the distortion at the corner, relative to the scale at the centre.

    Attributes:
        kind: "barrel" if magnification falls towards the corner, "pincushion" if it rises,
            "wavy" if it does both by more than a fifth of its range, "none" below 0.01 px.
        percent: Change of magnification at the corner.
        corner_px: Radial displacement of the corner in pixels.
        folds_at_px: Where the model folds before the corner, and all this is measured; else None.
    """

    kind: Kind
    percent: float
    corner_px: float
    folds_at_px: float | None = None


def finding_of(lens: Lens) -> Finding:
    """Describe the radial distortion of a lens about its own centre."""
    observed, ideal = radial_curve(lens)
    if not len(observed):
        return Finding("wavy", 0.0, 0.0, 0.0)
    folds_at_px = float(observed[-1]) if len(observed) < _SAMPLES else None
    shift = observed - ideal
    percent = 100 * (observed / ideal - 1)
    rise = np.diff(percent, prepend=0.0)
    up, down = float(rise[rise > 0].sum()), float(-rise[rise < 0].sum())
    kind: Kind = "pincushion" if up > down else "barrel"
    if np.max(np.abs(shift)) < 0.01:
        kind = "none"
    elif min(up, down) > _WAVY * max(up, down):
        kind = "wavy"
    return Finding(kind, float(percent[-1]), float(shift[-1]), folds_at_px)


def radial_curve(lens: Lens) -> tuple[Array, Array]:
    """Observed radii up to the photo's corner, and the ideal radii to the same central scale.

    Returns:
        Two arrays of square pixels; they end before the corner where the model folds.
    """
    model, unit_px = lens.model, lens.unit_px
    radial = [0.0 if name in model.tangential else 1.0 for name in model.coefficients]
    c = lens.vector * np.array(radial)
    corner = lens.frame.corner_radius * lens.frame.radius_px / unit_px
    observed = corner * np.arange(1, _SAMPLES + 1) / _SAMPLES
    points = np.stack((observed, np.zeros_like(observed)), axis=-1)
    ideal = model.undistort(points, c, REACH * corner)[:, 0] * model.central_scale(c)
    seen = np.isfinite(ideal)
    return observed[seen] * unit_px, ideal[seen] * unit_px

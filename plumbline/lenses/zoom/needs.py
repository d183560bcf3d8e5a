"""Where over a zoom lens's range another calibration would help most."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from plumbline.frame import Array, Frame
from plumbline.lenses.zoom.curves import Method
from plumbline.lenses.zoom.zoom_lens import ZoomLens


@dataclass(frozen=True)
class Need:
    """A focal length where another calibration would help.

    Attributes:
        focal_mm: The focal length.
        between: The calibrated focal lengths on either side; equal at a calibrated one.
        uncertainty_px: How far the correction may be off, in pixels of the first calibration.
    """

    focal_mm: float
    between: tuple[float, float]
    uncertainty_px: float


def needs(lens: ZoomLens) -> list[Need]:
    """Where another calibration is most needed, the worst first.

    In the middle (geometrically) of each gap the uncertainty is that of the calibrations joined
    with what another way of interpolating would make of them; at calibrated focal lengths the
    calibrations' own.
    """
    other: Method = "linear" if lens.method == "hermite" else "hermite"
    focals = [float(f) for f in lens.focals_mm]
    found = [Need(f, (f, f), _sigma_px(lens, f)) for f in focals]
    for low, high in pairwise(focals):
        middle = (low * high) ** 0.5
        change = displacement_px(lens, lens.at(middle)) - displacement_px(
            lens, lens.at(middle, other)
        )
        apart = float(np.max(np.hypot(*change.T)))
        found.append(Need(middle, (low, high), float(np.hypot(_sigma_px(lens, middle), apart))))
    return sorted(found, key=lambda need: -need.uncertainty_px)


def displacement_px(lens: ZoomLens, values: Array) -> Array:
    """Where the model moves points from the centre to the corner, in pixels, shape (n, 2).

    Args:
        lens: The lens, whose first picture tells pixels.
        values: Coefficients in the order of its `names`; the centre does not count.
    """
    frame = Frame(*lens.size, lens.pixel_aspect)
    r = frame.corner_radius * np.arange(1, 25) / 24
    angles = np.radians(np.arange(0, 360, 45))
    x, y = (np.outer(r, part).ravel() for part in (np.cos(angles), np.sin(angles)))
    moved = lens.model.apply(x, y, values[: len(lens.model.coefficients)])
    return np.stack(moved, axis=-1) * frame.radius_px


def _sigma_px(lens: ZoomLens, focal_mm: float) -> float:
    """Largest standard error of a point's place, from the calibrations' covariances."""
    values, covariance = lens.at(focal_mm), lens.covariance_at(focal_mm)
    n = len(lens.model.coefficients)
    columns = []
    for index in range(n):
        step = np.zeros_like(values)
        step[index] = 1e-6
        up, down = (displacement_px(lens, values + s * step) for s in (1, -1))
        columns.append((up - down) / 2e-6)
    slopes = np.stack(columns, axis=-1)
    variances = np.einsum("pxi,ij,pxj->p", slopes, covariance[:n, :n], slopes)
    return float(np.sqrt(max(variances.max(), 0.0)))

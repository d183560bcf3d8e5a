"""What the page is told of a fit: plain numbers and sentences."""

from __future__ import annotations

from typing import Any

import numpy as np

from plumbline.frame import Array
from plumbline.geometry.finding import radial_curve
from plumbline.geometry.lines import by_line, fit_lines
from plumbline.pick.document import Document
from plumbline.pick.live import Fitted
from plumbline.pick.observing import fitted_lines
from plumbline.pick.words import on_page
from plumbline.result.calibration import Calibration
from plumbline.result.sentence import measured_sentence
from plumbline.trust.linearised import in_frame

_CURVE = 24
"""Points of a fitted line as it is drawn; between them it is straight to 0.1 px of a screen."""


def told(fitted: Fitted, document: Document) -> dict[str, Any]:
    """A fit for the page.

    Args:
        fitted: The fit.
        document: What it was fitted to.
    """
    calibration = fitted.calibration
    if calibration is None:
        return {"failure": on_page(fitted.failure), "hint": on_page(fitted.hint)}
    return {
        "failure": "" if calibration.converged else on_page(calibration.reason),
        "hint": "",
        "finding": measured_sentence(calibration),
        "model": calibration.model,
        "coefficients": [
            {"name": name, "value": value, "error": calibration.standard_errors.get(name)}
            for name, value in calibration.coefficients.items()
        ],
        "sigma_px": calibration.sigma_px,
        "rms_px": calibration.rms_after_px,
        "dof": calibration.dof,
        "corner_px": calibration.finding.corner_px,
        "lines": _lines(calibration, [line.number for line in fitted_lines(document)]),
        "radial": radial(calibration),
    }


def _lines(calibration: Calibration, numbers: list[int]) -> list[dict[str, Any]]:
    """Each line as fitted: its curve in the photo, its picks beside it, and how straight it is."""
    lens, linear = calibration.lens, calibration.linearised
    frame = lens.frame
    observed = np.concatenate(in_frame(calibration.observations, frame))
    ideal = frame.normalise(lens.undistort_or_nan(observed), 1.0)
    sizes = calibration.observations.sizes
    fitted = fit_lines(ideal, sizes, linear.kept.astype(np.float64))
    foot = fitted.centre[linear.line] + linear.along_px[:, None] * fitted.along[linear.line]
    spans = by_line(linear.along_px, sizes)
    first, last = (np.array([bound(span) for span in spans]) for bound in (np.min, np.max))
    reach = np.linspace(first, last, _CURVE)  # (points, lines)
    curves = fitted.centre[None] + reach[..., None] * fitted.along[None]
    seen = _seen(calibration, np.concatenate((foot, curves.reshape(-1, 2))))
    feet = by_line(seen[: len(foot)], sizes)
    shown = seen[len(foot) :].reshape(_CURVE, -1, 2)
    ideals = by_line(frame.to_pixels(ideal, 1.0), sizes)
    told: list[dict[str, Any]] = []
    for index, (number, line) in enumerate(
        zip(numbers, calibration.observations.lines, strict=True)
    ):
        photo = calibration.observations.photos[line.photo].frame
        turned = photo.size != frame.size
        told.append(
            {
                "number": number,
                "rms_px": _rms(calibration, index),
                "points": _rounded(line.points_px),
                "ideal": _rounded(_in_photo(ideals[index], calibration, line.photo, turned=turned)),
                "feet": _rounded(_in_photo(feet[index], calibration, line.photo, turned=turned)),
                "curve": _rounded(
                    _in_photo(shown[:, index], calibration, line.photo, turned=turned)
                ),
                "residuals": _rounded(calibration.residuals_px[index]),
            }
        )
    return told


def _rms(calibration: Calibration, index: int) -> float:
    return float(np.sqrt(np.mean(calibration.residuals_px[index] ** 2)))


def _seen(calibration: Calibration, ideal: Array) -> Array:
    return calibration.lens.distort_or_nan(calibration.lens.frame.to_pixels(ideal, 1.0))


def _in_photo(points_px: Array, calibration: Calibration, photo: int, *, turned: bool) -> Array:
    """Points of the lens's frame in a photo's own pixels, which may be turned; centres agree."""
    if not turned:
        return points_px
    frame = calibration.observations.photos[photo].frame
    return frame.to_pixels(calibration.lens.frame.normalise(points_px, 1.0), 1.0)


def radial(calibration: Calibration) -> dict[str, Any]:
    """Displacement over the distance from the distortion centre, and how far out picks reach."""
    observed, ideal = radial_curve(calibration.lens)
    picks = calibration.observations.centred_px
    reached = float(np.max(np.hypot(picks[:, 0], picks[:, 1])))
    return {
        "radius": _rounded(observed),
        "shift": _rounded(observed - ideal),
        "reached": round(reached, 1),
    }


def _rounded(values: Array) -> list[Any]:
    """Plain numbers to a thousandth of a pixel; None for what is not a number."""
    plain = np.round(values, 3).tolist()
    if np.isfinite(values).all():
        return plain
    return _without_nan(plain)


def _without_nan(values: Any) -> Any:
    if isinstance(values, list):
        return [_without_nan(each) for each in values]
    return values if np.isfinite(values) else None

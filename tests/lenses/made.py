"""Calibrations made up for tests: coefficients given, with residuals that go with them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from plumbline.frame import Array, Frame
from plumbline.geometry.lens import Lens
from plumbline.models import get_model
from plumbline.observations import Line, Observations, Photo
from plumbline.observations.facts import LensFacts
from plumbline.result.calibration import Calibration
from plumbline.result.writing import to_json
from plumbline.trust.covariance import covariance_of, sigma_of


def calibration(
    model: str = "ptlens",
    size: tuple[int, int] = (2048, 1536),
    *,
    errors: dict[str, float] | None = None,
    covariance: Array | None = None,
    focal_mm: float | None = 8.2,
    crop_factor: float | None = 4.843,
    camera: str = "NIKON E995",
    lens: str = "",
    name: str = "facade.jpg",
    focal_px: float | None = None,
    pixel_aspect: float = 1.0,
    coefficients: Mapping[str, float] | None = None,
    **values: float,
) -> Calibration:
    """A calibration with the values given, and zeros; its covariance is made up."""
    kind = get_model(model)
    zero = dict.fromkeys((*kind.coefficients, "d", "e"), 0.0)
    every = zero | dict(coefficients or {}) | values
    usual = "b" if model == "ptlens" else kind.coefficients[0]
    known = {usual: 0.001} if errors is None else errors
    free = tuple(known)
    spread = np.diag([error**2 for error in known.values()]).reshape(len(free), len(free))
    points = np.array([[(0.3 + 0.03 * i) * size[0], 0.4 * size[1] + i % 2] for i in range(12)])
    observations = Observations(
        (Photo(size, name, pixel_aspect=pixel_aspect),),
        (Line(points, 0, "1"),),
        (
            LensFacts(
                maker="NIKON", model=lens, camera=camera, focal_mm=focal_mm, crop_factor=crop_factor
            ),
        ),
    )
    made = Calibration(
        observations=observations,
        lens=Lens(kind, Frame(*size, pixel_aspect), every, focal_px),
        free=free,
        start=zero,
        residual="image",
        covariance=spread if covariance is None else covariance,
        sigma_px=0.5,
        dof=len(points) - 2 - len(free),
        residuals_px=(np.zeros(len(points)),),
        rms_corrected_px=0.0,
        converged=True,
        reason="converged",
    )
    linear = made.linearised
    away_px = linear.image_px * linear.stretch
    return replace(
        made,
        residuals_px=(linear.residual_px,),
        sigma_px=sigma_of(linear, made.dof),
        rms_corrected_px=float(np.sqrt(np.mean(away_px**2))),
    )


def with_own_covariance(made: Calibration) -> Calibration:
    """The calibration with the covariance of its picks, as files must have it."""
    return replace(made, covariance=covariance_of(made.linearised, made.dof)[0])


def saved(path: Path, *made: Calibration) -> str:
    """Their JSON in a file, with the covariance of their picks."""
    path.write_text(to_json([with_own_covariance(each) for each in made]))
    return str(path)

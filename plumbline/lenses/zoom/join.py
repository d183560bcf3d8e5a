"""Calibrations at several focal lengths, checked and joined into a zoom lens."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from plumbline.errors import OptionError
from plumbline.frame import Array
from plumbline.lenses.zoom.curves import Method
from plumbline.lenses.zoom.zoom_lens import Node, ZoomLens, model_of, pool
from plumbline.models import CENTRE
from plumbline.observations.facts import LensFacts
from plumbline.result.calibration import Calibration

_ONE_FOCAL_LENGTH = 0.005  # relative, as `reading.photo.ONE_FOCAL_LENGTH`
_ALIKE = 0.02  # relative; chosen, frames and crop factors of one camera differ by less


def join(
    calibrations: Sequence[tuple[str, Calibration]],
    method: Method = "hermite",
    degree: int = 3,
) -> ZoomLens:
    """Join calibrations into a zoom lens.

    Args:
        calibrations: Each with its name for messages.
        method: How coefficients run over focal length.
        degree: Of the polynomial.

    Raises:
        OptionError: they are not of one lens, model and shape of sensor, or a focal length is
            not known.
    """
    if not calibrations:
        raise OptionError("nothing is given to join", hint="name results of plumbline fit")
    model = model_of(calibrations[0][1].model)
    _check_alike(calibrations)
    by_focal: list[tuple[float, list[tuple[str, Calibration]]]] = []
    for focal_mm, name, calibration in sorted(
        ((_focal_mm(name, calibration), name, calibration) for name, calibration in calibrations),
        key=lambda e: e[0],
    ):
        if by_focal and focal_mm / by_focal[-1][0] - 1 <= _ONE_FOCAL_LENGTH:
            by_focal[-1][1].append((name, calibration))
        else:
            by_focal.append((focal_mm, [(name, calibration)]))
    first = calibrations[0][1]
    lens = ZoomLens(
        model,
        tuple(
            n for n in (*model.coefficients, *CENTRE) if any(n in m.free for _, m in calibrations)
        ),
        tuple(_node(focal_mm, members) for focal_mm, members in by_focal),
        method,
        degree,
        first.lens.frame.size,
        first.lens.frame.pixel_aspect,
        _facts(calibrations),
    )
    lens.at(lens.range_mm[0])  # a degree that is too high is refused here
    return lens


def _node(focal_mm: float, members: Sequence[tuple[str, Calibration]]) -> Node:
    values, covariances = zip(
        *(_in_half_sides(calibration) for _, calibration in members), strict=True
    )
    return replace(pool(focal_mm, values, covariances), sources=tuple(name for name, _ in members))


def _in_half_sides(calibration: Calibration) -> tuple[Array, Array]:
    """Coefficients and covariance, the centre in half shorter sides."""
    names = (*calibration.lens.model.coefficients, *CENTRE)
    frame = calibration.lens.frame
    unit = {"d": frame.pixel_aspect / frame.radius_px, "e": 1 / frame.radius_px}
    scale = np.array([unit.get(name, 1.0) for name in names])
    values = np.array([calibration.coefficients[name] for name in names]) * scale
    covariance = np.zeros((len(names), len(names)))
    where = [names.index(name) for name in calibration.free]
    covariance[np.ix_(where, where)] = calibration.covariance
    return values, covariance * np.outer(scale, scale)


def _focal_mm(name: str, calibration: Calibration) -> float:
    focal_mm = calibration.observations.lenses[0].focal_length_mm(calibration.lens.frame)
    if focal_mm is None:
        raise OptionError(
            f"{name}: the focal length of this calibration is not known",
            hint="fit it again with --focal, or with --photo and a photo whose EXIF gives it",
        )
    return focal_mm


def _check_alike(calibrations: Sequence[tuple[str, Calibration]]) -> None:
    first_name, first = calibrations[0]
    facts, frame = first.observations.lenses[0], first.lens.frame
    for name, calibration in calibrations[1:]:
        own = calibration.observations.lenses[0]
        if calibration.model != first.model:
            raise OptionError(
                f"{name} was fitted with {calibration.model}, {first_name} with {first.model}",
                hint="fit all calibrations with the same --model",
            )
        if facts.model and own.model and facts.model.casefold() != own.model.casefold():
            raise OptionError(
                f"{name} is a calibration of {own.model}, {first_name} of {facts.model}",
                hint="join the calibrations of one lens",
            )
        if facts.crop_factor and own.crop_factor and _apart(facts.crop_factor, own.crop_factor):
            raise OptionError(
                f"the crop factor of {name} is {own.crop_factor:.4g}, that of {first_name} "
                f"{facts.crop_factor:.4g}",
                hint="join calibrations from one kind of sensor",
            )
        if _apart(calibration.lens.frame.corner_radius, frame.corner_radius):
            raise OptionError(
                f"the photos of {name} and {first_name} differ in their shape",
                hint="join calibrations from whole, uncropped photos of one camera",
            )
        upright = [m.lens.frame.width < m.lens.frame.height for m in (first, calibration)]
        centred = not any(m.coefficients[c] for m in (first, calibration) for c in CENTRE)
        if upright[0] != upright[1] and not centred:
            raise OptionError(
                f"one of {name} and {first_name} stands upright, the other lies, and their "
                "distortion centres cannot be compared",
                hint="fit them with photos held the same way, or with --hold d,e",
            )


def _apart(one: float, other: float) -> bool:
    return abs(one / other - 1) > _ALIKE


def _facts(calibrations: Sequence[tuple[str, Calibration]]) -> LensFacts:
    """What any of the calibrations knows of the lens; the first that knows counts."""
    every = [calibration.observations.lenses[0] for _, calibration in calibrations]

    return LensFacts(
        maker=next((each.maker for each in every if each.maker), ""),
        model=next((each.model for each in every if each.model), ""),
        camera=next((each.camera for each in every if each.camera), ""),
        mount=next((each.mount for each in every if each.mount), ""),
        crop_factor=next((each.crop_factor for each in every if each.crop_factor), None),
        aspect_ratio=next((each.aspect_ratio for each in every if each.aspect_ratio), None),
    )

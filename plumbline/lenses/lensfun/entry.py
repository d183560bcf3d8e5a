"""An entry of a LensFun database at one focal length, as a profile."""

from __future__ import annotations

from typing import Any

from plumbline.errors import OptionError, printable
from plumbline.formats.lens_files.lensfun import Distortion
from plumbline.formats.lens_files.lensfun_reading import LensfunEntry
from plumbline.lenses.choosing import LensMatch
from plumbline.lenses.focal import clamp_focal
from plumbline.lenses.lensfun.camera_names import camera_name, with_maker
from plumbline.lenses.lensfun.database import Database
from plumbline.lenses.profile import LensProfile
from plumbline.lenses.stored import projection_note
from plumbline.models import get_model
from plumbline.observations.facts import FULL_FRAME_MM
from plumbline.wording import number

_MODELS = {"POLY3": "poly3", "POLY5": "poly5", "PTLENS": "ptlens"}


def interpolated(
    database: Database, lens: Any, camera: Any, focal_mm: float | None, candidate: LensMatch
) -> LensProfile:
    """A lens of the database at a focal length, as LensFun's library interpolates it.

    Raises:
        OptionError: it is not calibrated, or not near that focal length.
    """
    entry = database.entry(lens)
    if candidate.range_mm is None or entry is None:
        raise OptionError(
            f"{printable(candidate.name)} is not calibrated for distortion in {database.name}",
            hint="name another lens with --lens-name, or a file with --lens",
        )
    used_mm, note = clamp_focal(focal_mm, candidate.range_mm, printable(candidate.name))
    found = lens.interpolate_distortion(used_mm)
    if found is None or found.model.name not in _MODELS:
        raise OptionError(
            f"LensFun does not interpolate {printable(candidate.name)} at {used_mm:g} mm",
            hint="name another lens with --lens-name, or a file with --lens",
        )
    model = _MODELS[found.model.name]
    values = dict(zip(get_model(model).coefficients, found.terms, strict=False))
    used = Distortion(model, used_mm, values)
    on = camera_name(camera) if camera else ""
    return profile_of_entry(entry, used, database.name, on).with_notes(note)


def profile_of_entry(entry: LensfunEntry, used: Distortion, where: str, camera: str) -> LensProfile:
    """An entry at one focal length.

    Args:
        entry: The lens.
        used: Its distortion at that focal length.
        where: Name of the database.
        camera: Name of the camera; may be empty.
    """
    model = get_model(used.model)
    half_side = 0.5 / float((entry.aspect_ratio**2 + 1) ** 0.5)
    unit = half_side
    if model.unit == "focal length":
        unit = used.focal_mm * entry.crop_factor / FULL_FRAME_MM
    centre = (entry.centre[0] * half_side / unit, entry.centre[1] * half_side / unit)
    on = f" on {printable(camera)}" if camera else ""
    values = ", ".join(
        f"{name} = {number(used.coefficients[name], '.6g')}" for name in model.coefficients
    )
    return LensProfile(
        f"{printable(with_maker(entry.maker, entry.model))}{on} at {used.focal_mm:.4g} mm, "
        f"{used.model} {values}, from {where}",
        model,
        tuple(used.coefficients[name] for name in model.coefficients),
        unit,
        aspect=entry.aspect_ratio,
        observed_centre=centre,
        ideal_centre=centre,
        crop_factor=entry.crop_factor,
        notes=projection_note(entry.kind),
    )

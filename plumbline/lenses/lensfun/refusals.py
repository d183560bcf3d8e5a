"""Why no lens of a database fits a photo, with what to do."""

from __future__ import annotations

from typing import Any

from plumbline.errors import OptionError, printable
from plumbline.lenses.choosing import no_camera
from plumbline.lenses.lensfun.camera_names import camera_name, similar_cameras
from plumbline.lenses.lensfun.database import Database
from plumbline.lenses.lensfun.matches import lens_match, numbers
from plumbline.lenses.names import agree, likeness, numbers_of
from plumbline.lenses.request import LensRequest
from plumbline.photos.exif import PhotoFacts

_SAME_SENSOR = 1.04
"""Largest ratio of crop factors at which LensFun 0.3 takes a lens for a camera
(`lfDatabase::FindLenses`: it keeps lenses down to 0.96 of the camera's)."""

_ALIKE = 0.75
"""Likeness of one lens under two spellings: chosen, one word of about eight may differ or lack."""


def unknown_camera(database: Database, photo: PhotoFacts, request: LensRequest) -> OptionError:
    """The photo's camera is not in the database, or not told."""
    name = request.like or request.camera or photo.facts.camera
    if not name:
        return no_camera()
    maker = "" if request.like or request.camera else photo.maker
    similar = similar_cameras(database, maker, name if not maker else photo.model)
    known = f" (similar: {', '.join(printable(each) for each in similar)})" if similar else ""
    return OptionError(
        f"the camera {name} is not in {database.name}{known}",
        hint="take a comparable camera with --like CAMERA, calibrate the lens with plumbline fit, "
        "or name a file with --lens",
    )


def unknown_lens(
    database: Database, camera: Any, name: str | None, photo: PhotoFacts
) -> OptionError:
    """The lens that the photo or the user names is not in the database for this camera."""
    if name is None:
        low, high = photo.lens_range_mm or (0.0, 0.0)
        span = f"{low:g}" if low == high else f"{low:g}–{high:g}"
        name = f"of {span} mm that EXIF names"
    on = camera_name(camera) if camera is not None else "this camera"
    smaller = [
        lens
        for lens in database.library.lenses
        if camera is not None
        and lens.crop_factor > camera.crop_factor * _SAME_SENSOR
        and lens.calib_distortion
        and agree(numbers_of(name), numbers(lens))
        and likeness(name, lens.model) >= _ALIKE
    ]
    told = f"the lens {name!r}" if name[:3] != "of " else f"a lens {name}"
    if smaller:
        best = max(smaller, key=lambda lens: likeness(name, lens.model))
        return OptionError(
            f"{told} is calibrated in {database.name} for smaller sensors only (crop factor "
            f"{best.crop_factor:.3g}), not for that of {on}",
            hint="calibrate the lens with plumbline fit, or name a file with --lens",
        )
    loose = database.library.find_lenses(camera, None, name, True) if camera is not None else []
    similar = [str(lens_match(lens, None)) for lens in loose[:5]]
    alike = f"; similar: {', '.join(similar)}" if similar else ""
    return OptionError(
        f"{told} for {on} is not in {database.name}{alike}",
        hint="name one of the database's lenses with --lens-name, or a file with --lens",
    )

"""A photo's lens from a PTLens profile.

Coefficients are interpolated linearly over focal length, clamped within 10 % of the range. On
another sensor of the mount they become a·k³, b·k², c·k, with k the lens's multiplier over the
camera's: the radius is measured in half the shorter side of the photo's own sensor.
"""

from __future__ import annotations

import numpy as np

from plumbline.errors import OptionError, printable
from plumbline.formats.lens_files.ptlens_profile import PTLensCamera, PTLensLens, PTLensProfile
from plumbline.lenses.choosing import LensMatch, choose, like_note, no_camera
from plumbline.lenses.focal import clamp_focal
from plumbline.lenses.profile import LensProfile
from plumbline.lenses.request import LensRequest
from plumbline.lenses.zoom.curves import linear_weights
from plumbline.models import get_model
from plumbline.photos.exif import PhotoFacts
from plumbline.wording import listed


def find_profile(
    profile: PTLensProfile, path: str, photo: PhotoFacts, request: LensRequest
) -> tuple[LensProfile, tuple[LensMatch, ...]]:
    """The lens of a profile for a photo.

    Raises:
        OptionError: the camera is not in the profile, or no lens or several match.
    """
    camera = _camera(profile, path, photo, request)
    name = request.lens_name or photo.facts.model
    fitting = [lens for lens in profile.lenses if lens.groups & camera.groups]
    named = [lens for lens in fitting if _matches(lens.name, name)]
    lenses = named if named or request.lens_name else fitting
    candidates = tuple(_candidate(lens) for lens in lenses)
    focal_mm = request.focal_mm or photo.facts.focal_mm
    number, aside = choose(candidates, name if named else None, focal_mm, path)
    lens, span = lenses[number], candidates[number].range_mm
    if span is None:
        raise OptionError(f"{lens.name} is not calibrated in {path}")
    used_mm, clamped = clamp_focal(focal_mm, span, lens.name)
    multiplier = request.crop_factor or camera.multiplier
    if request.like and request.crop_factor is None:
        multiplier = photo.facts.crop_factor or camera.multiplier
    values = scaled_abc(lens, used_mm, multiplier)
    used = ", ".join(f"{key} = {value:.6g}" for key, value in zip("abc", values, strict=True))
    sides = photo.size if request.full_size is None else request.full_size
    unit = min(sides) / 2 / float(np.hypot(*sides))
    notes = [aside, clamped]
    if request.like:
        notes.append(like_note(request.camera or photo.facts.camera, camera.menu_name))
    found = LensProfile(
        f"{lens.name} on {camera.menu_name} at {used_mm:.4g} mm, ptlens {used}, from {path}",
        get_model("ptlens"),
        values,
        unit,
        crop_factor=multiplier,
        photo_crop=multiplier,
    )
    return found.with_notes(*notes), candidates


def scaled_abc(lens: PTLensLens, focal_mm: float, multiplier: float) -> tuple[float, float, float]:
    """a, b, c of a lens at a focal length, on a sensor with another crop factor."""
    focals = np.array([focal for focal, _ in lens.calibrations])
    values = np.array([abc for _, abc in lens.calibrations])
    a, b, c = linear_weights(focals, focal_mm) @ values
    k = lens.multiplier / multiplier
    return float(a * k**3), float(b * k**2), float(c * k)


def _camera(
    profile: PTLensProfile, path: str, photo: PhotoFacts, request: LensRequest
) -> PTLensCamera:
    asked = request.like or request.camera
    if asked:
        words = asked.casefold().split()
        names = [c for c in profile.cameras if words in _spellings(c)]
    else:
        names = [
            camera
            for camera in profile.cameras
            if photo.model and camera.is_of(photo.maker, photo.model)
        ]
    if names:
        return names[0]
    if not asked and not photo.model:
        raise no_camera()
    known = listed(list(dict.fromkeys(printable(each.menu_name) for each in profile.cameras)), 6)
    raise OptionError(
        f"the camera {asked or photo.facts.camera} is not in {path} (it has: {known})",
        hint="take a comparable camera with --like CAMERA, or name another file with --lens",
    )


def _spellings(camera: PTLensCamera) -> list[list[str]]:
    exif = f"{camera.exif_make} {camera.exif_model}"
    return [text.casefold().split() for text in (camera.menu_name, exif, camera.exif_model)]


def _matches(name: str, wanted: str) -> bool:
    words = wanted.casefold().split()
    return bool(words) and all(word in name.casefold() for word in words)


def _candidate(lens: PTLensLens) -> LensMatch:
    focals = [focal for focal, _ in lens.calibrations]
    span = (focals[0], focals[-1]) if focals else None
    return LensMatch(lens.name, span, attached=lens.converter_factor != 1)

"""What the database's camera tells of a photo: its sensor, and whether it corrects by itself."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from plumbline.lenses.choosing import like_note
from plumbline.lenses.lensfun.camera_names import camera_name
from plumbline.lenses.profile import LensProfile
from plumbline.lenses.request import LensRequest
from plumbline.photos.cameras import shows_other_part
from plumbline.photos.exif import PhotoFacts

_CORRECTING_MOUNTS = {
    "Micro 4/3 System": "Micro 4/3",
    "Fujifilm X": "Fujifilm X",
    "Fujifilm G": "Fujifilm G",
    "Samsung NX": "Samsung NX",
    "Samsung NX mini": "Samsung NX",
    "Leica L": "L-Mount",
    "Pentax Q": "Pentax Q",
}
"""Systems whose cameras always correct the JPEGs of their lenses; LensFun's profiles are of raw
files. Others tell it by a switch in their maker notes."""

_CORRECTING_SINCE = 2008
"""Compact cameras with lenses that need correction came with the Panasonic LX3, of 2008."""


def lens_is_fixed(camera: Any) -> bool:
    """Whether a camera has a built-in lens: LensFun's mounts begin small then."""
    return str(camera.mount)[:1].islower()


def sized(
    profile: LensProfile, camera: Any, photo: PhotoFacts, request: LensRequest
) -> LensProfile:
    """The profile with the crop factor of what the photo shows, and a note where EXIF differs."""
    own = photo.facts.crop_factor
    if request.like and own:
        return replace(profile, photo_crop=own)
    if camera is None:
        return profile
    known = float(camera.crop_factor)
    if request.crop_factor or request.full_size or not own:
        return replace(profile, photo_crop=known)
    if shows_other_part(own, known):
        note = (
            f"EXIF's equivalent focal length gives a crop factor of {own:.4g}, the camera's is "
            f"{known:.4g}: taken as a photo of the middle of the sensor, as by APS-C mode or "
            f"digital zoom (--crop-factor {known:.4g} if it is whole)"
        )
        return replace(profile, photo_crop=own, shows_part=True).with_notes(note)
    note = ""
    if shows_other_part(known, own):
        note = (
            f"EXIF gives a crop factor of {own:.4g}, LensFun's camera has {known:.4g}: the latter "
            "is taken (--crop-factor)"
        )
    return replace(profile, photo_crop=known).with_notes(note)


def camera_notes(camera: Any, photo: PhotoFacts, request: LensRequest) -> list[str]:
    """What to warn of, by the kind of the camera."""
    if camera is None:
        return ["the photo's camera is not known: its sensor is taken as the calibration's"]
    notes: list[str] = []
    if request.like:
        notes.append(like_note(request.camera or photo.facts.camera, camera_name(camera)))
    kind = _correcting_kind(camera, photo)
    if kind and not (photo.in_camera or photo.not_in_camera):
        notes.append(
            f"{kind} correct the distortion of their JPEGs themselves: "
            "correct only photos that were developed from raw without a lens profile"
        )
    return notes


def _correcting_kind(camera: Any, photo: PhotoFacts) -> str:
    """The kind of a camera that corrects every photo; else empty."""
    system = _CORRECTING_MOUNTS.get(str(camera.mount))
    if system:
        return f"cameras of the {system} system"
    year = int(photo.taken[:4]) if photo.taken[:4].isdigit() else _CORRECTING_SINCE
    if lens_is_fixed(camera) and year >= _CORRECTING_SINCE:
        return f"most cameras with a built-in lens since {_CORRECTING_SINCE}"
    return ""

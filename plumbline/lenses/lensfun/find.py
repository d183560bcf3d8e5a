"""A photo's lens from LensFun's databases."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from plumbline.errors import OptionError, printable
from plumbline.lenses.choosing import Candidate, choose, like_note, no_camera
from plumbline.lenses.lensfun.database import (
    Database,
    beyond_library,
    camera_name,
    common_database,
    database_of,
    entries_of,
    find_camera,
    similar_cameras,
)
from plumbline.lenses.lensfun.entry import interpolated, profile_of_entry
from plumbline.lenses.profile import LensProfile, clamp_focal
from plumbline.lenses.request import LensRequest
from plumbline.lenses.zoom.curves import lensfun_values
from plumbline.photos.exif import PhotoFacts

Found = tuple[LensProfile, tuple[Candidate, ...]]

_SAME_RANGE = 0.02
_CONVERTERS = (", with ", "converter", "adapter")


def from_file(path: str, photo: PhotoFacts, request: LensRequest) -> Found:
    """The lens from a LensFun XML file, or from a folder of them.

    Raises:
        PlumblineError: it is damaged, or holds no lens or several that match.
    """
    if not Path(path).is_dir() and beyond_library(path):
        return _from_entries(path, photo, request)
    return find(database_of(path), photo, request, chosen_file=True)


def from_database(photo: PhotoFacts, request: LensRequest) -> Found:
    """The lens from LensFun's databases, by camera, lens and focal length.

    Raises:
        OptionError: camera or lens are not known, or several lenses match.
    """
    return find(common_database(), photo, request, chosen_file=False)


def find(
    database: Database, photo: PhotoFacts, request: LensRequest, *, chosen_file: bool
) -> Found:
    """The lens from a loaded database.

    Args:
        database: The database.
        photo: The photo.
        request: What the user says.
        chosen_file: Whether the user named the database: then its lens may be used although the
            photo's camera is not in it.
    """
    camera = _camera(database, photo, request)
    if camera is None and chosen_file:
        camera = _camera(common_database(), photo, request)
    if camera is None and (request.like or not chosen_file):
        raise _unknown_camera(database, photo, request)
    name = request.lens_name or photo.facts.model or None
    lenses = _matching(database, camera, name, asked=request.lens_name is not None)
    if not lenses and chosen_file:
        lenses = list(database.library.lenses)
    if not lenses and name:
        raise _unknown_lens(database, camera, name)
    if not name and photo.lens_range_mm is not None:
        lenses = [lens for lens in lenses if _spans(lens, photo.lens_range_mm)] or lenses
    # Of entries that differ in their crop factor alone the library puts the fitting one first.
    lenses = list({lens.model.casefold(): lens for lens in reversed(lenses)}.values())[::-1]
    focal_mm = request.focal_mm or photo.facts.focal_mm
    candidates = tuple(_candidate(lens) for lens in lenses)
    number, aside = choose(candidates, _spoken(name, lenses), focal_mm, database.name)
    profile = interpolated(database, lenses[number], camera, focal_mm, candidates[number])
    profile = replace(profile, photo_crop=_photo_crop(camera, photo, request))
    notes = [aside, *database.notes, *_camera_notes(camera, photo, request)]
    if not name and camera is not None and not _lens_is_fixed(camera) and not chosen_file:
        notes.append("the photo does not name its lens: the only one that fits was taken")
    return profile.with_notes(*notes), candidates


def _camera(database: Database, photo: PhotoFacts, request: LensRequest) -> Any | None:
    if request.like or request.camera:
        return find_camera(database, "", request.like or request.camera or "")
    return find_camera(database, photo.maker, photo.model)


def _matching(database: Database, camera: Any, name: str | None, *, asked: bool) -> list[Any]:
    if camera is None:
        words = (name or "").casefold().split()
        lenses = list(database.library.lenses)
        return [lens for lens in lenses if all(w in lens.model.casefold() for w in words)]
    found = list(database.library.find_lenses(camera, None, name))
    if not found and name and not asked and _lens_is_fixed(camera):
        # EXIF's name of a built-in lens is not in the database, its camera is.
        found = list(database.library.find_lenses(camera))
    return found


def _lens_is_fixed(camera: Any) -> bool:
    """LensFun's mounts of cameras with a lens of their own begin with a small letter."""
    return str(camera.mount)[:1].islower()


def _spans(lens: Any, range_mm: tuple[float, float]) -> bool:
    """Whether a lens has the range of focal lengths that EXIF tells of."""
    own = (lens.min_focal, lens.max_focal)
    return all(
        o and abs(o / told - 1) <= _SAME_RANGE for o, told in zip(own, range_mm, strict=True)
    )


def _spoken(name: str | None, lenses: list[Any]) -> str | None:
    """The name, unless all lenses of a fixed-lens camera are meant to be looked at."""
    if name is None:
        return None
    words = name.casefold().split()
    return name if any(any(w in lens.model.casefold() for w in words) for lens in lenses) else None


def _candidate(lens: Any) -> Candidate:
    focals = [each.focal for each in lens.calib_distortion]
    span = (float(f"{min(focals):.6g}"), float(f"{max(focals):.6g}")) if focals else None
    attached = any(word in lens.model.casefold() for word in _CONVERTERS)
    return Candidate(str(lens.model), span, attached, int(lens.score))


def _photo_crop(camera: Any, photo: PhotoFacts, request: LensRequest) -> float | None:
    if request.like and photo.facts.crop_factor:
        return photo.facts.crop_factor
    return None if camera is None else float(camera.crop_factor)


def _camera_notes(camera: Any, photo: PhotoFacts, request: LensRequest) -> list[str]:
    if camera is None:
        return ["the photo's camera is not known: its sensor is taken as the calibration's"]
    notes: list[str] = []
    if request.like:
        notes.append(like_note(request.camera or photo.facts.camera, camera_name(camera)))
    if str(camera.mount) == "Micro 4/3 System":
        notes.append(
            "cameras of the Micro 4/3 system correct the distortion of their JPEGs themselves: "
            "correct only photos that were developed from raw without a lens profile"
        )
    return notes


def _unknown_camera(database: Database, photo: PhotoFacts, request: LensRequest) -> OptionError:
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


def _unknown_lens(database: Database, camera: Any, name: str) -> OptionError:
    loose = database.library.find_lenses(camera, None, name, True)
    similar = [str(_candidate(lens)) for lens in loose[:5]]
    alike = f"; similar: {', '.join(similar)}" if similar else ""
    return OptionError(
        f"the lens {name!r} for {camera_name(camera)} is not in {database.name}{alike}",
        hint="name one of the database's lenses with --lens-name, or a file with --lens",
    )


def _from_entries(path: str, photo: PhotoFacts, request: LensRequest) -> Found:
    """From a file that the released library refuses."""
    words = (request.lens_name or "").casefold().split()
    entries = [e for e in entries_of(path) if all(word in e.model.casefold() for word in words)]
    candidates = tuple(
        Candidate(
            e.model,
            (e.distortions[0].focal_mm, e.distortions[-1].focal_mm) if e.distortions else None,
        )
        for e in entries
    )
    focal_mm = request.focal_mm or photo.facts.focal_mm
    number, aside = choose(candidates, request.lens_name, focal_mm, path)
    entry, span = entries[number], candidates[number].range_mm
    if span is None:
        raise OptionError(f"{printable(entry.model)} is not calibrated for distortion in {path}")
    used_mm, note = clamp_focal(focal_mm, span, printable(entry.model))
    camera = _camera(common_database(), photo, request)
    profile = profile_of_entry(entry, lensfun_values(entry.distortions, used_mm), path, "")
    profile = replace(profile, photo_crop=_photo_crop(camera, photo, request))
    return profile.with_notes(aside, note, *_camera_notes(camera, photo, request)), candidates

"""A photo's lens from LensFun's databases."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from plumbline.errors import OptionError, printable
from plumbline.lenses.choosing import LensMatch, choose
from plumbline.lenses.focal import clamp_focal
from plumbline.lenses.lensfun.camera import camera_notes, lens_is_fixed, sized
from plumbline.lenses.lensfun.camera_names import find_camera
from plumbline.lenses.lensfun.database import (
    Database,
    beyond_library,
    common_database,
    database_of,
    entries_of,
)
from plumbline.lenses.lensfun.entry import interpolated, profile_of_entry
from plumbline.lenses.lensfun.matches import lens_match, numbers, range_of
from plumbline.lenses.lensfun.refusals import unknown_camera, unknown_lens
from plumbline.lenses.names import agree, numbers_of, same_range
from plumbline.lenses.profile import LensProfile
from plumbline.lenses.request import LensRequest
from plumbline.lenses.zoom.curves import lensfun_values
from plumbline.photos.exif import PhotoFacts

Found = tuple[LensProfile, tuple[LensMatch, ...]]


def from_file(path: str, photo: PhotoFacts, request: LensRequest) -> Found:
    """The lens from a LensFun XML file, or from a folder of them.

    Raises:
        PlumblineError: it is damaged, or holds no lens or several that match.
    """
    if not Path(path).is_dir() and beyond_library(path):
        return _from_entries(path, photo, request)
    return find_profile(database_of(path), photo, request, chosen_file=True)


def from_database(photo: PhotoFacts, request: LensRequest) -> Found:
    """The lens from LensFun's databases, by camera, lens and focal length.

    Raises:
        OptionError: camera or lens are not known, or several lenses match.
    """
    return find_profile(common_database(), photo, request, chosen_file=False)


def find_profile(
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
        raise unknown_camera(database, photo, request)
    name = request.lens_name or photo.facts.model or None
    lenses = _fitting(database, camera, name, photo, request, chosen_file=chosen_file)
    # Of entries that differ in their crop factor alone the library puts the fitting one first.
    lenses = list({lens.model.casefold(): lens for lens in reversed(lenses)}.values())[::-1]
    focal_mm = request.focal_mm or photo.facts.focal_mm
    spoken = _spoken(name, lenses)
    candidates = tuple(lens_match(lens, spoken) for lens in lenses)
    number, aside = choose(candidates, spoken, focal_mm, database.name)
    profile = interpolated(database, lenses[number], camera, focal_mm, candidates[number])
    profile = sized(profile, camera, photo, request)
    notes = [aside, *database.notes, *camera_notes(camera, photo, request)]
    if not name and camera is not None and not lens_is_fixed(camera) and not chosen_file:
        notes.append("the photo does not name its lens: the only one that fits was taken")
    if request.lens_name and not same_range(photo.lens_range_mm, range_of(lenses[number])):
        low, high = photo.lens_range_mm or (0.0, 0.0)
        notes.append(f"EXIF names a lens of {low:g} to {high:g} mm: --lens-name counts")
    return profile.with_notes(*notes), candidates


def _fitting(
    database: Database,
    camera: Any,
    name: str | None,
    photo: PhotoFacts,
    request: LensRequest,
    *,
    chosen_file: bool,
) -> list[Any]:
    """The lenses for a camera whose numbers do not contradict the name, or EXIF's range.

    Raises:
        OptionError: there is none.
    """
    asked = request.lens_name is not None
    # Lenses that share a number in maker notes are told as "one or another".
    names = (name or "").split(" or ") if name and not asked else [name]
    found: list[Any] = []
    for each in names:
        lenses = _matching(database, camera, each, asked=asked)
        fixed = camera is not None and lens_is_fixed(camera)
        if each and not fixed:
            told = numbers_of(each)
            lenses = [lens for lens in lenses if agree(told, numbers(lens))]
        found += [lens for lens in lenses if lens not in found]
    if name is None or not asked:
        found = _of_range(found, camera, photo)
    if not found and chosen_file and name and request.lens_name is None:
        found = [
            lens
            for lens in database.library.lenses
            if agree(numbers_of(name), numbers(lens))
            and same_range(photo.lens_range_mm, range_of(lens))
        ]
    elif not found and chosen_file and not name:
        found = list(database.library.lenses)
    if not found:
        raise unknown_lens(database, camera, name, photo)
    return found


def _of_range(lenses: list[Any], camera: Any, photo: PhotoFacts) -> list[Any]:
    """Those that have the range of focal lengths that EXIF tells of."""
    if photo.lens_range_mm is None:
        return lenses
    spanning = [lens for lens in lenses if same_range(photo.lens_range_mm, range_of(lens))]
    if camera is not None and lens_is_fixed(camera):
        return spanning or lenses  # databases tell the calibrated range of built-in lenses
    return spanning


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
    if not found and name and not asked and lens_is_fixed(camera):
        # EXIF's name of a built-in lens is not in the database, its camera is.
        found = list(database.library.find_lenses(camera))
    return found


def _spoken(name: str | None, lenses: list[Any]) -> str | None:
    """The name, unless all lenses of a fixed-lens camera are meant to be looked at."""
    if name is None:
        return None
    words = name.casefold().split()
    return name if any(any(w in lens.model.casefold() for w in words) for lens in lenses) else None


def _from_entries(path: str, photo: PhotoFacts, request: LensRequest) -> Found:
    """From a file that the released library refuses."""
    words = (request.lens_name or "").casefold().split()
    entries = [e for e in entries_of(path) if all(word in e.model.casefold() for word in words)]
    candidates = tuple(
        LensMatch(
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
    profile = sized(profile, camera, photo, request)
    return profile.with_notes(aside, note, *camera_notes(camera, photo, request)), candidates

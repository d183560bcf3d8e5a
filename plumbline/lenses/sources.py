"""Files that hold a lens, told apart by their content; as profiles for a photo."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path, PurePosixPath

import numpy as np

from plumbline.errors import OptionError, ReadError, printable
from plumbline.files import ZOOM, read_bytes
from plumbline.formats.base import Source
from plumbline.frame import Frame
from plumbline.geometry.lens import Lens
from plumbline.lenses.choosing import LensMatch
from plumbline.lenses.focal import clamp_focal
from plumbline.lenses.names import agree, numbers_of, same_range
from plumbline.lenses.profile import LensProfile
from plumbline.lenses.request import LensRequest
from plumbline.lenses.stored import StoredLens
from plumbline.models import CENTRE, get_model
from plumbline.observations.facts import LensFacts
from plumbline.photos.cameras import crop_factor_of
from plumbline.photos.exif import PhotoFacts
from plumbline.wording import listed, number

_LARGEST = 100.0
"""Chosen: coefficients of real lenses are below 1, so that a decimal point was lost."""

_DATABASES = "a LensFun XML file or folder, a PTLens profile, a zoom JSON"

Found = tuple[LensProfile, tuple[LensMatch, ...]]


def find_in_file(photo: PhotoFacts, request: LensRequest) -> Found:
    """The lens in the file or folder that the request names.

    Raises:
        PlumblineError: the file is damaged or holds no lens, or none for this photo.
    """
    from plumbline.formats.lens_files import ptlens_profile
    from plumbline.lenses import ptlens, stored_files
    from plumbline.lenses.lensfun import find as lensfun
    from plumbline.lenses.zoom import json as zoom_json

    path = request.source or ""
    if Path(path).is_dir():
        return lensfun.from_file(path, photo, request)
    source = Source(path, read_bytes(path))
    head = source.head.lstrip()
    if head.startswith("<"):
        return lensfun.from_file(path, photo, request)
    if ptlens_profile.recognises(source):
        return ptlens.find_profile(ptlens_profile.read_ptlens(source), path, photo, request)
    if request.like is not None:
        raise OptionError(
            f"--like chooses a camera of a database, and {path} is not one",
            hint="leave out --like, or --lens",
        )
    if head.startswith("{") and f'"{ZOOM}"' in head[:1024]:
        return zoom_json.read_zoom(source).profile(photo, request), ()
    try:
        return _profile(stored_files.stored_lenses(source), path, photo, request), ()
    except ReadError as error:
        error.hint = error.hint.replace(stored_files.KINDS, f"{_DATABASES}, {stored_files.KINDS}")
        raise


def profile_of(stored: StoredLens, description: str) -> LensProfile:
    """A stored lens, free of its picture's pixels."""
    lens, facts = stored.lens, stored.facts
    width, height = lens.frame.square_size
    diagonal_px = float(np.hypot(width, height))
    unit_px = lens.unit_px
    dx, dy = (lens.coefficients[name] for name in CENTRE)
    return LensProfile(
        description,
        lens.model,
        tuple(lens.coefficients[name] for name in lens.model.coefficients),
        unit_px / diagonal_px,
        size=lens.frame.size,
        aspect=width / height,
        observed_centre=(dx * lens.frame.pixel_aspect / unit_px, dy / unit_px),
        camera=facts.camera,
        crop_factor=facts.crop_factor,
        pixel_aspect=lens.frame.pixel_aspect,
        photos=tuple(_base(name).casefold() for name in stored.photos),
        notes=stored.notes,
        covariance=stored.covariance,
    )


def _profile(
    lenses: Sequence[StoredLens], path: str, photo: PhotoFacts, request: LensRequest
) -> LensProfile:
    """The lens that belongs to the photo: by its name, else by its focal length."""
    focal_mm = request.focal_mm or photo.facts.focal_mm
    stored, note = _of_photo(lenses, path, photo, focal_mm)
    named = bool(photo.name) and photo.name.casefold() in {
        _base(n).casefold() for n in stored.photos
    }
    if not named:
        stored = _with_focal(stored, photo, request)
    profile = stored_lens_profile(stored, path, focal_mm)
    return profile.with_notes(note, _other_lens(stored, photo, request, path))


def _with_focal(stored: StoredLens, photo: PhotoFacts, request: LensRequest) -> StoredLens:
    """The lens with the focal length that its field of view means on the photo's sensor.

    A project without a photo that told it has a field of view, no focal length.
    """
    facts = stored.facts
    crop = facts.crop_factor or request.crop_factor or photo.facts.crop_factor
    if crop is None:
        crop = crop_factor_of(photo.maker, photo.model)
    if facts.focal_mm or not facts.hfov_deg or crop is None:
        return stored
    known = replace(facts, crop_factor=crop).focal_length_mm(stored.lens.frame)
    return replace(stored, facts=replace(facts, focal_mm=known))


def _other_lens(stored: StoredLens, photo: PhotoFacts, request: LensRequest, path: str) -> str:
    """A note where the photo names its lens in other words than the file.

    Raises:
        OptionError: the numbers in the names, or EXIF's range, contradict each other.
    """
    own, theirs = request.lens_name or photo.facts.model, stored.facts.model
    if not theirs or not (own or photo.lens_range_mm):
        return ""
    told = numbers_of(theirs)
    range_mm = None if request.lens_name else photo.lens_range_mm
    if not agree(numbers_of(own), told) or not same_range(range_mm, told.range_mm):
        low, high = photo.lens_range_mm or (0.0, 0.0)
        raise OptionError(
            f"{printable(path)} is of the lens {printable(theirs)}, the photo of "
            + (printable(own) if own else f"one of {low:g} to {high:g} mm"),
            hint=f"take another file, or say that it is the lens with --lens-name {theirs!r}",
        )
    if own and own.casefold().split() != theirs.casefold().split():
        return f"the photo names its lens {own}, the calibration {theirs}: taken as one"
    return ""


def stored_lens_profile(stored: StoredLens, path: str, focal_mm: float | None) -> LensProfile:
    """A stored lens for a photo at a focal length, which must be its own to 10 %.

    Raises:
        OptionError: it is not.
    """
    calibrated_mm = stored.facts.focal_mm
    at, clamped = "", ""
    if calibrated_mm:
        _, clamped = clamp_focal(focal_mm, (calibrated_mm, calibrated_mm), path)
        at = f" at {calibrated_mm:.4g} mm"
    names = (*stored.lens.model.coefficients, *CENTRE)
    values = [(name, stored.lens.coefficients[name]) for name in names]
    shown = ", ".join(f"{name} = {number(value, '.6g')}" for name, value in values if value)
    what = printable(stored.facts.model or stored.facts.camera or "the lens")
    description = f"{what}{at}, {stored.lens.model.label} {shown or 'without distortion'}, from "
    return profile_of(stored, description + path).with_notes(clamped)


def _of_photo(
    lenses: Sequence[StoredLens], path: str, photo: PhotoFacts, focal_mm: float | None
) -> tuple[StoredLens, str]:
    own = photo.name.casefold()
    for stored in lenses:
        if own and own in {_base(name).casefold() for name in stored.photos}:
            return stored, ""
    alike = [each for each in lenses if _values(each) == _values(lenses[0])]
    if len(alike) == len(lenses):
        return lenses[0], ""
    known = [each for each in lenses if each.facts.focal_mm]
    if known and focal_mm and len({each.facts.focal_mm for each in known}) == len(lenses):
        return min(known, key=lambda each: abs((each.facts.focal_mm or 0) - focal_mm)), ""
    names = listed(
        [name or "unnamed" for name, *_ in (each.photos for each in lenses if each.photos)], 4
    )
    return lenses[0], (
        f"{path} holds {len(lenses)} lenses and does not name this photo: those of its first image "
        f"were taken (images: {printable(names)})"
    )


def _values(stored: StoredLens) -> tuple[object, ...]:
    return tuple(sorted(stored.lens.coefficients.items())), stored.lens.frame.size


def _base(name: str) -> str:
    return PurePosixPath(name.replace("\\", "/")).name


def given_outright(photo: PhotoFacts, request: LensRequest) -> LensProfile:
    """The lens of coefficients typed in.

    Raises:
        OptionError: a name is not one of a, b, c, d, e.
    """
    given = dict(request.ptlens or {})
    wrong = sorted(set(given) - {"a", "b", "c", *CENTRE})
    if wrong:
        raise OptionError(
            f"{', '.join(wrong)} is not a coefficient of the ptlens model",
            hint="give them as --ptlens a=0,b=-0.02,c=0; d and e, the centre, are in pixels of the "
            "photo as it is stored",
        )
    if any(abs(given.get(name, 0.0)) > _LARGEST for name in ("a", "b", "c")):
        raise OptionError(
            "a coefficient of --ptlens is impossibly large", hint="check its decimal dot"
        )
    values = dict.fromkeys(("a", "b", "c", *CENTRE), 0.0) | given
    whole = request.full_size or photo.size
    lens = Lens(get_model("ptlens"), Frame(*whole), values)
    shown = ", ".join(f"{name} = {number(value, 'g')}" for name, value in given.items())
    profile = profile_of(StoredLens(lens, LensFacts()), f"the coefficients {shown}")
    return replace(profile, size=None, aspect=None)

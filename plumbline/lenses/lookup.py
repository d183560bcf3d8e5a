"""Find the lens of a photograph: in what the user names, or by its EXIF.

Without a source the user's own calibrations are looked through first, then LensFun's databases.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from plumbline.errors import OptionError
from plumbline.geometry.lens import Lens
from plumbline.lenses import sources
from plumbline.lenses.choosing import LensMatch, like_note
from plumbline.lenses.correction import Correction
from plumbline.lenses.profile import LensProfile, correction
from plumbline.lenses.request import LensRequest
from plumbline.lenses.stored import StoredLens, of_calibration
from plumbline.observations.facts import LensFacts
from plumbline.photos.exif import PhotoFacts, read_photo
from plumbline.result.calibration import Calibration

LensSource = Calibration | Lens | LensRequest | str | Path | None
"""What names a lens: itself, a file that holds it, what is known of it, or the photo's EXIF."""


@dataclass(frozen=True)
class LookUp:
    """What was found for a photo.

    Attributes:
        profile: The lens that would be used.
        candidates: The lenses of the database that match.
    """

    profile: LensProfile
    candidates: tuple[LensMatch, ...] = ()


def profile_for(photo: PhotoFacts, lens: LensSource) -> tuple[LensProfile, LensRequest]:
    """The lens of a photo by whatever names it, and the request to lay it over the photo with.

    Raises:
        PlumblineError: no lens, or more than one, is found.
    """
    if isinstance(lens, Calibration | Lens):
        own = isinstance(lens, Calibration)
        stored = of_calibration(lens) if own else StoredLens(lens, LensFacts())
        described = f"the {stored.lens.model.label} lens given"
        return sources.profile_of(stored, described), LensRequest()
    if not isinstance(lens, LensRequest):
        lens = LensRequest(source=None if lens is None else str(lens))
    return look_up(photo, lens).profile, lens


def find_correction(photo: PhotoFacts, request: LensRequest) -> Correction:
    """Find the lens of a photograph, and lay it over the photograph.

    Args:
        photo: What the photograph says of itself.
        request: What the user says.

    Raises:
        PlumblineError: no lens, or more than one, is found, or the photo is a crop of unknown
            size; the sentence says what to add.
    """
    return correction(look_up(photo, request).profile, photo, request)


def find_lens(photo: str | Path, request: LensRequest | None = None) -> LookUp:
    """Find the lens that `correct` would use for a photograph, with the lenses that match.

    Args:
        photo: The photograph.
        request: What is known of the lens; by default EXIF alone tells it.

    Raises:
        ReadError: the photograph cannot be read.
        OptionError: no lens, or more than one, is found.
    """
    return look_up(read_photo(photo), request or LensRequest())


def look_up(photo: PhotoFacts, request: LensRequest) -> LookUp:
    """Find the lens of a photograph, with the candidates that were looked at.

    Raises:
        PlumblineError: no lens, or more than one, is found.
    """
    if request.source is not None and request.ptlens is not None:
        raise OptionError(
            "the lens is given twice, as a file and as coefficients",
            hint="give one of --lens and --ptlens",
        )
    if request.ptlens is not None:
        if request.like is not None:
            raise OptionError("--like and --ptlens are both given", hint="leave one of them out")
        return LookUp(sources.given_outright(photo, request))
    if request.source is not None:
        profile, candidates = sources.find_in_file(photo, request)
        return LookUp(_told(profile, photo, request), candidates)
    from plumbline.lenses import store
    from plumbline.lenses.lensfun import find as lensfun

    own, notes = store.find_profile(photo, request)
    if own is not None:
        return LookUp(_as_asked(own, photo, request).with_notes(*notes))
    profile, candidates = lensfun.from_database(photo, request)
    return LookUp(_told(profile, photo, request).with_notes(*notes), candidates)


def _told(profile: LensProfile, photo: PhotoFacts, request: LensRequest) -> LensProfile:
    """The profile, saying who named the lens where EXIF's own tag did not."""
    if not photo.lens_told_by or not request.looks_for_name:
        return profile
    return replace(
        profile, description=f"{profile.description} (lens named by {photo.lens_told_by})"
    )


def _as_asked(profile: LensProfile, photo: PhotoFacts, request: LensRequest) -> LensProfile:
    """One of the user's own calibrations; with `like`, that of another camera, and said so."""
    if request.like is None:
        return profile
    note = like_note(request.camera or photo.facts.camera, profile.camera)
    crop = photo.facts.crop_factor if profile.crop_factor else None
    return replace(profile, photo_crop=crop or profile.crop_factor).with_notes(note)

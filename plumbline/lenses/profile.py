"""A lens at one focal length, free of any photo's pixels, and its application to a photo.

Lengths are shares of the diagonal of the picture that the lens was calibrated in, so that a
profile serves photos of any size from that camera. Another sensor sees another part of the same
image circle: with the crop factors κ of the photo's camera and of the calibration's,

    unit_px = unit · (diagonal of the whole photo in px) · κ_photo / κ_calibration

which is LensFun's rule. Source: LensFun 0.3.4, `lfModifier::lfModifier`.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from plumbline.errors import OptionError
from plumbline.frame import Array, Frame
from plumbline.geometry.lens import refuse_impossible
from plumbline.lenses.correction import Correction
from plumbline.lenses.mapping import TURNS, UPRIGHT, PhotoLens, Turn
from plumbline.lenses.photo_history import history_notes, shape, whole_size
from plumbline.lenses.request import LensRequest
from plumbline.models import Model
from plumbline.photos.cameras import same_camera, shows_other_part
from plumbline.photos.exif import PhotoFacts

_SAME_SHAPE = 0.02
"""Relative: chosen between pixels cropped by cameras (under 1 %) and the next shape (3:2 to 16:10,
7 %)."""

_VISIBLE_PX = 0.1
"""Chosen: a tenth of what picks are good for."""


@dataclass(frozen=True)
class LensProfile:
    """A lens at one focal length.

    Attributes:
        description: What it is and where it was found, to follow "used: ".
        model: The distortion model.
        coefficients: Those of the model, in its order.
        unit: Length of a normalised radius of 1, as a share of the picture's diagonal.
        size: Width and height in pixels of the picture it was calibrated in, if known.
        aspect: Width over height of that picture; None if the lens is for the photo as it is
            stored, whatever its shape.
        observed_centre: Offset of the distortion centre in units of `unit`, observed side.
        ideal_centre: The same on the ideal side.
        camera: The camera it was calibrated with; may be empty.
        crop_factor: Of that camera.
        photo_crop: Crop factor of the photo's camera, where the source knows it.
        shows_part: Whether that is the crop factor of the part of the sensor that is shown.
        pixel_aspect: Width of one pixel over its height.
        photos: Names of the pictures it was calibrated in, in small letters, without folders.
        notes: What to warn of, in plain sentences.
        covariance: Of the coefficients, shape (k, k); None if unknown.
    """

    description: str
    model: Model
    coefficients: tuple[float, ...]
    unit: float
    size: tuple[int, int] | None = None
    aspect: float | None = None
    observed_centre: tuple[float, float] = (0.0, 0.0)
    ideal_centre: tuple[float, float] = (0.0, 0.0)
    camera: str = ""
    crop_factor: float | None = None
    photo_crop: float | None = None
    shows_part: bool = False
    pixel_aspect: float = 1.0
    photos: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    covariance: Array | None = field(default=None, compare=False)

    def with_notes(self, *notes: str) -> LensProfile:
        """The same profile with more notes."""
        return replace(self, notes=(*self.notes, *(note for note in notes if note)))


def correction(profile: LensProfile, photo: PhotoFacts, request: LensRequest) -> Correction:
    """Lay a lens over a photo, as the two maps that correct it; raises as `laid_over`."""
    mapped, notes = laid_over(profile, photo, request)
    return Correction(mapped.distort, mapped.undistort, photo.size, profile.description, notes)


def laid_over(
    profile: LensProfile, photo: PhotoFacts, request: LensRequest
) -> tuple[PhotoLens, tuple[str, ...]]:
    """Lay a lens over a photo.

    Returns:
        The lens over the photo, and what the user should be warned of.

    Raises:
        OptionError: the photo is cropped, or of another shape than the lens's pictures, and the
            request does not say how.
    """
    notes = [*photo.notes, *history_notes(photo)]
    if profile.shows_part:
        photo = replace(photo, digital_zoom=None)  # it is in the crop factor
    if not any(profile.coefficients) and profile.observed_centre == profile.ideal_centre:
        notes.append("the lens has no distortion: the photo stays as it is")
    elif not any(profile.coefficients):
        notes.append("the lens has no distortion: the photo is only shifted (d, e)")
    whole = whole_size(photo, profile.size, request, notes)
    frame = Frame(*photo.size, profile.pixel_aspect)
    diagonal_px = float(np.hypot(*Frame(*whole, profile.pixel_aspect).square_size))
    _check_shape(profile, whole, request, notes)
    unit_px = profile.unit * diagonal_px * _crop_ratio(profile, photo, request, notes)
    for centre in (profile.observed_centre, profile.ideal_centre):
        far = float(np.hypot(*centre)) * unit_px / diagonal_px
        refuse_impossible(profile.coefficients, far)
    turn, otherwise = _turns(profile, photo)
    mapped = PhotoLens(
        frame,
        profile.model,
        profile.coefficients,
        unit_px,
        profile.observed_centre,
        profile.ideal_centre,
        turn,
    )
    if otherwise is not None:
        notes += _unknown_turn(mapped, replace(mapped, turn=otherwise))
    return mapped, (*profile.notes, *notes)


def _check_shape(
    profile: LensProfile, whole: tuple[int, int], request: LensRequest, notes: list[str]
) -> None:
    square = Frame(*whole, profile.pixel_aspect).square_size
    if profile.aspect is None or request.crop_factor is not None:
        return
    expected = max(profile.aspect, 1 / profile.aspect)
    if abs(shape(square) / expected - 1) <= _SAME_SHAPE:
        return
    told = (
        f"the photo's sides are as {shape(square):.3g}:1, those of the pictures the lens was "
        f"calibrated in as {expected:.3g}:1"
    )
    if profile.photo_crop is None:
        raise OptionError(
            told,
            hint="if the photo is a crop, give the size of the whole picture with --full-size WxH, "
            "or the crop factor of what is left with --crop-factor",
        )
    if request.full_size is None:
        notes.append(
            f"{told}: taken as the whole picture of a sensor with crop factor "
            f"{profile.photo_crop:.4g} (--full-size if it is a crop)"
        )


def _crop_ratio(
    profile: LensProfile, photo: PhotoFacts, request: LensRequest, notes: list[str]
) -> float:
    """Crop factor of the photo over that of the calibration."""
    if request.crop_factor is not None and profile.crop_factor is None:
        raise OptionError(
            f"--crop-factor cannot be compared: no crop factor is given by {profile.description}",
            hint="leave --crop-factor out, or give --full-size WxH",
        )
    given = request.crop_factor or profile.photo_crop
    if given is not None and profile.crop_factor is not None:
        return given / profile.crop_factor
    own, theirs = photo.facts.crop_factor, profile.crop_factor
    camera = request.camera or photo.facts.camera
    same = not camera or not profile.camera or same_camera(camera, profile.camera)
    if own and theirs and request.full_size is None:
        if not same:
            notes.append(
                f"the lens was calibrated with {profile.camera}: scaled by the crop factors, "
                f"{own:.4g} to {theirs:.4g}"
            )
            return own / theirs
        if shows_other_part(own, theirs) or shows_other_part(theirs, own):
            notes.append(
                f"EXIF gives a crop factor of {own:.4g}, the calibration's photos have "
                f"{theirs:.4g}: scaled by them, as another part of one sensor (--crop-factor)"
            )
            return own / theirs
    if not same:
        notes.append(
            f"the lens was calibrated with {profile.camera}, this photo taken with "
            f"{camera}: taken as sensors of one size (--crop-factor)"
        )
    return 1.0


def _turns(profile: LensProfile, photo: PhotoFacts) -> tuple[Turn, Turn | None]:
    """How the calibration's picture lies in the displayed photo, and how else it may lie."""
    round_about_the_middle = not (
        any(profile.observed_centre) or any(profile.ideal_centre) or profile.model.tangential
    )
    if round_about_the_middle:
        return UPRIGHT, None
    wide, was_wide = photo.size[0] >= photo.size[1], profile.aspect is None or profile.aspect >= 1
    if wide == was_wide and photo.name.casefold() in profile.photos:
        return UPRIGHT, None
    if profile.aspect is None or (was_wide and wide != photo.turned):
        return TURNS[photo.orientation], None
    # EXIF does not tell to which side the camera was turned, for the one photo or the other.
    return (UPRIGHT, TURNS[3]) if wide == was_wide else (TURNS[6], TURNS[8])


def _unknown_turn(taken: PhotoLens, otherwise: PhotoLens) -> list[str]:
    """What it means that the camera was perhaps turned to the other side."""
    off_px = taken.largest_difference_px(otherwise)
    if off_px < _VISIBLE_PX:
        return []
    how = "as turned clockwise" if taken.turn == TURNS[6] else "where it was calibrated"
    told = f": up to {off_px:.1f} px off if it was the other" if np.isfinite(off_px) else ""
    return [
        "which side was up where the camera was turned is not known, and the distortion "
        f"centre was taken {how}{told}"
    ]

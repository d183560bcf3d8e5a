"""What a photo tells of its past: resized, cropped, or corrected already."""

from __future__ import annotations

from plumbline.errors import OptionError
from plumbline.lenses.request import LensRequest
from plumbline.photos.exif import PhotoFacts

_MERELY_RESIZED = 0.01
"""Relative difference of shapes: chosen, rounding sides to pixels changes less."""

_CORRECTORS = ("ptlens", "dxo", "hugin", "nona", "lensfun")


def history_notes(photo: PhotoFacts) -> list[str]:
    """Signs that the distortion was corrected before, in plain sentences."""
    notes: list[str] = []
    told = photo.history.lower()
    if "corrected by plumbline" in told:
        notes.append("plumbline corrected this photo already; a second correction bends it again")
    elif any(program in told for program in _CORRECTORS):
        notes.append(
            f"the photo's EXIF names {photo.history!r}: it may be corrected already, and a second "
            "correction bends it the other way"
        )
    if photo.profile_applied:
        notes.append(
            "the photo was developed with a lens profile (XMP), so that it is corrected already"
        )
    if photo.in_camera:
        notes.append(
            f"the camera corrected the distortion itself ({photo.in_camera}): a second correction "
            "bends the photo the other way"
        )
    return notes


def shape(size: tuple[float, float]) -> float:
    """Longer side over shorter side."""
    return max(size) / min(size)


def whole_size(
    photo: PhotoFacts,
    calibrated_size: tuple[int, int] | None,
    request: LensRequest,
    notes: list[str],
) -> tuple[int, int]:
    """Size of the camera's whole picture at the photo's scale.

    Args:
        photo: The photo.
        calibrated_size: Size of the pictures the lens was calibrated in, if known.
        request: What the user says.
        notes: Takes what to tell the user.

    Raises:
        OptionError: the photo is a crop, and the request does not say of what.
    """
    if request.full_size is not None:
        return _given_size(photo.size, request.full_size, notes)
    if request.crop_factor is not None:
        return photo.size
    if photo.digital_zoom is not None:
        notes.append(_digital_zoom_note(photo.size, photo.digital_zoom))
    told = photo.exif_size
    if told is None or photo.size in (told, told[::-1], calibrated_size):
        return photo.size
    width, height = photo.size
    if abs(shape(told) / shape(photo.size) - 1) <= max(_MERELY_RESIZED, 1 / min(photo.size)):
        notes.append(
            f"the photo was resized from {told[0]}x{told[1]} to {width}x{height}, says its EXIF: "
            "taken as the whole picture"
        )
        return photo.size
    raise OptionError(
        f"the photo is {width}x{height}, but its EXIF gives a picture of {told[0]}x{told[1]}: "
        "it was cropped, and what part of the lens it shows is not known",
        hint="give the size of the whole picture at the photo's scale with --full-size WxH (of the "
        "photo itself if it is whole), or the crop factor of what is left with --crop-factor",
    )


def _digital_zoom_note(size: tuple[int, int], ratio: float) -> str:
    width, height = (round(side * ratio) for side in size)
    return (
        f"the photo was taken with a digital zoom of {ratio:.4g} and shows the middle of the "
        f"picture: if the lens was calibrated without, give --full-size {width}x{height}"
    )


def _given_size(size: tuple[int, int], full: tuple[int, int], notes: list[str]) -> tuple[int, int]:
    lies_otherwise = (full[0] < full[1]) != (size[0] < size[1]) and size[0] != size[1]
    whole = (full[1], full[0]) if lies_otherwise else full
    if whole[0] < size[0] or whole[1] < size[1]:
        raise OptionError(
            f"the whole picture, {whole[0]}x{whole[1]}, is smaller than the photo, "
            f"{size[0]}x{size[1]}",
            hint="give --full-size as the picture was before the crop, at the photo's scale",
        )
    if whole != size:
        notes.append(
            f"the photo is taken as the middle of a picture of {whole[0]}x{whole[1]} pixels"
        )
    return whole

"""Picture files from pixels, with the metadata of the photograph they came from."""

from __future__ import annotations

import io
import struct
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from PIL import Image

from plumbline.errors import OptionError, WriteError
from plumbline.photos.files import ifd, jpeg, photoshop, png, riff
from plumbline.photos.files.exif import annotated, shortened
from plumbline.photos.files.metadata import Metadata
from plumbline.photos.files.picture import MAKER_NOTES_LOST, Picture, Pixels, swapped
from plumbline.wording import count, joined

FORMATS = {
    ".jpg": "JPEG",
    ".jpeg": "JPEG",
    ".jpe": "JPEG",
    ".tif": "TIFF",
    ".tiff": "TIFF",
    ".png": "PNG",
    ".webp": "WEBP",
}
"""Formats by suffix; Pillow knows those of further ones."""

_SAMPLINGS = {
    0: cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444,
    1: cv2.IMWRITE_JPEG_SAMPLING_FACTOR_422,
    2: cv2.IMWRITE_JPEG_SAMPLING_FACTOR_420,
}
_THUMBNAIL_QUALITIES = (90, 80, 70, 60, 45, 30)  # tried until it is no longer than the old one
_ASPECT_TOLERANCE = 0.03
"""Chosen: thumbnails of 160 pixels round the shape of a photo by less."""

_PNG_LEVEL = 4
"""Chosen: higher levels of zlib take twice the time for 1 % on photographs."""


def format_of(target: Path) -> str:
    """Pillow's name of the format that a file name asks for.

    Raises:
        OptionError: the format is unknown, or cannot be written.
    """
    suffix = target.suffix.lower()
    name = FORMATS.get(suffix) or Image.registered_extensions().get(suffix, "")
    if name not in FORMATS.values() and name not in Image.SAVE:
        raise OptionError(
            f"pictures cannot be written as {target.suffix or 'a file without suffix'}",
            hint="name a .jpg, .tif, .png or .webp with -o",
        )
    return name


def encode(picture: Picture, target: Path, quality: int, note: str) -> tuple[bytes, list[str]]:
    """The bytes of a picture file.

    Args:
        picture: The corrected picture with the metadata of its original.
        target: The file they are for, whose suffix says in which format.
        quality: 1 to 100, for JPEG and WebP.
        note: What to add to EXIF's Software.

    Returns:
        The bytes, and what could not be kept, in plain sentences.

    Raises:
        OptionError: the format cannot hold the picture.
        WriteError: encoding failed.
    """
    name = format_of(target)
    _refuse_loss(picture, name)
    metadata, remark, notes = _fitting(picture, name, note)
    try:
        if name == "JPEG":
            return jpeg.with_metadata(_jpeg(picture, quality), metadata, remark), notes
        if name == "PNG":
            return png.with_metadata(_png(picture), metadata, remark), notes
        if name == "TIFF":
            from plumbline.photos.files import tiff_writing

            return tiff_writing.encoded(picture, metadata, note), notes
        if name == "WEBP":
            return riff.with_remark(_webp(picture, metadata, quality), remark), notes
        return _by_pillow(picture, name), [*notes, f"{name} keeps no metadata"]
    except (OSError, ValueError, cv2.error, struct.error) as error:
        raise WriteError(f"the picture cannot be encoded: {error}", path=target) from None


def _refuse_loss(picture: Picture, name: str) -> None:
    """Refuse a format that would lose more than the distortion."""
    deep = picture.pixels.dtype != np.uint8
    if name == "JPEG" and picture.alpha:
        raise OptionError(
            "JPEG cannot be transparent", hint="name a .png or .tif with -o, or another --border"
        )
    if deep and name not in ("PNG", "TIFF"):
        raise OptionError(f"{name} cannot hold 16 bits", hint="name a .png or .tif with -o")
    if picture.inks and name not in ("JPEG", "TIFF"):
        raise OptionError(f"{name} cannot hold CMYK", hint="name a .tif with -o")


def _fitting(picture: Picture, name: str, note: str) -> tuple[Metadata, str, list[str]]:
    """The metadata for a format with a fresh thumbnail, a remark if EXIF has no room for the note.

    Returns:
        The metadata with the note in EXIF, the note itself where it is not, and what was lost.
    """
    metadata, notes = picture.metadata, list[str]()
    if name != picture.storage.format:
        metadata, notes = _carried(metadata, name)
    if name == "JPEG" and not metadata.records and len(metadata.xmp) > jpeg.MOST_OF_XMP:
        metadata = replace(metadata, xmp=b"")
        notes.append("XMP is too long for JPEG and was not kept")
    if name == "TIFF":
        return metadata, "", notes
    most = jpeg.MOST_OF_EXIF if name == "JPEG" else None
    try:
        exif = metadata.exif
        if most is not None and len(exif) > most:
            exif, left = shortened(exif)
            told = count(left, "long field") + " and the maker notes" if left else "the maker notes"
            notes.append(f"EXIF is too long for JPEG: {told} were not kept")
        noted = annotated(exif, note, lambda old: _thumbnail(picture, old), most)
    except (ValueError, struct.error):
        notes.append("EXIF is damaged and was kept as it is, without a note of the correction")
        return metadata, note, notes
    if not noted.noted:
        notes.append("EXIF is full: the correction is noted in a comment instead")
    if noted.broken:
        notes.append(f"{count(noted.broken, 'broken field')} of EXIF left out")
    return replace(metadata, exif=noted.block), "" if noted.noted else note, notes


def _carried(metadata: Metadata, name: str) -> tuple[Metadata, list[str]]:
    """What of the metadata another format takes, and what it does not."""
    lost = list(metadata.only_here)
    if metadata.photoshop and name != "TIFF" and photoshop.holds_more(metadata.photoshop):
        lost.append("Photoshop's resources")
    if name == "WEBP":
        lost += [
            what for what, has in (("IPTC", metadata.iptc), ("a comment", metadata.comment)) if has
        ]
    notes = [f"{name} does not hold {joined(lost)} of the original: not kept"] if lost else []
    if name == "TIFF" and metadata.exif:
        try:
            if ifd.has_maker_notes(metadata.exif):
                notes.append(MAKER_NOTES_LOST)
        except (ValueError, struct.error):
            metadata = replace(metadata, exif=b"")
            notes.append("EXIF is damaged and was not kept")
    return replace(metadata, records=()), notes


def _thumbnail(picture: Picture, old: bytes) -> bytes | None:
    """A new thumbnail of the same size, no longer than the old one; None if there is none."""
    if not old or picture.inks or picture.pixels.dtype != np.uint8:
        return None
    former: Any = cv2.imdecode(np.frombuffer(old, dtype=np.uint8), cv2.IMREAD_COLOR)
    if former is None:
        return None
    height, width = picture.pixels.shape[:2]
    if abs(former.shape[1] / former.shape[0] / (width / height) - 1) > _ASPECT_TOLERANCE:
        return None
    colours = picture.pixels[..., :3] if picture.pixels.ndim == 3 else picture.pixels
    small = cv2.resize(colours, former.shape[1::-1], interpolation=cv2.INTER_AREA)
    for quality in _THUMBNAIL_QUALITIES:
        data = _cv2_encoded(".jpg", small, {cv2.IMWRITE_JPEG_QUALITY: quality})
        if len(data) <= len(old):
            return data
    return None


def _cv2_encoded(suffix: str, pixels: Pixels, parameters: dict[int, int]) -> bytes:
    done, data = cv2.imencode(
        suffix, pixels, [part for pair in parameters.items() for part in pair]
    )
    if not done:
        raise ValueError("OpenCV does not say why")
    return data.tobytes()


def _image(picture: Picture) -> Image.Image:
    """The picture as Pillow has it."""
    pixels = picture.pixels
    if picture.inks:
        return Image.fromarray(pixels, "CMYK")
    colour = pixels.ndim == 3 and pixels.shape[2] >= 3
    return Image.fromarray(swapped(pixels) if colour else pixels)


def _by_pillow(picture: Picture, name: str, **how: Any) -> bytes:
    buffer = io.BytesIO()
    _image(picture).save(buffer, name, **how)
    return buffer.getvalue()


def _jpeg(picture: Picture, quality: int) -> bytes:
    storage = picture.storage
    if picture.inks:
        return _by_pillow(picture, "JPEG", quality=quality, subsampling=storage.sampling)
    parameters = {
        cv2.IMWRITE_JPEG_QUALITY: quality,
        cv2.IMWRITE_JPEG_SAMPLING_FACTOR: _SAMPLINGS[storage.sampling],
        cv2.IMWRITE_JPEG_PROGRESSIVE: int(storage.progressive),
    }
    return _cv2_encoded(".jpg", picture.pixels, parameters)


def _png(picture: Picture) -> bytes:
    if picture.pixels.ndim == 3 and picture.pixels.shape[2] == 2:
        return _by_pillow(picture, "PNG")
    return _cv2_encoded(".png", picture.pixels, {cv2.IMWRITE_PNG_COMPRESSION: _PNG_LEVEL})


def _webp(picture: Picture, metadata: Metadata, quality: int) -> bytes:
    return _by_pillow(
        picture,
        "WEBP",
        quality=quality,
        lossless=picture.storage.lossless or picture.storage.format not in ("JPEG", "WEBP"),
        exif=metadata.exif,
        icc_profile=metadata.icc,
        xmp=metadata.xmp,
    )

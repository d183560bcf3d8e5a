"""The photographs of a calibration, found on disk and reduced for a report."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plumbline.errors import ReadError
from plumbline.files import is_same, read_bytes
from plumbline.observations import Photo
from plumbline.photos.exif import read_photo
from plumbline.photos.turning import turned_upright
from plumbline.result.calibration import Calibration

_LONG_SIDE = 1600
"""Pixels; chosen, twice what a page shows, so that enlarging pays."""


@dataclass(frozen=True, eq=False)
class ShownPhoto:
    """A photograph as a report shows it.

    Attributes:
        path: Its file.
        sha256: Of the file's bytes, in hexadecimal.
        pixels: Reduced, shape (rows, columns, 3), red, green, blue of 8 bits.
    """

    path: Path
    sha256: str
    pixels: NDArray[np.uint8]


@dataclass(frozen=True)
class FoundPhotos:
    """The photos of one calibration.

    Attributes:
        pictures: One for each photo; None where there is none to show.
        notes: Why there is none, and what else to know, in plain sentences.
    """

    pictures: tuple[ShownPhoto | None, ...]
    notes: tuple[str, ...] = ()


def find_photos(
    calibrations: Sequence[Calibration], given: str | None, beside: Path | None = None
) -> list[FoundPhotos]:
    """Look for the photos that points were picked in, by name.

    Args:
        calibrations: One a lens.
        given: The file that the user names: the only photo there is, or the one of that name.
        beside: A file in whose folder to look before those of the points.

    Returns:
        One entry a calibration.

    Raises:
        ReadError: the file that the user names cannot be read, or is none of the photos.
            One that is found by its name and is another picture is not shown, with a note.
    """
    photos = [photo for calibration in calibrations for photo in calibration.observations.photos]
    if given is not None:
        read_photo(given)
        if len(photos) > 1 and not any(_base(p) == Path(given).name for p in photos):
            raise ReadError(
                f"none of the {len(photos)} photos has this name",
                path=given,
                hint="leave out --photo and put the photos beside the points",
            )
    found: list[FoundPhotos] = []
    for calibration in calibrations:
        notes: list[str] = []
        pictures: list[ShownPhoto | None] = []
        for photo in calibration.observations.photos:
            mine = given is not None and (len(photos) == 1 or _base(photo) == Path(given).name)
            if given is not None and mine:
                _checked(photo, Path(given), read_bytes(given))
            places = (
                [Path(given)] if given is not None and mine else _places(calibration, photo, beside)
            )
            shown = _picture(photo, places, notes)
            pictures.append(shown)
            if shown is not None and not photo.sha256:
                notes.append(
                    f"whether {shown.path.name} is the picture that the points were picked "
                    "in is not known: it was not at hand when they were read"
                )
        found.append(FoundPhotos(tuple(pictures), tuple(notes)))
    return found


def _base(photo: Photo) -> str:
    """The file name at the end of what a file of points says, which may be of another system."""
    name = photo.name.replace("\\", "/").rpartition("/")[2]
    return "" if name in (".", "..") else name


def _places(calibration: Calibration, photo: Photo, beside: Path | None) -> list[Path]:
    name = _base(photo)
    files = [Path(origin.path) for origin in calibration.observations.origins]
    if beside is not None:
        files.insert(0, beside)
    return [file.parent / name for file in files] if name else []


def _picture(photo: Photo, places: Sequence[Path], notes: list[str]) -> ShownPhoto | None:
    name = photo.name or "the photo"
    for index, path in enumerate(places):
        if any(is_same(path, str(other)) for other in places[:index]) or not _is_file(path):
            continue
        try:
            return _read(photo, path)
        except ReadError as error:
            notes.append(f"{error.message}; it is not shown")
            return None
    notes.append(f"{name} was not found and is not shown (--photo names it)")
    return None


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def _read(photo: Photo, path: Path) -> ShownPhoto:
    """Decode and reduce a photo.

    Raises:
        ReadError: it cannot be read, is of another size than the picks, or another picture.
    """
    import cv2

    from plumbline.photos.files.picture import decode

    facts = read_photo(path)
    if photo.frame.size not in (facts.size, facts.stored_size):
        raise ReadError(
            f"the photo is {facts.size[0]}x{facts.size[1]} and the points were picked at "
            f"{photo.frame.width}x{photo.frame.height}",
            path=path,
        )
    data = read_bytes(path)
    sha256 = _checked(photo, path, data)
    picture = decode(data, path)
    pixels = picture.pixels
    scale = _LONG_SIDE / max(pixels.shape[:2])
    if scale < 1:
        width, height = (max(1, round(scale * side)) for side in pixels.shape[1::-1])
        pixels = np.asarray(cv2.resize(pixels, (width, height), interpolation=cv2.INTER_AREA))
    upright = photo.frame.size == facts.size
    shown = turned_upright(_as_rgb(pixels, inks=picture.inks), facts.orientation if upright else 1)
    return ShownPhoto(path, sha256, np.ascontiguousarray(shown))


def _checked(photo: Photo, path: Path, data: bytes) -> str:
    """The SHA-256 of a photo's file.

    Raises:
        ReadError: the points were picked in another one.
    """
    sha256 = hashlib.sha256(data).hexdigest()
    if photo.sha256 not in ("", sha256):
        raise ReadError(
            "this is another picture than the points were picked in: the SHA-256 differs",
            path=path,
            hint="name the very file with --photo, or leave it out",
        )
    return sha256


def _as_rgb(pixels: NDArray[Any], *, inks: bool) -> NDArray[np.uint8]:
    """Red, green and blue of 8 bits from what `decode` gives."""
    from PIL import Image

    values = (
        (pixels >> 8).astype(np.uint8) if pixels.dtype == np.uint16 else pixels.astype(np.uint8)
    )
    if values.ndim == 2 or values.shape[2] <= 2:
        grey = values if values.ndim == 2 else values[..., 0]
        return np.repeat(grey[..., None], 3, axis=2)
    if inks:
        return np.asarray(Image.fromarray(values, "CMYK").convert("RGB"))
    return values[..., 2::-1]

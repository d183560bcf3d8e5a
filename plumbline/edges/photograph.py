"""A photograph to look for edges in: its pixels as the picks count them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plumbline.errors import OptionError, ReadError
from plumbline.files import read_bytes
from plumbline.lenses.photo_history import history_notes
from plumbline.observations import Observations, Photo
from plumbline.photos.exif import PhotoFacts, read_photo
from plumbline.photos.files.picture import decode
from plumbline.photos.turning import turned_upright

PhotoSource = str | Path | NDArray[Any]

_SHAPES = (2, 3)
"""Dimensions of a grey picture and of one with colours."""


@dataclass(frozen=True, eq=False)
class Photograph:
    """Pixels to look for edges in.

    Attributes:
        pixels: 8 or 16 bit: grey (rows, columns) or blue, green, red (…, 3), upright.
        name: Its file's name; empty for an array.
        facts: What its file tells; None for an array.
        halved_colours: Whether the file stores colours at half the resolution (JPEG 4:2:0).
        notes: Signs that the distortion was corrected before.
    """

    pixels: NDArray[Any]
    name: str = ""
    facts: PhotoFacts | None = None
    halved_colours: bool = False
    notes: tuple[str, ...] = ()

    @property
    def size(self) -> tuple[int, int]:
        """Width and height."""
        return self.pixels.shape[1], self.pixels.shape[0]


def load(source: PhotoSource, size: tuple[int, int] | None = None) -> Photograph:
    """Load a photograph, upright as a viewer shows it.

    Args:
        source: A file; or an array as `Photograph.pixels` has it.
        size: Width and height that picks were made at; a photo that EXIF turns may have been
            picked in as it is stored.

    Raises:
        ReadError: the file is not a photograph that can be read.
        OptionError: the photo has another size, or the array is not a picture.
    """
    if isinstance(source, np.ndarray):
        photograph = Photograph(_checked(source))
    else:
        photograph = _from_file(Path(source), size)
    if size is not None and photograph.size != tuple(size):
        width, height = photograph.size
        raise OptionError(
            f"{photograph.name or 'the photo'} has {width}x{height} pixels, but the picks were "
            f"made at {size[0]}x{size[1]}",
            hint="give the photo that the points were picked in, at its full size",
        )
    return photograph


def photos_of(observations: Observations, given: object = None) -> list[PhotoSource | None]:
    """Where each photo of observations is; None for photos without lines.

    Args:
        observations: The picks.
        given: What the user gives: one photo, a sequence of one for each, or None for those that
            lie beside the file of points under the name it gives.

    Raises:
        OptionError: a photo is missing, or there are several and one is given.
    """
    with_lines = {line.photo for line in observations.lines}
    if isinstance(given, (str, Path, np.ndarray)):
        if len(with_lines) > 1:
            raise OptionError(
                f"one photo is given, but there are lines in {len(with_lines)}",
                hint="leave it out where the photos lie beside the points, or select one with "
                "--image N",
            )
        return [given if index in with_lines else None for index in range(len(observations.photos))]
    if isinstance(given, Sequence):
        if len(given) != len(observations.photos):
            raise OptionError(
                f"{len(given)} photos are given for {len(observations.photos)}",
                hint="give one photo for each of the observations' photos",
            )
        return list(given)
    return [
        _beside(observations, photo) if index in with_lines else None
        for index, photo in enumerate(observations.photos)
    ]


def _beside(observations: Observations, photo: Photo) -> Path:
    name = photo.name.replace("\\", "/").rpartition("/")[2]
    for origin in observations.origins:
        path = Path(origin.path).parent / name
        if name and path.is_file():
            return path
    raise OptionError(
        f"{observations.named}the photo {name or 'of the picks'} is not beside the points",
        hint="give it with --photo FILE",
    )


def _checked(pixels: NDArray[Any]) -> NDArray[Any]:
    if (
        pixels.ndim not in _SHAPES
        or pixels.shape[2:] not in ((), (1,), (3,), (4,))
        or pixels.dtype.name not in ("uint8", "uint16")
        or not pixels.size
    ):
        raise OptionError(
            f"an array of shape {pixels.shape} and type {pixels.dtype} is not a picture",
            hint="give rows, columns and at most 4 channels as uint8 or uint16",
        )
    return pixels


def _from_file(path: Path, size: tuple[int, int] | None) -> Photograph:
    facts = read_photo(path)
    picture = decode(read_bytes(path), path)
    if picture.inks:
        raise ReadError(
            "the photo stores printing inks", path=path, hint="save it with red, green and blue"
        )
    pixels = picture.pixels
    if picture.alpha:
        pixels = pixels[..., :-1] if pixels.shape[2] == 4 else pixels[..., 0]
    as_stored = facts.turned and size is not None and size == facts.stored_size != facts.size
    turned_already = facts.turned and pixels.shape[1::-1] == facts.size != facts.stored_size
    if not as_stored and not turned_already:
        pixels = turned_upright(pixels, facts.orientation)
    halved = picture.storage.format == "JPEG" and picture.storage.sampling != 0
    return Photograph(pixels, path.name, facts, halved, tuple(history_notes(facts)))

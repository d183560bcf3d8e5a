"""A photograph to look at: its pixels turned upright, grey or blue, green, red."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

from plumbline.files import read_bytes
from plumbline.observations import Photo
from plumbline.photos.exif import PhotoFacts, read_photo
from plumbline.photos.files.picture import Picture, Pixels, decode
from plumbline.photos.identity import Identity, identity_of
from plumbline.photos.turning import turned_upright


@dataclass(frozen=True, eq=False)
class Upright:
    """A photograph as a viewer shows it.

    Attributes:
        pixels: 8 or 16 bits, grey (h, w) or blue, green, red (h, w, 3).
        facts: What the file says of itself.
        identity: Which photograph it is: checksum, moment and camera.
    """

    pixels: Pixels
    facts: PhotoFacts
    identity: Identity


def read_upright(path: str | Path) -> Upright:
    """Read a photograph and turn it as EXIF says.

    Raises:
        ReadError: the file is missing, damaged or not a picture.
    """
    facts = read_photo(path)
    pixels = turned_upright(_plain(decode(read_bytes(path), path)), facts.orientation)
    return Upright(pixels, facts, identity_of(path))


def photo_of(photo: Upright) -> Photo:
    """The photograph as observations have it."""
    height, width = photo.pixels.shape[:2]
    which = photo.identity
    return Photo(
        (width, height),
        photo.facts.name,
        sha256=which.sha256,
        taken=which.taken,
        serial=which.serial,
    )


def _plain(picture: Picture) -> Pixels:
    """Without alpha; inks as the grey they print."""
    if picture.inks:
        return np.asarray(Image.fromarray(picture.pixels, "CMYK").convert("L"))
    if not picture.alpha:
        return picture.pixels
    colours = picture.pixels[..., :-1]
    return colours[..., 0] if colours.shape[2] == 1 else colours

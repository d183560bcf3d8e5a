"""TIFF files of every kind, read by tifffile, which is loaded for them only.

Pixels come as they are stored; the orientation tag stays what it was. Kinds that cannot be
corrected faithfully are refused by name.
"""

from __future__ import annotations

import logging
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import tifffile
from numpy.typing import NDArray

from plumbline.errors import ReadError
from plumbline.photos.files.tiff_segments import decoded_segments
from plumbline.photos.files.tiff_tags import DAMAGE
from plumbline.photos.kinds import FLOATS, FLOATS_HINT, RAW_HINT
from plumbline.wording import count

Pixels = NDArray[Any]

_DNG_VERSION, _EXTRA_SAMPLES = 50706, 338
_RAW_PHOTOMETRICS = (32803, 34892)
"""A colour filter array and linear raw (TIFF/EP, DNG)."""
_COLOURS = {0: 1, 1: 1, 2: 3, 3: 1, 5: 4}
_UNREADABLE = {
    4: "a transparency mask",
    6: "YCbCr without JPEG compression",
    8: "CIE L*a*b* colours",
    9: "ICC L*a*b* colours",
    10: "ITU L*a*b* colours",
    32844: "LogL values",
    32845: "LogLuv colours",
}
_JPEG, _YCBCR, _RGB, _PALETTE, _SEPARATED = 7, 6, 2, 3, 5
_ASSOCIATED, _STRAIGHT = 1, 2
_HINT = "save it again as an RGB TIFF with 8 or 16 bits a channel"


@dataclass(frozen=True)
class Decoded:
    """Pixels of a TIFF file.

    Attributes:
        pixels: As `Picture` has them.
        inks: Whether they are four inks.
        notes: What was left out, in plain sentences.
    """

    pixels: Pixels
    inks: bool
    notes: tuple[str, ...]


@contextmanager
def opened(source: str | Path | BinaryIO, path: str | Path) -> Generator[tifffile.TiffPage]:
    """The page of a TIFF file that holds the photograph.

    Raises:
        ReadError: it is a raw file, or no photograph is in it.
        Exception: one of `DAMAGE`, where it makes no sense.
    """
    logger = logging.getLogger("tifffile")
    if not logger.handlers:
        logger.addHandler(logging.NullHandler())  # what it logs must not reach the user
    with tifffile.TiffFile(source) as file:
        if not len(file.pages):
            raise ValueError("it holds no picture")
        _refuse_raw(file, path)
        for page in file.pages:
            if isinstance(page, tifffile.TiffPage) and not int(page.subfiletype) & 0b101:
                yield page
                return
        yield file.pages.first


def pictures(page: tifffile.TiffPage) -> int:
    """How many pictures of full size the page's file holds."""
    kinds = [int(getattr(each, "subfiletype", 1)) for each in page.parent.pages]
    return sum(not kind & 0b101 for kind in kinds)


def size_of(page: tifffile.TiffPage) -> tuple[int, int]:
    """Width and height as stored."""
    return int(page.imagewidth), int(page.imagelength)


def read_pixels(page: tifffile.TiffPage, path: str | Path) -> Decoded:
    """The pixels of a page, blue before green before red.

    Raises:
        ReadError: its kind of pixels cannot be corrected faithfully.
        Exception: one of `DAMAGE`.
    """
    compression = int(page.compression)
    photometric = int(page.photometric)
    if compression == _JPEG and photometric == _YCBCR:
        photometric = _RGB  # the decoder turns it into RGB
    bits = _checked_bits(page, photometric, path)
    colours = _COLOURS[photometric]
    extra = [int(each) for each in page.extrasamples]
    if _EXTRA_SAMPLES not in page.tags and int(page.samplesperpixel) == colours + 1:
        extra = [_STRAIGHT]  # OpenCV and others write alpha without saying so
    alpha = extra[0] if extra and photometric != _SEPARATED else 0
    kept = colours + (1 if alpha in (_ASSOCIATED, _STRAIGHT) else 0)
    stored = max(int(page.samplesperpixel), colours)
    order = [2, 1, 0, 3][:kept] if photometric == _RGB else list(range(kept))
    pixels = _scaled(decoded_segments(page, order, path), bits)
    if photometric == 0:
        full = np.iinfo(pixels.dtype).max
        pixels[..., 0] = full - pixels[..., 0]
    if photometric == _PALETTE:
        pixels = _coloured(pixels, page, bits)
    if alpha == _ASSOCIATED:
        pixels = _straight(pixels)
    notes: list[str] = []
    if stored > kept:
        n = count(stored - kept, "further channel")
        notes.append(f"{n} of the TIFF, neither colour nor transparency, left out")
    if pixels.shape[2] == 1:
        pixels = pixels[..., 0]
    return Decoded(np.ascontiguousarray(pixels), photometric == _SEPARATED, tuple(notes))


def _refuse_raw(file: tifffile.TiffFile, path: str | Path) -> None:
    first = file.pages.first
    if _DNG_VERSION in first.tags:
        raise ReadError("this is a raw file (DNG)", path=path, hint=RAW_HINT)
    below: list[Any] = []
    if first.subifds:
        try:
            below = list(first.pages or ())
        except DAMAGE:
            below = []
    for page in (first, *below):
        tag = page.tags.get(262) if hasattr(page, "tags") else None
        if tag is not None and tag.value in _RAW_PHOTOMETRICS:
            raise ReadError("this is a raw file of a camera", path=path, hint=RAW_HINT)


def _checked_bits(page: tifffile.TiffPage, photometric: int, path: str | Path) -> int:
    """Bits of a sample, where the pixels are of a kind that can be corrected."""
    bits: Any = page.bitspersample
    if page.dtype is not None and np.dtype(page.dtype).kind in "fc":
        raise ReadError(FLOATS, path=path, hint=FLOATS_HINT)
    if page.dtype is not None and np.dtype(page.dtype).kind == "i":
        raise ReadError("the TIFF holds signed integers", path=path, hint=_HINT)
    if page.dtype is None or not isinstance(bits, int) or bits > 16:
        raise ReadError(f"a TIFF with {bits} bits a sample is not supported", path=path, hint=_HINT)
    if photometric not in _COLOURS:
        name = _UNREADABLE.get(photometric, f"pixels of kind {photometric}")
        raise ReadError(f"a TIFF with {name} is not supported", path=path, hint=_HINT)
    if photometric == _SEPARATED and int(page.samplesperpixel) < 4:
        raise ReadError("a TIFF with fewer than four inks is not supported", path=path, hint=_HINT)
    if int(page.imagedepth) != 1:
        raise ReadError("a TIFF of a volume is not supported", path=path, hint=_HINT)
    return bits


def _scaled(samples: Pixels, bits: int) -> Pixels:
    """Samples spread over the whole of 8 or 16 bits."""
    if bits in (8, 16):
        return samples
    full = 2**bits - 1
    if bits < 8:
        return (samples.astype(np.uint16) * 255 // full).astype(np.uint8)
    return ((samples.astype(np.uint32) * 65535 + full // 2) // full).astype(np.uint16)


def _coloured(indices: Pixels, page: tifffile.TiffPage, bits: int) -> Pixels:
    """The colours of a palette, 16 bits each in the file."""
    table = np.asarray(page.colormap)
    if table.max(initial=0) > 255:
        table = table >> 8
    places = indices[..., 0] if bits == 8 else (indices[..., 0].astype(int) * (2**bits - 1)) // 255
    colours = table[::-1, places].astype(np.uint8)
    return np.concatenate((np.moveaxis(colours, 0, -1), indices[..., 1:]), axis=-1)


def _straight(pixels: Pixels) -> Pixels:
    """Colours that were multiplied by alpha, divided by it again."""
    full = float(np.iinfo(pixels.dtype).max)
    alpha = pixels[..., -1:].astype(np.float64)
    colours = pixels[..., :-1] * (full / np.maximum(alpha, 1))
    colours = np.clip(np.rint(colours), 0, full).astype(pixels.dtype)
    return np.concatenate((colours, pixels[..., -1:]), axis=-1)

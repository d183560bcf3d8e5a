"""TIFF files of every kind, read by tifffile, which is loaded for them only.

Pixels come as they are stored; the orientation tag stays what it was. Kinds that cannot be
corrected faithfully are refused by name.
"""

from __future__ import annotations

import logging
import struct
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import tifffile
from numpy.typing import NDArray

from plumbline.errors import ReadError
from plumbline.photos.files import ifd
from plumbline.photos.files.metadata import Metadata
from plumbline.photos.files.photoshop import iptc_of
from plumbline.photos.files.tiff_segments import decoded_segments
from plumbline.photos.kinds import FLOATS, FLOATS_HINT, RAW_HINT
from plumbline.wording import count

Pixels = NDArray[Any]

DAMAGE = (
    *(ValueError, struct.error, IndexError, KeyError, TypeError, OSError, EOFError),
    *(OverflowError, AttributeError, RuntimeError, NotImplementedError),
)
"""What tifffile and the decoders raise for files that make no sense."""

XMP, IPTC, PHOTOSHOP, ICC, LAYERS = 700, 33723, 34377, 34675, 37724
LAYOUT = frozenset(
    (
        *(*range(254, 260), 262, 263, 266, 273, 277, 278, 279, 284, *range(290, 294), 301),
        *(*range(317, 321), *range(322, 326), 330, *range(338, 342), 347),
        *(*range(512, 522), 529, 530, 531, 532, LAYERS),
    )
)
"""Fields that describe the pixels as stored, and Photoshop's uncorrected layers."""

_DNG_VERSION, _EXTRA_SAMPLES = 50706, 338
_LONG8_KINDS = (16, 17, 18)
_RAW_PHOTOMETRICS = (32803, 34892)
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


def _dpi(page: tifffile.TiffPage) -> tuple[float, float] | None:
    """Pixels an inch across and down."""
    try:
        (across, down), unit = page.resolution, int(page.resolutionunit)
    except DAMAGE:
        return None
    per_inch = {2: 1.0, 3: 2.54}.get(unit)
    if per_inch is None or min(across, down) <= 0:
        return None
    return float(across * per_inch), float(down * per_inch)


def read_metadata(page: tifffile.TiffPage) -> tuple[Metadata, list[str]]:
    """The metadata of a page, its EXIF as a block of its own, and what was left out."""
    every = _fields(page, maker_notes=False)
    data = {field.tag: field.data for field in every}
    apart = (XMP, IPTC, PHOTOSHOP, ICC)
    fields = [field for field in every if field.tag not in (*LAYOUT, *apart)]
    resources = data.get(PHOTOSHOP, b"")
    metadata = Metadata(
        exif=ifd.new_block(fields),
        icc=data.get(ICC, b""),
        xmp=data.get(XMP, b"").rstrip(b"\0"),
        iptc=data.get(IPTC, b"") or iptc_of(resources),
        photoshop=resources,
        dpi=_dpi(page),
    )
    notes = ["Photoshop's layers, which are not corrected, left out"] if LAYERS in data else []
    return metadata, notes


def exif_block(page: tifffile.TiffPage) -> bytes:
    """The EXIF of a page as a block of its own, with maker notes, to be looked at only."""
    fields = _fields(page, maker_notes=True)
    return ifd.new_block(f for f in fields if f.tag not in (*LAYOUT, XMP, PHOTOSHOP, ICC))


def xmp(page: tifffile.TiffPage) -> bytes:
    """The XMP packet of a page; may be empty."""
    tag = page.tags.get(XMP)
    field = None if tag is None else _field(page.parent, tag, 0)
    return b"" if field is None else field.data.rstrip(b"\0")


def has_maker_notes(page: tifffile.TiffPage) -> bool:
    """Whether the page has maker notes, which cannot be moved to another place."""
    fields = _fields(page, maker_notes=True)
    return any(child.tag == ifd.MAKER_NOTES for field in fields for child in field.children)


def _fields(page: tifffile.TiffPage, *, maker_notes: bool) -> list[ifd.Field]:
    file: Any = page.parent
    fields = [field for tag in page.tags if (field := _field(file, tag, 0)) is not None]
    fields = ifd.in_order(fields, file.byteorder)
    return fields if maker_notes else ifd.movable(fields)


def _field(file: Any, tag: Any, deep: int) -> ifd.Field | None:
    """A tag with its values as bytes; None where it is broken."""
    kind, number = int(tag.dtype), int(tag.count)
    if tag.code in ifd.SUB_DIRECTORIES:
        return ifd.Field(tag.code, ifd.LONG, bytes(4), tuple(_below(file, tag, deep)))
    if (tag.code in LAYOUT and tag.code != LAYERS) or kind not in {*ifd.SIZES, *_LONG8_KINDS}:
        return None
    size = ifd.SIZES.get(kind, 8) * number
    data = _bytes_at(file, tag.valueoffset, size)
    if len(data) < size:
        return None
    if kind not in ifd.SIZES:
        return _short_integers(tag.code, data, file.byteorder)
    if tag.code in (IPTC, PHOTOSHOP, XMP, ICC):
        kind = ifd.UNDEFINED  # bytes, though many programs call IPTC's long integers
    return ifd.Field(tag.code, kind, data)


def _short_integers(code: int, data: bytes, order: str) -> ifd.Field | None:
    """BigTIFF's integers of 8 bytes in the 4 that EXIF has; None where they do not fit."""
    values = struct.unpack(f"{order}{len(data) // 8}Q", data)
    if max(values, default=0) >= 2**32:
        return None
    return ifd.Field(code, ifd.LONG, struct.pack(f"{order}{len(values)}I", *values))


def _below(file: Any, tag: Any, deep: int) -> Iterator[ifd.Field]:
    """The fields of the directory that a tag points to."""
    wide = file.tiff.offsetsize == 8
    order, pointer = file.byteorder, "Q" if wide else "I"
    raw = _bytes_at(file, tag.offset + (12 if wide else 8), 8 if wide else 4)
    (at,) = struct.unpack(order + pointer, raw)
    head = _bytes_at(file, at, 8 if wide else 2)
    (number,) = struct.unpack(order + ("Q" if wide else "H"), head)
    if number > ifd.MOST_FIELDS or deep > 2:
        return
    for index in range(number):
        try:
            place = at + len(head) + index * (20 if wide else 12)
            below = tifffile.TiffTag.fromfile(file, offset=place, validate=False)
        except (*DAMAGE, tifffile.TiffFileError):
            continue
        field = _field(file, below, deep + 1)
        if field is not None:
            yield field


def _bytes_at(file: Any, at: int, size: int) -> bytes:
    file.filehandle.seek(at)
    return file.filehandle.read(size)

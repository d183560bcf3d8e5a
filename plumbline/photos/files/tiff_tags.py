"""Tags of a TIFF page as fields whose values are bytes, and the metadata among them.

tifffile finds them, in BigTIFF too; the values' bytes are taken as they stand.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import Any

import tifffile

from plumbline.photos.files import ifd
from plumbline.photos.files.metadata import Metadata
from plumbline.photos.files.photoshop import iptc_of

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

_LONG8_KINDS = (16, 17, 18)
"""BigTIFF's integers of 8 bytes."""


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

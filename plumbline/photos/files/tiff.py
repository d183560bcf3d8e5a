"""The tagged structure of TIFF, which EXIF shares: directories of fields at any offset.

Reading raises ValueError or struct.error where the structure makes no sense.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from plumbline.photos.files.metadata import Metadata

MAKER_NOTES = 0x927C
SOFTWARE, NEXT_IMAGE_OFFSET, NEXT_IMAGE_BYTES = 0x0131, 0x0201, 0x0202
COMPRESSION, EXTRA_SAMPLES = 259, 338
_XMP, _ICC, _X_DPI, _Y_DPI, _UNIT, _INCH = 700, 34675, 282, 283, 296, 2
_SUB_DIRECTORIES = (34665, 34853, 40965)
_ASCII, _SHORT, _LONG, _RATIONAL, _UNDEFINED, _BYTE = 2, 3, 4, 5, 7, 1
_STRAIGHT_ALPHA = 2

_SIZES = {1: 1, 2: 1, 3: 2, 4: 4, 5: 8, 6: 1, 7: 1, 8: 2, 9: 4, 10: 8, 11: 4, 12: 8, 13: 4}
_SWAPPED_BY = {3: 2, 4: 4, 5: 4, 8: 2, 9: 4, 10: 4, 11: 4, 12: 8, 13: 4}

_LAYOUT = frozenset(
    (
        *(*range(254, 260), 262, 263, 266, 273, 277, 278, 279, 284, *range(290, 294), 301),
        *(*range(317, 321), *range(322, 326), 330, *range(338, 342), 347),
        *(*range(512, 522), 529, 530, 531, 532, 37724),
    )
)
"""Fields that describe the pixels as stored, and Photoshop's uncorrected layers."""

_MOST_FIELDS = 4096
_DEEPEST = 3


@dataclass(frozen=True)
class Field:
    """One entry of a directory.

    Attributes:
        tag: What it is.
        kind: Type of its values.
        data: The values' bytes, in the block's byte order.
        children: The fields of the directory it points to.
    """

    tag: int
    kind: int
    data: bytes
    children: tuple[Field, ...] = ()

    @property
    def count(self) -> int:
        """Number of values."""
        return len(self.data) // _SIZES[self.kind]


def byte_order(block: bytes) -> str:
    """`<` or `>`, as struct has it."""
    order = {b"II*\0": "<", b"MM\0*": ">"}.get(block[:4])
    if order is None:
        raise ValueError("this is no TIFF structure")
    return order


def first_directory(block: bytes) -> int:
    """Where the first directory begins."""
    return int(struct.unpack_from(byte_order(block) + "I", block, 4)[0])


def read_directory(block: bytes, at: int, deep: int = 0) -> tuple[list[Field], int]:
    """The fields of the directory at an offset, and the offset of the next one or 0."""
    order = byte_order(block)
    (count,) = struct.unpack_from(order + "H", block, at)
    if count > _MOST_FIELDS or deep > _DEEPEST:
        raise ValueError("the directory is too large")
    fields: list[Field] = []
    for index in range(count):
        entry = at + 2 + 12 * index
        tag, kind, values = struct.unpack_from(order + "HHI", block, entry)
        if kind not in _SIZES:
            continue
        size = values * _SIZES[kind]
        start = entry + 8 if size <= 4 else struct.unpack_from(order + "I", block, entry + 8)[0]
        data = block[start : start + size]
        if len(data) < size:
            raise ValueError("a field ends beyond the file")
        children: tuple[Field, ...] = ()
        if tag in _SUB_DIRECTORIES and size == 4:
            (below,) = struct.unpack(order + "I", data)
            children = tuple(read_directory(block, below, deep + 1)[0])
        fields.append(Field(tag, kind, data, children))
    (following,) = struct.unpack_from(order + "I", block, at + 2 + 12 * count)
    return fields, int(following)


def directory_bytes(fields: Iterable[Field], at: int, order: str, following: int = 0) -> bytes:
    """A directory for the offset `at`, its values and sub-directories behind it.

    Sub-directories that hold nothing are left out.
    """
    held = (field for field in fields if field.children or field.tag not in _SUB_DIRECTORIES)
    ordered = sorted(held, key=lambda field: field.tag)
    end = at + 2 + 12 * len(ordered) + 4
    table, heap = struct.pack(order + "H", len(ordered)), b""
    for field in ordered:
        place = end + len(heap)
        if field.children:
            value = struct.pack(order + "I", place)
            heap += _even(directory_bytes(field.children, place, order))
        elif len(field.data) <= 4:
            value = field.data.ljust(4, b"\0")
        else:
            value = struct.pack(order + "I", place)
            heap += _even(field.data)
        table += struct.pack(order + "HHI", field.tag, field.kind, field.count) + value
    return table + struct.pack(order + "I", following) + heap


def new_block(fields: Iterable[Field]) -> bytes:
    """A block of its own with one directory, little-endian."""
    return b"II*\0" + struct.pack("<I", 8) + directory_bytes(fields, 8, "<")


def with_software(fields: Sequence[Field], note: str) -> list[Field]:
    """The fields with a note appended to Software."""
    old = next((field.data for field in fields if field.tag == SOFTWARE), b"")
    parts = [old.split(b"\0")[0].strip(), note.encode("ascii", "replace")]
    text = b"; ".join(part for part in parts if part) + b"\0"
    return [*(f for f in fields if f.tag != SOFTWARE), Field(SOFTWARE, _ASCII, text)]


def read_metadata(data: bytes) -> Metadata:
    """The metadata of a TIFF file, its EXIF as a block of its own."""
    fields = _in_order(_described(data), byte_order(data), "<")
    icc = next((field.data for field in fields if field.tag == _ICC), b"")
    xmp = next((field.data for field in fields if field.tag == _XMP), b"")
    return Metadata(new_block(f for f in fields if f.tag not in (_ICC, _XMP)), icc, xmp)


def with_metadata(data: bytes, metadata: Metadata, note: str, *, alpha: bool) -> bytes:
    """A little-endian TIFF file with metadata added to its first directory."""
    layout = [f for f in read_directory(data, first_directory(data))[0] if f.tag in _LAYOUT]
    if alpha and not any(field.tag == EXTRA_SAMPLES for field in layout):
        layout.append(Field(EXTRA_SAMPLES, _SHORT, struct.pack("<H", _STRAIGHT_ALPHA)))
    block = metadata.exif
    fields = _in_order(_described(block), byte_order(block), "<") if block else []
    fields = with_software(fields, note)
    if metadata.icc:
        fields.append(Field(_ICC, _UNDEFINED, metadata.icc))
    if metadata.xmp:
        fields.append(Field(_XMP, _BYTE, metadata.xmp))
    if metadata.dpi and not any(field.tag == _X_DPI for field in fields):
        across, down = (struct.pack("<II", round(value * 1000), 1000) for value in metadata.dpi)
        fields += [Field(_X_DPI, _RATIONAL, across), Field(_Y_DPI, _RATIONAL, down)]
        fields.append(Field(_UNIT, _SHORT, struct.pack("<H", _INCH)))
    data = _even(data)
    return (
        data[:4]
        + struct.pack("<I", len(data))
        + data[8:]
        + directory_bytes([*layout, *fields], len(data), "<")
    )


def with_fields(data: bytes, fields: Iterable[Field]) -> bytes:
    """A little-endian TIFF file with fields added to its first directory."""
    held, _ = read_directory(data, first_directory(data))
    data = _even(data)
    return (
        data[:4]
        + struct.pack("<I", len(data))
        + data[8:]
        + directory_bytes([*held, *fields], len(data), "<")
    )


def _described(block: bytes) -> list[Field]:
    """The first directory's fields but for those that describe the stored pixels.

    Maker notes are left out too: they refer to places in the block, and would be garbage at
    others.
    """
    fields, _ = read_directory(block, first_directory(block))
    return [
        replace(field, children=tuple(c for c in field.children if c.tag != MAKER_NOTES))
        for field in fields
        if field.tag not in _LAYOUT
    ]


def has_maker_notes(block: bytes) -> bool:
    """Whether a TIFF file or an EXIF block holds maker notes, which no other TIFF can take."""
    fields, _ = read_directory(block, first_directory(block))
    return any(child.tag == MAKER_NOTES for field in fields for child in field.children)


def _in_order(fields: Iterable[Field], order: str, wanted: str) -> list[Field]:
    """The fields with their values in another byte order."""
    if order == wanted:
        return list(fields)
    turned: list[Field] = []
    for field in fields:
        size = _SWAPPED_BY.get(field.kind, 1)
        parts = (field.data[i : i + size][::-1] for i in range(0, len(field.data), size))
        children = tuple(_in_order(field.children, order, wanted))
        turned.append(replace(field, data=b"".join(parts), children=children))
    return turned


def _even(data: bytes) -> bytes:
    return data + b"\0" * (len(data) % 2)

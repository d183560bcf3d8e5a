"""Directories of tagged fields, the structure that EXIF shares with TIFF.

EXIF blocks are read and written here; TIFF files are read by tifffile, and only the directory
of a written one is written here, because no library writes EXIF's directories into a TIFF file.
Reading raises ValueError or struct.error where the structure makes no sense.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from plumbline.wording import in_ascii

MAKER_NOTES = 0x927C
DESCRIPTION, SOFTWARE, NEXT_IMAGE_OFFSET, NEXT_IMAGE_BYTES = 0x010E, 0x0131, 0x0201, 0x0202
SUB_DIRECTORIES = (34665, 34853, 40965)
ASCII, SHORT, LONG, RATIONAL, UNDEFINED, BYTE = 2, 3, 4, 5, 7, 1
"""Tags and types of TIFF 6.0 and EXIF (CIPA DC-008)."""

SIZES = {1: 1, 2: 1, 3: 2, 4: 4, 5: 8, 6: 1, 7: 1, 8: 2, 9: 4, 10: 8, 11: 4, 12: 8, 13: 4}
"""Bytes of one value, by type; entries of other types are broken."""

_SWAPPED_BY = {3: 2, 4: 4, 5: 4, 8: 2, 9: 4, 10: 4, 11: 4, 12: 8, 13: 4}

MOST_FIELDS = 4096
"""Chosen because cameras write fewer than 200; more is damage or an attack."""

_DEEPEST = 3  # IFD0, EXIF, interoperability


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
        return len(self.data) // SIZES[self.kind]


def byte_order(block: bytes) -> str:
    """`<` or `>`, as struct has it."""
    order = {b"II*\0": "<", b"MM\0*": ">"}.get(block[:4])
    if order is None:
        raise ValueError("the EXIF block does not begin like one")
    return order


def first_directory(block: bytes) -> int:
    """Where the first directory begins."""
    return int(struct.unpack_from(byte_order(block) + "I", block, 4)[0])


def entries(block: bytes, at: int) -> Iterator[bytes]:
    """The 12 bytes of each entry of the directory at an offset; broken ones are left out."""
    order = byte_order(block)
    (count,) = struct.unpack_from(order + "H", block, at)
    if count > MOST_FIELDS or at + 2 + 12 * count > len(block):
        raise ValueError("the directory is too large")
    for start in range(at + 2, at + 2 + 12 * count, 12):
        if struct.unpack_from(order + "H", block, start + 2)[0] in SIZES:
            yield block[start : start + 12]


def read_directory(block: bytes, at: int, deep: int = 0) -> tuple[list[Field], int]:
    """The fields of the directory at an offset, and the offset of the next one or 0.

    Entries whose type is unknown or whose values end beyond the block are left out.
    """
    order = byte_order(block)
    if deep > _DEEPEST:
        raise ValueError("the directories are nested too deeply")
    fields: list[Field] = []
    for entry in entries(block, at):
        tag, kind, values = struct.unpack_from(order + "HHI", entry)
        size = values * SIZES[kind]
        (start,) = struct.unpack_from(order + "I", entry, 8)
        data = entry[8 : 8 + size] if size <= 4 else block[start : start + size]
        if len(data) < size:
            continue
        children: tuple[Field, ...] = ()
        if tag in SUB_DIRECTORIES and size == 4:
            children = tuple(read_directory(block, start, deep + 1)[0])
        fields.append(Field(tag, kind, data, children))
    (count,) = struct.unpack_from(order + "H", block, at)
    link = at + 2 + 12 * count
    following = block[link : link + 4].ljust(4, b"\0")  # some programs leave the link out
    return fields, int(struct.unpack(order + "I", following)[0])


def directory_bytes(fields: Iterable[Field], at: int, order: str, following: int = 0) -> bytes:
    """A directory for the offset `at`, its values and sub-directories behind it.

    Sub-directories that hold nothing are left out.
    """
    held = (field for field in fields if field.children or field.tag not in SUB_DIRECTORIES)
    ordered = sorted(held, key=lambda field: field.tag)
    end = at + 2 + 12 * len(ordered) + 4
    table, heap = struct.pack(order + "H", len(ordered)), b""
    for field in ordered:
        place = end + len(heap)
        if field.children:
            value = struct.pack(order + "I", place)
            heap += even(directory_bytes(field.children, place, order))
        elif len(field.data) <= 4:
            value = field.data.ljust(4, b"\0")
        else:
            value = struct.pack(order + "I", place)
            heap += even(field.data)
        table += struct.pack(order + "HHI", field.tag, field.kind, field.count) + value
    return table + struct.pack(order + "I", following) + heap


def new_block(fields: Iterable[Field]) -> bytes:
    """A block of its own with one directory, little-endian."""
    return b"II*\0" + struct.pack("<I", 8) + directory_bytes(fields, 8, "<")


def block_fields(block: bytes) -> list[Field]:
    """The fields of a block's first directory, little-endian and without maker notes.

    Maker notes refer to places in the block, and would be garbage at others.
    """
    fields, _ = read_directory(block, first_directory(block))
    return movable(in_order(fields, byte_order(block)))


def movable(fields: Iterable[Field]) -> list[Field]:
    """The fields without maker notes."""
    return [
        replace(field, children=tuple(c for c in field.children if c.tag != MAKER_NOTES))
        for field in fields
    ]


def has_maker_notes(block: bytes) -> bool:
    """Whether an EXIF block holds maker notes, which no other structure can take."""
    fields, _ = read_directory(block, first_directory(block))
    return any(child.tag == MAKER_NOTES for field in fields for child in field.children)


def with_software(fields: Sequence[Field], note: str) -> list[Field]:
    """The fields with a note appended to Software."""
    old = next((field.data for field in fields if field.tag == SOFTWARE), b"")
    parts = [old.split(b"\0")[0].strip(), in_ascii(note).encode()]
    text = b"; ".join(part for part in parts if part) + b"\0"
    return [*(f for f in fields if f.tag != SOFTWARE), Field(SOFTWARE, ASCII, text)]


def in_order(fields: Iterable[Field], order: str) -> list[Field]:
    """Fields of a byte order with their values in little-endian order."""
    if order == "<":
        return list(fields)
    turned: list[Field] = []
    for field in fields:
        size = _SWAPPED_BY.get(field.kind, 1)
        parts = (field.data[i : i + size][::-1] for i in range(0, len(field.data), size))
        children = tuple(in_order(field.children, order))
        turned.append(replace(field, data=b"".join(parts), children=children))
    return turned


def even(data: bytes) -> bytes:
    """The bytes filled up to an even number, on which values begin."""
    return data + b"\0" * (len(data) % 2)

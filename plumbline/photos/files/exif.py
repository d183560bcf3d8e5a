"""Notes and thumbnails in an EXIF block, changed so that nothing else in it moves.

Maker notes refer to places in the block, so the block is only added to: a new first directory
goes to its end, or where a dropped thumbnail was, and a refreshed thumbnail takes the place of
the old one.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from plumbline.photos.files.ifd import (
    LONG,
    MOST_FIELDS,
    NEXT_IMAGE_BYTES,
    NEXT_IMAGE_OFFSET,
    SHORT,
    SIZES,
    SOFTWARE,
    Field,
    block_fields,
    byte_order,
    entries,
    even,
    first_directory,
    new_block,
    read_directory,
    with_software,
)

Refresh = Callable[[bytes], bytes | None]

_ORIENTATION, _EXIF = 0x0112, 34665
_WIDTHS, _HEIGHTS = (0x0100, 0xA002), (0x0101, 0xA003)
"""ImageWidth and PixelXDimension, ImageLength and PixelYDimension."""

_LARGE_FIELD = 2048
"""Chosen because only maker notes, previews and private blocks are longer."""


@dataclass(frozen=True)
class Annotated:
    """An EXIF block with a note.

    Attributes:
        block: The block.
        noted: Whether the note found room.
        broken: How many broken entries of the first directory were left out.
    """

    block: bytes
    noted: bool = True
    broken: int = 0


def annotated(block: bytes, note: str, refresh: Refresh, most: int | None = None) -> Annotated:
    """The block with a note in Software and the thumbnail refreshed, or dropped.

    Args:
        block: The EXIF block; may be empty.
        note: What to say.
        refresh: Makes a new thumbnail, no longer than the old one, or None to drop it.
        most: Bytes that the block may have; without room the thumbnail goes, then the note.

    Raises:
        ValueError, struct.error: the block makes no sense.
    """
    if not block:
        return Annotated(new_block(with_software([], note)))
    with_thumbnail, following, _ = _with_thumbnail(block, refresh)
    noted = _with_note(even(with_thumbnail), note, following, (0, 0))
    if most is None or len(noted.block) <= most:
        return noted
    bare, _, hole = _with_thumbnail(block, lambda _: None)
    if hole[1] and sum(hole) >= len(bare) - 1:
        bare, hole = bare[: hole[0]], (0, 0)
    noted = _with_note(even(bare), note, 0, hole)
    if len(noted.block) <= most:
        return noted
    return Annotated(with_thumbnail if len(with_thumbnail) <= most else bare, noted=False)


def of_another_size(block: bytes, size: tuple[int, int]) -> bytes:
    """The block for an upright picture of another size: what it says of both is replaced.

    Args:
        block: The EXIF block; may be empty.
        size: Width and height of the picture.

    Raises:
        ValueError, struct.error: the block makes no sense.
    """
    if not block:
        return block
    order, changed = byte_order(block), bytearray(block)
    values = dict(zip(_WIDTHS + _HEIGHTS, (size[0],) * 2 + (size[1],) * 2, strict=True))
    for at in _directories(block):
        for place, (tag, kind, count) in _places(block, at):
            value = 1 if tag == _ORIENTATION else values.get(tag)
            if value is not None and count == 1 and kind in (SHORT, LONG):
                struct.pack_into(order + ("H" if kind == SHORT else "I"), changed, place, value)
    return bytes(changed)


def _directories(block: bytes) -> list[int]:
    """Where the first directory and EXIF's own begin."""
    order, first = byte_order(block), first_directory(block)
    found = [first]
    for place, (tag, _, _) in _places(block, first):
        if tag == _EXIF:
            found += struct.unpack_from(order + "I", block, place)
    return found


def _places(block: bytes, at: int) -> Iterator[tuple[int, tuple[int, int, int]]]:
    """Where the value of each entry of a directory lies, and its tag, kind and count."""
    order = byte_order(block)
    (count,) = struct.unpack_from(order + "H", block, at)
    for start in range(at + 2, at + 2 + 12 * min(count, MOST_FIELDS), 12):
        tag, kind, values = struct.unpack_from(order + "HHI", block, start)
        yield start + 8, (tag, kind, values)


def shortened(block: bytes) -> tuple[bytes, int]:
    """The block without maker notes, thumbnail and long fields, and how many fields that were."""
    fields = block_fields(block)
    left = 0

    def short(fields: tuple[Field, ...]) -> tuple[Field, ...]:
        nonlocal left
        kept: list[Field] = []
        for field in fields:
            if len(field.data) > _LARGE_FIELD:
                left += 1
            else:
                kept.append(Field(field.tag, field.kind, field.data, short(field.children)))
        return tuple(kept)

    return new_block(short(tuple(fields))), left


def _with_note(block: bytes, note: str, following: int, hole: tuple[int, int]) -> Annotated:
    """The block with a new first directory in a hole that is large enough, else at its end."""
    order, at = byte_order(block), first_directory(block)
    (stored,) = struct.unpack_from(order + "H", block, at)
    whole = [entry for entry in entries(block, at) if _ends_inside(entry, order, len(block))]
    software = with_software(read_directory(block, at)[0], note)[-1]
    text = even(software.data)
    size = len(text) + 2 + 12 * (len(whole) + 1) + 4
    start = _even_place(hole[0]) if size < hole[1] else len(block)
    own = struct.pack(order + "HHII", SOFTWARE, software.kind, software.count, start)
    others = [entry for entry in whole if struct.unpack_from(order + "H", entry)[0] != SOFTWARE]
    table = sorted([*others, own], key=lambda entry: struct.unpack_from(order + "H", entry)[0])
    directory = struct.pack(order + "H", len(table)) + b"".join(table)
    added = text + directory + struct.pack(order + "I", following)
    head = block[:4] + struct.pack(order + "I", start + len(text)) + block[8:start]
    return Annotated(head + added + block[start + len(added) :], broken=stored - len(whole))


def _even_place(at: int) -> int:
    """The even place at or behind another."""
    return at + at % 2


def _ends_inside(entry: bytes, order: str, length: int) -> bool:
    _, kind, count, start = struct.unpack(order + "HHII", entry)
    size = SIZES[kind] * count
    return size <= 4 or start + size <= length


def _with_thumbnail(block: bytes, refresh: Refresh) -> tuple[bytes, int, tuple[int, int]]:
    """The block with another thumbnail, the offset of its directory or 0, and where it lies."""
    order = byte_order(block)
    _, following = read_directory(block, first_directory(block))
    if not following:
        return block, 0, (0, 0)
    try:
        fields = {field.tag: field.data for field in read_directory(block, following)[0]}
        (start,) = struct.unpack(order + "I", fields[NEXT_IMAGE_OFFSET])
        (size,) = struct.unpack(order + "I", fields[NEXT_IMAGE_BYTES])
    except (KeyError, ValueError, struct.error):
        return _unlinked(block), 0, (0, 0)
    if start < 8 or start + size > len(block):
        return _unlinked(block), 0, (0, 0)
    fresh = refresh(block[start : start + size])
    if fresh is None or len(fresh) > size:
        return _unlinked(block), 0, (start, size)
    block = block[:start] + fresh.ljust(size, b"\0") + block[start + size :]
    return _with_length(block, following, len(fresh)), following, (start, size)


def _unlinked(block: bytes) -> bytes:
    """The block with its directory of the thumbnail unlinked."""
    order, at = byte_order(block), first_directory(block)
    link = at + 2 + 12 * struct.unpack_from(order + "H", block, at)[0]
    return block[:link] + bytes(4) + block[link + 4 :]


def _with_length(block: bytes, directory: int, length: int) -> bytes:
    order = byte_order(block)
    for index in range(struct.unpack_from(order + "H", block, directory)[0]):
        entry = directory + 2 + 12 * index
        if struct.unpack_from(order + "H", block, entry)[0] == NEXT_IMAGE_BYTES:
            value = struct.pack(order + "HII", 4, 1, length)
            return block[: entry + 2] + value + block[entry + 12 :]
    return block

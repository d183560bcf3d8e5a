"""Notes and thumbnails in an EXIF block, changed so that nothing else in it moves.

Maker notes refer to places in the block, so the block is only added to: a new first directory
goes to its end, and a refreshed thumbnail takes the place of the old one.
"""

from __future__ import annotations

import struct
from collections.abc import Callable

from plumbline.photos.files.tiff import (
    NEXT_IMAGE_BYTES,
    NEXT_IMAGE_OFFSET,
    byte_order,
    first_directory,
    new_block,
    read_directory,
    with_software,
)

Refresh = Callable[[bytes], bytes | None]

MOST_IN_JPEG = 65533 - 8
"""Bytes of EXIF that fit into one segment of a JPEG file."""


def annotated(block: bytes, note: str, refresh: Refresh) -> bytes:
    """The block with a note in Software and the thumbnail refreshed, or dropped.

    Args:
        block: The EXIF block; may be empty.
        note: What to say.
        refresh: Makes a new thumbnail, no longer than the old one, or None to drop it.

    Raises:
        ValueError, struct.error: the block makes no sense.
    """
    if not block:
        return new_block(with_software([], note))
    order, at = byte_order(block), first_directory(block)
    block, following = _with_thumbnail(block, refresh)
    count = struct.unpack_from(order + "H", block, at)[0]
    table = {
        struct.unpack_from(order + "H", block, entry)[0]: block[entry : entry + 12]
        for entry in range(at + 2, at + 2 + 12 * count, 12)
    }
    block += b"\0" * (len(block) % 2)
    software = with_software(read_directory(block, at)[0], note)[-1]
    start = len(block)
    head = struct.pack(order + "HHII", software.tag, software.kind, software.count, start)
    table[software.tag] = head
    text = software.data + b"\0" * (len(software.data) % 2)
    directory = struct.pack(order + "H", len(table)) + b"".join(table[tag] for tag in sorted(table))
    whole = block[:4] + struct.pack(order + "I", start + len(text)) + block[8:]
    return whole + text + directory + struct.pack(order + "I", following)


def without_thumbnail(block: bytes) -> bytes:
    """The block with its directory of the thumbnail unlinked; nothing is added."""
    order, at = byte_order(block), first_directory(block)
    link = at + 2 + 12 * struct.unpack_from(order + "H", block, at)[0]
    return block[:link] + bytes(4) + block[link + 4 :]


def _with_thumbnail(block: bytes, refresh: Refresh) -> tuple[bytes, int]:
    """The block with another thumbnail, and the offset of its directory or 0."""
    order = byte_order(block)
    _, following = read_directory(block, first_directory(block))
    if not following:
        return block, 0
    try:
        fields = {field.tag: field.data for field in read_directory(block, following)[0]}
        (start,) = struct.unpack(order + "I", fields[NEXT_IMAGE_OFFSET])
        (size,) = struct.unpack(order + "I", fields[NEXT_IMAGE_BYTES])
    except (KeyError, ValueError, struct.error):
        return block, 0
    fresh = refresh(block[start : start + size])
    if fresh is None or len(fresh) > size or start + size > len(block):
        return block, 0
    block = block[:start] + fresh.ljust(size, b"\0") + block[start + size :]
    return _with_length(block, following, len(fresh)), following


def _with_length(block: bytes, directory: int, length: int) -> bytes:
    order = byte_order(block)
    for index in range(struct.unpack_from(order + "H", block, directory)[0]):
        entry = directory + 2 + 12 * index
        if struct.unpack_from(order + "H", block, entry)[0] == NEXT_IMAGE_BYTES:
            value = struct.pack(order + "HII", 4, 1, length)
            return block[: entry + 2] + value + block[entry + 12 :]
    return block

"""PNG files: chunks beside the pixels.

Kept: EXIF, colour space and profile, resolution, texts and time. Dropped: palette,
transparency and background, which describe the old encoding, and animation.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator

from plumbline.photos.files.metadata import Metadata

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_KEPT = (
    b"iCCP sRGB gAMA cHRM cICP mDCV cLLI pHYs tEXt zTXt iTXt tIME".split()  # in any order
)
_INCH_M = 0.0254
_XMP_HEAD = b"XML:com.adobe.xmp\0\0\0\0\0"


def chunks(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Name and whole bytes of each chunk, to the last one.

    Raises:
        ValueError, struct.error: the file makes no sense or is cut short.
    """
    if data[:8] != _SIGNATURE:
        raise ValueError("this is no PNG file")
    at, name = 8, b""
    while name != b"IEND":
        size, name = struct.unpack_from(">I4s", data, at)
        end = at + 12 + size
        if end > len(data):
            raise ValueError("the file is cut short")
        yield name, data[at:end]
        at = end


def depth_and_kind(data: bytes) -> tuple[int, int]:
    """Bits a channel and the colour type."""
    return data[24], data[25]


def read_metadata(data: bytes) -> Metadata:
    """Metadata of a PNG file; EXIF apart, the rest as records."""
    exif, records = b"", list[bytes]()
    for name, chunk in chunks(data):
        if name == b"eXIf":
            exif = chunk[8:-4]
        elif name in _KEPT:
            records.append(chunk)
    return Metadata(exif=exif, records=tuple(records))


def with_metadata(data: bytes, metadata: Metadata) -> bytes:
    """A PNG file with this metadata, and none of its own."""
    records = list(metadata.records) or _records(metadata)
    if metadata.exif:
        records.append(_chunk(b"eXIf", metadata.exif))
    (_, header), *others = chunks(data)
    own = [chunk for name, chunk in others if name in (b"PLTE", b"IDAT", b"IEND")]
    return b"".join([_SIGNATURE, header, *records, *own])


def _records(metadata: Metadata) -> list[bytes]:
    """Chunks for metadata that came from another format."""
    made: list[bytes] = []
    if metadata.icc:
        made.append(_chunk(b"iCCP", b"ICC profile\0\0" + zlib.compress(metadata.icc)))
    if metadata.dpi:
        across, down = (round(value / _INCH_M) for value in metadata.dpi)
        made.append(_chunk(b"pHYs", struct.pack(">IIB", across, down, 1)))
    if metadata.xmp:
        made.append(_chunk(b"iTXt", _XMP_HEAD + metadata.xmp))
    return made


def _chunk(name: bytes, payload: bytes) -> bytes:
    check = zlib.crc32(name + payload)
    return struct.pack(">I", len(payload)) + name + payload + struct.pack(">I", check)

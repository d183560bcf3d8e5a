"""JPEG files: segments before the pixels.

Kept: EXIF, XMP, ICC, IPTC, comments and all other application segments. Dropped: what
describes the old encoding (Adobe), thumbnails in JFIF, and further pictures (MPF). What other
programs hang behind the pixels is kept as well.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator

from plumbline.photos.files.metadata import Metadata

_SOI, _EOI = b"\xff\xd8", b"\xff\xd9"
_APP0, _APP1, _APP2, _APP14, _APP15, _COM, _SOS = 0xE0, 0xE1, 0xE2, 0xEE, 0xEF, 0xFE, 0xDA
_EXIF, _XMP, _ICC = b"Exif\0\0", b"http://ns.adobe.com/xap/1.0/\0", b"ICC_PROFILE\0"
_JFIF, _MPF = b"JFIF\0", b"MPF\0"
_MOST = 65533
MOST_OF_XMP = _MOST - len(_XMP)
_JFIF_HEAD = 14


def segments(data: bytes) -> Iterator[tuple[int, int, int]]:
    """Marker, start and end of each segment up to the pixels; start is that of its payload.

    Raises:
        ValueError, struct.error: the file makes no sense.
    """
    if data[:2] != _SOI:
        raise ValueError("this is no JPEG file")
    at = 2
    while True:
        while data[at : at + 2] == b"\xff\xff":
            at += 1
        lead, marker, size = struct.unpack_from(">BBH", data, at)
        if lead != 0xFF or size < 2:
            raise ValueError("the segments are damaged")
        yield marker, at + 4, at + 2 + size
        if marker == _SOS:
            return
        at += 2 + size


def complete(data: bytes) -> bool:
    """Whether the pixels end as they should."""
    return _end(data) > 0


def read_metadata(data: bytes) -> Metadata:
    """Metadata of a JPEG file; EXIF apart, the rest as records, the last of them the trailer."""
    exif, records, alone = b"", list[bytes](), True
    for marker, start, end in segments(data):
        payload = data[start:end]
        if marker == _APP1 and payload.startswith(_EXIF):
            exif = exif or payload[len(_EXIF) :]
        elif marker == _APP0 and payload.startswith(_JFIF):
            records.append(_segment(_APP0, payload[: _JFIF_HEAD - 2] + b"\0\0"))
        elif marker == _APP2 and payload.startswith(_MPF):
            alone = False
        elif (marker == _COM or _APP1 <= marker <= _APP15) and marker != _APP14:
            records.append(_segment(marker, payload))
    trailer = data[_end(data) :] if alone else b""
    return Metadata(exif=exif, records=(*records, trailer))


def with_metadata(data: bytes, metadata: Metadata) -> bytes:
    """A JPEG file with this metadata, and none of its own."""
    *records, trailer = metadata.records or (*_records(metadata), b"")
    is_jfif = bool(records) and records[0][1] == _APP0
    jfif, others = (records[:1], records[1:]) if is_jfif else ([], records)
    exif = [_segment(_APP1, _EXIF + metadata.exif)] if metadata.exif else []
    own = [data[start - 4 : end] for marker, start, end in segments(data) if marker != _APP0]
    return b"".join([_SOI, *jfif, *exif, *others, *own, data[_pixels_at(data) :], trailer])


def _end(data: bytes) -> int:
    """Where the picture ends, or 0 where its end is missing."""
    found = data.find(_EOI, _pixels_at(data))
    return found + len(_EOI) if found >= 0 else 0


def _pixels_at(data: bytes) -> int:
    return list(segments(data))[-1][2]


def _records(metadata: Metadata) -> list[bytes]:
    """Segments for metadata that came from another format."""
    made: list[bytes] = []
    across, down = metadata.dpi or (1.0, 1.0)
    density = struct.pack(">BHH", 1 if metadata.dpi else 0, round(across), round(down))
    made.append(_segment(_APP0, _JFIF + b"\x01\x02" + density + b"\0\0"))
    if metadata.xmp:
        made.append(_segment(_APP1, _XMP + metadata.xmp))
    room = _MOST - len(_ICC) - 2
    parts = [metadata.icc[i : i + room] for i in range(0, len(metadata.icc), room)]
    for number, part in enumerate(parts, start=1):
        made.append(_segment(_APP2, _ICC + bytes((number, len(parts))) + part))
    return made


def _segment(marker: int, payload: bytes) -> bytes:
    return struct.pack(">BBH", 0xFF, marker, len(payload) + 2) + payload

"""JPEG files: segments before the pixels.

Kept: EXIF, XMP, ICC, IPTC, comments and all other application segments, and what other programs
hang behind the pixels. Dropped: what describes the old encoding (Adobe) and thumbnails in JFIF;
further pictures (MPF, gain maps), which are not corrected, with XMP's promise of them.
"""

from __future__ import annotations

import io
import re
import struct
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from PIL import Image

from plumbline.photos.files import photoshop, xmp
from plumbline.photos.files.metadata import Metadata

_SOI, _EOI = b"\xff\xd8", b"\xff\xd9"
_APP0, _APP1, _APP2, _APP13, _APP14, _APP15 = 0xE0, 0xE1, 0xE2, 0xED, 0xEE, 0xEF
_COM, _SOS = 0xFE, 0xDA
_EXIF, _XMP, _ICC = b"Exif\0\0", b"http://ns.adobe.com/xap/1.0/\0", b"ICC_PROFILE\0"
_JFIF, _MPF, _GAIN_MAP = b"JFIF\0", b"MPF\0", b"urn:iso:std:iso:ts:21496:-1\0"
_MOST = 65533
"""Bytes of a segment's payload: its length, two bytes, counts itself (ITU-T T.81, B.1.1.4)."""

MOST_OF_EXIF = _MOST - len(_EXIF)
MOST_OF_XMP = _MOST - len(_XMP)
_JFIF_HEAD = 14
"""Bytes of a JFIF segment without a thumbnail (JFIF 1.02)."""
_MARKER = re.compile(rb"\xff[^\x00\xd0-\xd7\xff]")
_FILLING = b"\x55" * 4096  # chosen because it holds no marker and is long for any decoder


def segments(data: bytes) -> Iterator[tuple[int, int, int]]:
    """Marker, start and end of each segment up to the pixels; start is that of its payload.

    Raises:
        ValueError, struct.error: the file makes no sense.
    """
    if data[:2] != _SOI:
        raise ValueError("it does not begin like a JPEG file")
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
    return end_of(data) > 0


def filled(data: bytes, progressive: bool) -> bool:
    """Whether there are pixels up to the end.

    A decoder that runs out of them invents the rest. It reads other pixels where meaningless
    bytes are put before the end, and only then. An eighth of the size, which costs little, shows
    that, but for the finer details that later scans of a progressive file add.
    """
    end, shrunk = end_of(data), 1 if progressive else 8
    garbled = data[: end - 2] + _FILLING + _EOI
    return _pixels(data[:end], shrunk) == _pixels(garbled, shrunk)


def _pixels(data: bytes, shrunk: int) -> bytes:
    with Image.open(io.BytesIO(data)) as image:
        image.draft("L", (max(image.width // shrunk, 1), max(image.height // shrunk, 1)))
        return np.asarray(image).tobytes()


def read_metadata(data: bytes) -> tuple[Metadata, list[str]]:
    """Metadata of a JPEG file, and what is left out of it.

    EXIF stands apart; the rest are records, the last of them the trailer.
    """
    exif, records, alone = b"", list[bytes](), True
    told: dict[str, bytes] = {}
    others: set[str] = set()
    for marker, start, end in segments(data):
        payload = data[start:end]
        if marker == _APP1 and payload.startswith(_EXIF) and not exif:
            exif = payload[len(_EXIF) :]
        elif marker == _APP0 and payload.startswith(_JFIF):
            records.append(_segment(_APP0, payload[: _JFIF_HEAD - 2] + b"\0\0"))
        elif marker == _APP2 and payload.startswith((_MPF, _GAIN_MAP)):
            alone = False
        elif (marker == _COM or _APP1 <= marker <= _APP15) and marker != _APP14:
            records.append(_segment(marker, payload))
            _tell(marker, payload, told, others)
    trailer = data[end_of(data) :]
    if trailer:
        others.add("data behind the picture")
    packet, resources = told.get("xmp", b""), told.get("photoshop", b"")
    metadata = Metadata(
        exif=exif,
        xmp=packet,
        iptc=photoshop.iptc_of(resources),
        photoshop=resources,
        comment=told.get("comment", b"").rstrip(b"\0").decode("utf-8", "replace"),
        records=(*records, trailer),
        only_here=tuple(sorted(others)),
    )
    alone = alone and not xmp.tells_of_gain_map(packet)
    return (metadata, []) if alone else _alone(metadata, trailer)


def _tell(marker: int, payload: bytes, told: dict[str, bytes], others: set[str]) -> None:
    """Take from a segment what other formats hold too."""
    if marker == _COM:
        told.setdefault("comment", payload)
    elif marker == _APP13 and payload.startswith(photoshop.HEAD):
        told["photoshop"] = told.get("photoshop", b"") + payload[len(photoshop.HEAD) :]
    elif payload.startswith(_XMP):
        told.setdefault("xmp", payload[len(_XMP) :])
    elif not payload.startswith(_ICC):
        others.add(f"segments of the kind APP{marker - _APP0}")


def _alone(metadata: Metadata, trailer: bytes) -> tuple[Metadata, list[str]]:
    """The metadata of the first picture of several, without the others and their promise."""
    *records, _ = metadata.records
    packet = metadata.xmp
    what = "a gain map" if xmp.tells_of_gain_map(packet) else "further pictures"
    if b"ftyp" in trailer[:64] or b"ftypmp4" in trailer or b"ftypisom" in trailer:
        what += " and a video"
    notes = [f"{what} behind the photo, which would not fit the corrected one, left out"]
    if packet and xmp.promises(packet):
        try:
            fresh = xmp.without_promises(packet)
        except ValueError:
            fresh = b""
            notes.append("XMP, damaged and telling of them, left out")
        new = [_segment(_APP1, _XMP + fresh)] if fresh else []
        records = [*new, *(each for each in records if not each[4:].startswith(_XMP))]
        records.sort(key=lambda each: each[1] != _APP0)
        packet = fresh
    others = tuple(each for each in metadata.only_here if "behind" not in each)
    return replace(metadata, xmp=packet, records=(*records, b""), only_here=others), notes


def with_metadata(data: bytes, metadata: Metadata, remark: str) -> bytes:
    """A JPEG file with this metadata, and none of its own.

    Args:
        data: The file.
        metadata: The metadata.
        remark: A comment to put first; may be empty.
    """
    *records, trailer = metadata.records or (*_records(metadata), b"")
    is_jfif = bool(records) and records[0][1] == _APP0
    jfif, others = (records[:1], records[1:]) if is_jfif else ([], records)
    exif = [_segment(_APP1, _EXIF + metadata.exif)] if metadata.exif else []
    first = [_segment(_COM, remark.encode())] if remark else []
    own = [data[start - 4 : end] for marker, start, end in segments(data) if marker != _APP0]
    pixels = data[_pixels_at(data) :]
    return b"".join([_SOI, *jfif, *exif, *first, *others, *own, pixels, trailer])


def end_of(data: bytes) -> int:
    """Where the picture ends, or 0 where its end is missing."""
    at = _pixels_at(data)
    while found := _MARKER.search(data, at):
        if found.group() == _EOI:
            return found.end()
        if found.end() + 2 > len(data):
            return 0
        at = found.end() + struct.unpack_from(">H", data, found.end())[0]
    return 0


def _pixels_at(data: bytes) -> int:
    return list(segments(data))[-1][2]


def _records(metadata: Metadata) -> list[bytes]:
    """Segments for metadata that came from another format."""
    across, down = metadata.dpi or (1.0, 1.0)
    density = struct.pack(">BHH", 1 if metadata.dpi else 0, round(across), round(down))
    records = [_segment(_APP0, _JFIF + b"\x01\x02" + density + b"\0\0")]
    if metadata.xmp:
        records.append(_segment(_APP1, _XMP + metadata.xmp))
    records += _parts(_APP2, metadata.icc, len(_ICC) + 2, _icc_head)
    if metadata.iptc:
        resources = photoshop.with_iptc(metadata.iptc)
        records += _parts(_APP13, resources, len(photoshop.HEAD), lambda _, __: photoshop.HEAD)
    if metadata.comment:
        records.append(_segment(_COM, metadata.comment.encode()[:_MOST]))
    return records


def _parts(
    marker: int, data: bytes, head_size: int, head: Callable[[int, int], bytes]
) -> list[bytes]:
    room = _MOST - head_size
    parts = [data[i : i + room] for i in range(0, len(data), room)]
    return [_segment(marker, head(i, len(parts)) + part) for i, part in enumerate(parts, start=1)]


def _icc_head(number: int, of: int) -> bytes:
    return _ICC + bytes((number, of))


def _segment(marker: int, payload: bytes) -> bytes:
    return struct.pack(">BBH", 0xFF, marker, len(payload) + 2) + payload

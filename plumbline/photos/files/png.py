"""PNG files: chunks beside the pixels.

Kept: EXIF, colour space and profile, resolution, texts and time. Dropped: palette,
transparency and background, which describe the old encoding, and animation.
"""

from __future__ import annotations

import binascii
import struct
import zlib
from collections.abc import Iterator

from plumbline.photos.files.metadata import Metadata

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_KEPT = (
    b"iCCP sRGB gAMA cHRM cICP mDCV cLLI pHYs tEXt zTXt iTXt tIME".split()  # in any order
)
_TEXTS = (b"tEXt", b"zTXt", b"iTXt")
_INCH_M = 0.0254
"""PNG counts pixels a metre, EXIF pixels an inch."""
_XMP_HEAD = b"XML:com.adobe.xmp\0\0\0\0\0"
_IPTC_PROFILE, _COMMENT = b"Raw profile type iptc", b"Comment"
_MOST_OF_TEXT = 2**24  # bytes; chosen to stop bombs, IPTC has a few thousand


def chunks(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Name and whole bytes of each chunk, to the last one.

    Raises:
        ValueError, struct.error: the file makes no sense or is cut short.
    """
    if data[:8] != _SIGNATURE:
        raise ValueError("it does not begin like a PNG file")
    at, name = 8, b""
    while name != b"IEND":
        size, name = struct.unpack_from(">I4s", data, at)
        end = at + 12 + size
        if end > len(data):
            raise ValueError("the file is cut short")
        yield name, data[at:end]
        at = end


def refuse_damage(data: bytes) -> None:
    """Refuse a file that is cut short, or whose pixels do not bear their checksums.

    Raises:
        ValueError, struct.error: as said.
    """
    for name, chunk in chunks(data):
        if name == b"IDAT" and zlib.crc32(chunk[4:-4]) != struct.unpack(">I", chunk[-4:])[0]:
            raise ValueError("the pixels do not bear their checksum")


def depth_and_kind(data: bytes) -> tuple[int, int]:
    """Bits a channel and the colour type."""
    return data[24], data[25]


def read_metadata(data: bytes) -> tuple[Metadata, list[str]]:
    """Metadata of a PNG file; EXIF apart, the rest as records."""
    exif, records, iptc, comment, others = b"", list[bytes](), b"", "", False
    for name, chunk in chunks(data):
        if name == b"eXIf":
            exif = chunk[8:-4]
        elif name in _KEPT:
            records.append(chunk)
            if name in _TEXTS:
                keyword, _, rest = chunk[8:-4].partition(b"\0")
                if keyword == _IPTC_PROFILE:
                    iptc = _iptc(name, rest)
                elif keyword == _COMMENT:
                    comment = comment or _comment(name, rest)
                elif keyword != _XMP_HEAD.partition(b"\0")[0]:
                    others = True
        elif name in (b"acTL", b"fcTL", b"fdAT"):
            others = True
    return Metadata(
        exif=exif,
        iptc=iptc,
        comment=comment,
        records=tuple(records),
        only_here=("texts",) if others else (),
    ), []


def _text(name: bytes, rest: bytes) -> bytes:
    if name == b"tEXt":
        return rest
    try:
        return zlib.decompressobj().decompress(rest[1:], _MOST_OF_TEXT)
    except zlib.error:
        return b""


def _comment(name: bytes, rest: bytes) -> str:
    if name != b"iTXt":
        return _text(name, rest).decode("latin-1")
    text = rest[2:].split(b"\0", 2)[-1]
    return (_text(b"zTXt", b"\0" + text) if rest[:1] == b"\1" else text).decode("utf-8", "replace")


def _iptc(name: bytes, rest: bytes) -> bytes:
    """IPTC as ImageMagick writes it: a name, a length, and hexadecimal digits."""
    try:
        return binascii.unhexlify(b"".join(_text(name, rest).split()[2:]))
    except binascii.Error:
        return b""


def with_metadata(data: bytes, metadata: Metadata, remark: str) -> bytes:
    """A PNG file with this metadata, and none of its own.

    Args:
        data: The file.
        metadata: The metadata.
        remark: A text of the software to put first; may be empty.
    """
    records = list(metadata.records) or _records(metadata)
    first = [_chunk(b"tEXt", b"Software\0" + remark.encode("latin-1", "replace"))] if remark else []
    if metadata.exif:
        first.append(_chunk(b"eXIf", metadata.exif))
    (_, header), *others = chunks(data)
    own = [chunk for name, chunk in others if name in (b"PLTE", b"IDAT", b"IEND")]
    return b"".join([_SIGNATURE, header, *first, *records, *own])


def _records(metadata: Metadata) -> list[bytes]:
    """Chunks for metadata that came from another format."""
    records: list[bytes] = []
    if metadata.icc:
        records.append(_chunk(b"iCCP", b"ICC profile\0\0" + zlib.compress(metadata.icc)))
    if metadata.dpi:
        across, down = (round(value / _INCH_M) for value in metadata.dpi)
        records.append(_chunk(b"pHYs", struct.pack(">IIB", across, down, 1)))
    if metadata.xmp:
        records.append(_chunk(b"iTXt", _XMP_HEAD + metadata.xmp))
    if metadata.iptc:
        digits = binascii.hexlify(metadata.iptc)
        text = b"\niptc\n%8d\n" % len(metadata.iptc) + digits + b"\n"
        records.append(_chunk(b"zTXt", _IPTC_PROFILE + b"\0\0" + zlib.compress(text)))
    if metadata.comment:
        records.append(_chunk(b"iTXt", _COMMENT + b"\0\0\0\0\0" + metadata.comment.encode()))
    return records


def _chunk(name: bytes, payload: bytes) -> bytes:
    check = zlib.crc32(name + payload)
    return struct.pack(">I", len(payload)) + name + payload + struct.pack(">I", check)

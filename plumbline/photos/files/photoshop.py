"""Photoshop's image resources, in which JPEG files carry IPTC.

Each resource: `8BIM`, its number, a name, its length and its bytes, both filled up to an even
length. Source: Adobe Photoshop File Formats Specification, "Image Resource Blocks".
"""

from __future__ import annotations

import struct
from collections.abc import Iterator

HEAD = b"Photoshop 3.0\0"
"""What a JPEG segment of resources begins with."""

_IPTC = 0x0404
"""The image resource that holds IPTC (Adobe Photoshop File Formats)."""
_MARK = b"8BIM"


def iptc_of(resources: bytes) -> bytes:
    """The IPTC records among image resources; empty where there are none or they are damaged."""
    try:
        return next((data for number, data in _resources(resources) if number == _IPTC), b"")
    except struct.error:
        return b""


def with_iptc(iptc: bytes) -> bytes:
    """Image resources that hold IPTC records alone."""
    return _MARK + struct.pack(">HHI", _IPTC, 0, len(iptc)) + iptc + b"\0" * (len(iptc) % 2)


def holds_more(resources: bytes) -> bool:
    """Whether there are resources beside IPTC."""
    try:
        return any(number != _IPTC for number, _ in _resources(resources))
    except struct.error:
        return bool(resources)


def _resources(data: bytes) -> Iterator[tuple[int, bytes]]:
    at = 0
    while data[at : at + 4] == _MARK:
        number, name = struct.unpack_from(">HB", data, at + 4)
        at += 6 + (name + 2) // 2 * 2
        (size,) = struct.unpack_from(">I", data, at)
        yield number, data[at + 4 : at + 4 + size]
        at += 4 + size + size % 2

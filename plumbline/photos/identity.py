"""Which photograph it is: its checksum, and what EXIF tells of the camera and the moment.

Source: EXIF 2.32 (CIPA DC-008-2019), DateTimeOriginal 0x9003, BodySerialNumber 0xA431.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from plumbline.errors import ReadError, printable
from plumbline.files import read_bytes
from plumbline.photos.header import read_header

_TAKEN, _CHANGED, _SERIAL = 0x9003, 0x0132, 0xA431
_LONGEST = 80
"""Chosen, because no serial number or date is longer, and a report's row holds it."""


@dataclass(frozen=True)
class Identity:
    """Which photograph it is.

    Attributes:
        sha256: Of the file's bytes, in hexadecimal.
        taken: When it was taken, as EXIF writes it; empty where it does not tell.
        serial: Serial number of the camera's body; empty where EXIF does not tell.
    """

    sha256: str
    taken: str = ""
    serial: str = ""


def identity_of(path: str | Path) -> Identity:
    """Which photograph a file is.

    Raises:
        ReadError: the file cannot be read.
    """
    tags = _tags(path)
    taken = _text(tags, _TAKEN) or _text(tags, _CHANGED)
    return Identity(hashlib.sha256(read_bytes(path)).hexdigest(), taken, _text(tags, _SERIAL))


def _tags(path: str | Path) -> dict[int, Any]:
    """EXIF's tags; none where they are damaged, which the reader of the photo tells."""
    try:
        return read_header(path, "").tags
    except ReadError:
        return {}


def _text(tags: dict[int, Any], tag: int) -> str:
    value = tags.get(tag)
    return printable(value.strip("\0 "))[:_LONGEST] if isinstance(value, str) else ""

"""Whether the camera corrected the distortion itself, from its maker notes.

Nikon: tag 0x002B (DistortInfo), fifth byte, 1 or 2 for on. Sony: tag 0x2013
(DistortionCorrectionSetting), 2 for on. Other makers do not tell, or not in a known place.
Source: the tag tables of ExifTool 12.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping

_NIKON, _SONY = b"Nikon\x00", b"SONY "
_NIKON_TAG, _SONY_TAG = 0x002B, 0x2013
_SIZES = {1: 1, 2: 1, 3: 2, 4: 4, 7: 1}
_MOST_ENTRIES = 1000


def corrected_in_camera(notes: bytes) -> str:
    """What tells that the camera corrected the distortion; empty if nothing does.

    Args:
        notes: The maker notes as they stand in EXIF; may be anything.
    """
    try:
        if notes.startswith(_NIKON):
            value = _nikon(notes[10:]).get(_NIKON_TAG, b"")
            return "Nikon: auto distortion control is on" if value[4:5] in (b"\1", b"\2") else ""
        if notes.startswith(_SONY):
            order = "<" if notes[13] == 0 else ">"  # fewer than 256 entries
            value = _entries(notes, 12, order).get(_SONY_TAG, b"")
            on = value == struct.pack(f"{order}I", 2)
            return "Sony: distortion correction is on" if on else ""
    except (struct.error, IndexError):
        pass  # notes that are cut off or were edited tell nothing
    return ""


def _nikon(tiff: bytes) -> Mapping[int, bytes]:
    order = "<" if tiff.startswith(b"II") else ">"
    (first,) = struct.unpack_from(f"{order}I", tiff, 4)
    return _entries(tiff, first, order)


def _entries(tiff: bytes, start: int, order: str) -> dict[int, bytes]:
    """The values of a TIFF directory as bytes; those of unknown types are left out."""
    (n,) = struct.unpack_from(f"{order}H", tiff, start)
    found: dict[int, bytes] = {}
    for index in range(min(n, _MOST_ENTRIES)):
        at = start + 2 + 12 * index
        tag, kind, count = struct.unpack_from(f"{order}HHI", tiff, at)
        size = _SIZES.get(kind, 0) * count
        if size > 4:
            (place,) = struct.unpack_from(f"{order}I", tiff, at + 8)
        else:
            place = at + 8
        found[tag] = tiff[place : place + size]
    return found

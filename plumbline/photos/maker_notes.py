"""What maker notes tell as text or as a switch: the lens, and a correction in the camera.

Each maker hides a TIFF directory behind a head of its own; its offsets count from the head, or
from the beginning of the EXIF block. Read here is only what stands as text or as one number.
Lens numbers, which need tables of thousands of rows, are exiftool's business.

Source: the tag tables of ExifTool 12.57 (Canon.pm, Nikon.pm, Olympus.pm, Panasonic.pm,
Pentax.pm, Sony.pm).
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass, replace

_SIZES = {1: 1, 2: 1, 3: 2, 4: 4, 5: 8, 6: 1, 7: 1, 8: 2, 9: 4, 10: 8, 11: 4, 12: 8, 13: 4}
_MOST_ENTRIES = 1000
"""Chosen because the longest known, of Canon, have about 150."""


@dataclass(frozen=True)
class MakerNotes:
    """What maker notes tell.

    Attributes:
        lens: Name of the lens; may be empty.
        range_mm: Shortest and longest focal length of the lens, if told.
        corrected: What tells that the camera corrected the distortion; else empty.
        uncorrected: What tells that it did not; else empty.
    """

    lens: str = ""
    range_mm: tuple[float, float] | None = None
    corrected: str = ""
    uncorrected: str = ""


@dataclass(frozen=True)
class _Directory:
    """Values by tag, as bytes in an order.

    Attributes:
        values: Bytes of each tag.
        order: `<` or `>`.
        whole: What the offsets count in.
    """

    values: dict[int, bytes]
    order: str
    whole: bytes

    def number(self, tag: int) -> int | None:
        """The first value of a tag, 1, 2 or 4 bytes; None where it is missing."""
        value = self.values.get(tag, b"")
        kind = {1: "B", 2: "H", 4: "I"}.get(len(value))
        return None if kind is None else int(struct.unpack(self.order + kind, value)[0])

    def text(self, tag: int) -> str:
        """A text; empty where it is missing, or none that a lens could have."""
        value = self.values.get(tag, b"").split(b"\0")[0].strip()
        return (
            value.decode("ascii") if value.isascii() and value.decode("ascii").isprintable() else ""
        )

    def below(self, tag: int) -> _Directory:
        """The directory that a tag points to."""
        start = self.number(tag)
        return _directory(self.whole, start or 0, self.order)


@dataclass(frozen=True)
class _Place:
    """Maker notes, the bytes that some offsets count in, and where the notes stand in these."""

    notes: bytes
    whole: bytes
    start: int
    order: str


def read_maker_notes(notes: bytes, block: bytes, maker: str) -> MakerNotes:
    """What maker notes tell.

    Args:
        notes: The maker notes as they stand in EXIF; may be anything.
        block: The EXIF block that they stand in; may be empty.
        maker: Maker of the camera, as EXIF has it.
    """
    at = block.find(notes) if notes else -1
    whole, start = (block, at) if at >= 0 else (notes, 0)
    order = ">" if whole[:2] == b"MM" else "<"
    place = _Place(notes, whole, start, order)
    reader = next((r for head, r in _READERS.items() if notes.startswith(head)), None)
    if reader is None and maker.casefold().startswith("canon"):
        reader = _canon
    if reader is None or not notes:
        return MakerNotes()
    try:
        return reader(place)
    except (struct.error, IndexError, ValueError):
        return MakerNotes()  # notes that are cut off or were edited tell nothing


def _told(lens: str, what: str, switch: bool | None) -> MakerNotes:
    return MakerNotes(
        lens=lens if any(c.isdigit() for c in lens) else "",
        corrected=f"{what} is on" if switch else "",
        uncorrected=f"{what} is off" if switch is False else "",
    )


def _canon(at: _Place) -> MakerNotes:
    """0x0095 is the lens; 0x4016's entry 7 and 0x4015's entry 3 switch the correction.

    0x0001's entries 23 to 25 are the lens's longest and shortest focal length, and their unit.
    """
    found, order = _directory(at.whole, at.start, at.order), at.order
    setting, applied = found.values.get(0x4016, b""), found.values.get(0x4015, b"")
    switch: bool | None = None
    if len(setting) >= 32:
        switch = struct.unpack_from(order + "i", setting, 28)[0] != 0
    if applied[:1] == b"\0" and applied[:4] != bytes(4) and len(applied) >= 8:
        switch = switch or struct.unpack_from(order + "h", applied, 6)[0] != 0
    told = _told(found.text(0x0095), "Canon: distortion correction", switch)
    settings = found.values.get(0x0001, b"")
    if len(settings) < 52:
        return told
    high, low, unit = struct.unpack_from(order + "3H", settings, 46)
    return replace(told, range_mm=(low / unit, high / unit) if 0 < unit <= low <= high else None)


def _nikon(at: _Place) -> MakerNotes:
    """0x002B's fifth byte is 1 or 2 for on; 0x0084 has the lens's focal lengths."""
    tiff = at.notes[10:]
    order = "<" if tiff.startswith(b"II") else ">"
    found = _directory(tiff, struct.unpack_from(f"{order}I", tiff, 4)[0], order)
    value = found.values.get(0x002B, b"")[4:5]
    switch = {b"\0": False, b"\1": True, b"\2": True}.get(value)
    told = _told("", "Nikon: auto distortion control", switch)
    lens = found.values.get(0x0084, b"")
    range_mm = None
    if len(lens) == 32:
        low, per_low, high, per_high = struct.unpack_from(order + "4I", lens)
        if low and high and per_low and per_high:
            range_mm = (low / per_low, high / per_high)
    return replace(told, range_mm=range_mm)


def _sony(at: _Place) -> MakerNotes:
    """0x2013 is 2 for on."""
    order = "<" if at.notes[13] == 0 else ">"  # fewer than 256 entries
    setting = _directory(at.whole, at.start + 12, order).number(0x2013)
    switch = None if setting is None else setting == 2
    return _told("", "Sony: distortion correction", switch)


def _olympus_old(at: _Place) -> MakerNotes:
    return _olympus(_directory(at.whole, at.start + 8, at.order))


def _olympus_new(at: _Place) -> MakerNotes:
    head = 16 if at.notes.startswith(b"OM SYSTEM") else 12
    order = "<" if at.notes[head - 4 : head - 2] == b"II" else ">"
    return _olympus(_directory(at.notes, head, order))


def _olympus(found: _Directory) -> MakerNotes:
    """Equipment's 0x0203 is the lens; settings' 0x050B or processing's 0x1011 is 1 for on."""
    lens = found.below(0x2010).text(0x0203)
    settings = (found.below(0x2020).number(0x050B), found.below(0x2040).number(0x1011))
    known = [value for value in settings if value is not None]
    return _told(lens, "Olympus: distortion correction", any(known) if known else None)


def _panasonic(at: _Place) -> MakerNotes:
    """0x0051 is the lens."""
    return _told(_directory(at.whole, at.start + 12, at.order).text(0x0051), "", None)


def _pentax_old(at: _Place) -> MakerNotes:
    order = ">" if at.notes[4:6] == b"MM" else "<"
    return _pentax(_directory(at.whole, at.start + 6, order))


def _pentax_new(at: _Place) -> MakerNotes:
    order = ">" if at.notes[8:10] == b"MM" else "<"
    return _pentax(_directory(at.notes, 10, order))


def _pentax(found: _Directory) -> MakerNotes:
    """0x007D's first byte is 1 for on."""
    value = found.values.get(0x007D, b"")[:1]
    return _told("", "Pentax: distortion correction", {b"\0": False, b"\1": True}.get(value))


_READERS: dict[bytes, Callable[[_Place], MakerNotes]] = {
    b"Nikon\0": _nikon,
    b"SONY ": _sony,
    b"OLYMP\0": _olympus_old,
    b"OLYMPUS\0": _olympus_new,
    b"OM SYSTEM\0": _olympus_new,
    b"Panasonic\0": _panasonic,
    b"AOC\0": _pentax_old,
    b"PENTAX \0": _pentax_new,
}


def _directory(whole: bytes, start: int, order: str) -> _Directory:
    """A directory's values as bytes; those of unknown types are left out."""
    values: dict[int, bytes] = {}
    if start <= 0 and whole[:2] in (b"II", b"MM"):
        return _Directory(values, order, whole)
    (n,) = struct.unpack_from(f"{order}H", whole, start)
    for index in range(min(n, _MOST_ENTRIES)):
        at = start + 2 + 12 * index
        if at + 12 > len(whole):
            break
        tag, kind, count = struct.unpack_from(f"{order}HHI", whole, at)
        size = _SIZES.get(kind, 0) * count
        place = at + 8
        if size > 4:
            (place,) = struct.unpack_from(f"{order}I", whole, at + 8)
        values[tag] = whole[place : place + size]
    return _Directory(values, order, whole)

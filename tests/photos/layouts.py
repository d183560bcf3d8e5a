"""Photographs written by hand in each maker's EXIF layout, maker notes and all.

Independent of the library: directories are packed here with struct, by the layouts that
ExifTool's documentation describes.
"""

from __future__ import annotations

import io
import struct
from collections.abc import Callable, Sequence
from pathlib import Path

from PIL import Image

Entry = tuple[int, int, bytes]  # tag, type, bytes of its values
SIZES = {1: 1, 2: 1, 3: 2, 4: 4, 5: 8, 7: 1, 9: 4}


def text(value: str) -> bytes:
    return value.encode() + b"\0"


def packed(entries: Sequence[Entry], at: int, order: str) -> bytes:
    """A directory whose offsets count from a place `at` bytes before it."""
    table, heap = struct.pack(order + "H", len(entries)), b""
    end = at + 2 + 12 * len(entries) + 4
    for tag, kind, data in sorted(entries):
        value = data.ljust(4, b"\0")
        if len(data) > 4:
            value = struct.pack(order + "I", end + len(heap))
            heap += data + b"\0" * (len(data) % 2)
        table += struct.pack(order + "HHI", tag, kind, len(data) // SIZES[kind]) + value
    return table + bytes(4) + heap


def block(
    make: str,
    model: str,
    exif: Sequence[Entry] = (),
    notes: Callable[[int, str], bytes] | None = None,
    order: str = "<",
) -> bytes:
    """An EXIF block; the maker notes are made for the place where they come to lie."""
    head = (b"II*\0" if order == "<" else b"MM\0*") + struct.pack(order + "I", 8)
    first = [(0x010F, 2, text(make)), (0x0110, 2, text(model)), (0x8769, 4, bytes(4))]
    at = 8 + len(packed(first, 8, order))
    at += at % 2
    first[-1] = (0x8769, 4, struct.pack(order + "I", at))
    main = (head + packed(first, 8, order)).ljust(at, b"\0")
    if notes is None:
        return main + packed(exif, at, order)
    # The notes' length does not depend on their place.
    body = notes(at, order)
    place = at + packed([*exif, (0x927C, 7, body)], at, order).index(body)
    return main + packed([*exif, (0x927C, 7, notes(place, order))], at, order)


def photo(path: Path, exif: bytes, size: tuple[int, int] = (600, 400)) -> Path:
    buffer = io.BytesIO()
    Image.new("L", size, 128).save(buffer, "JPEG")
    data = buffer.getvalue()
    payload = b"Exif\0\0" + exif
    path.write_bytes(data[:2] + struct.pack(">HH", 0xFFE1, len(payload) + 2) + payload + data[2:])
    return path


def focal(mm: float, order: str = "<", equivalent: int | None = None) -> list[Entry]:
    entries: list[Entry] = [(0x920A, 5, struct.pack(order + "II", round(mm * 10), 10))]
    if equivalent:
        entries.append((0xA405, 3, struct.pack(order + "H", equivalent)))
    return entries


def canon(
    lens: str,
    *,
    setting: int | None = None,
    applied: int | None = None,
    lens_number: tuple[int, int, int] | None = None,
):
    """Offsets count from the EXIF block; nothing stands before the directory."""

    def notes(place: int, order: str) -> bytes:
        entries: list[Entry] = [(0x0095, 2, text(lens))] if lens else []
        if lens_number:
            number, low, high = lens_number
            values = [92, *([0] * 21), number, high, low, 1, *([0] * 20)]
            entries.append((0x0001, 3, struct.pack(f"{order}46H", *values)))
        if setting is not None:
            entries.append((0x4016, 4, struct.pack(f"{order}10i", 40, *([0] * 6), setting, 0, 0)))
        if applied is not None:
            rest = struct.pack(f"{order}12h", 26, 0, applied, *([1] * 9))
            entries.append((0x4015, 7, b"\0\x26" + rest))
        return packed(entries, place, order)

    return notes


def nikon(setting: int = 0, lens: Sequence[float] = ()) -> Callable[[int, str], bytes]:
    """A TIFF structure of its own."""

    def notes(place: int, order: str) -> bytes:
        entries: list[Entry] = [(0x002B, 7, b"0100" + bytes([setting]) + bytes(11))]
        if lens:
            numbers = [part for value in lens for part in (round(value * 10), 10)]
            entries.append((0x0084, 5, struct.pack(f"{order}8I", *numbers)))
        mark = b"II*\0" if order == "<" else b"MM\0*"
        return (
            b"Nikon\0\x02\x10\0\0" + mark + struct.pack(order + "I", 8) + packed(entries, 8, order)
        )

    return notes


def sony(setting: int) -> Callable[[int, str], bytes]:
    def notes(place: int, order: str) -> bytes:
        entries: list[Entry] = [(0x2013, 4, struct.pack(order + "I", setting))]
        return b"SONY DSC \0\0\0" + packed(entries, place + 12, order)

    return notes


def olympus(lens: str, setting: int | None = None, *, old: bool = False):
    """Two directories below; the old kind counts from the block, the new one from the notes."""

    def notes(place: int, order: str) -> bytes:
        mark = b"II" if order == "<" else b"MM"
        head = b"OLYMP\0\x02\0" if old else b"OLYMPUS\0" + mark + b"\x03\0"
        base = place if old else 0
        start = base + len(head)
        equipment: list[Entry] = [(0x0203, 2, text(lens))]
        settings: list[Entry] = []
        if setting is not None:
            settings = [(0x050B, 3, struct.pack(order + "H", setting))]
        first = start + 2 + 24 + 4
        one = packed(equipment, first, order)
        second = first + len(one)
        entries: list[Entry] = [
            (0x2010, 4, struct.pack(order + "I", first)),
            (0x2020, 4, struct.pack(order + "I", second)),
        ]
        return head + packed(entries, start, order) + one + packed(settings, second, order)

    return notes


def panasonic(lens: str) -> Callable[[int, str], bytes]:
    def notes(place: int, order: str) -> bytes:
        return b"Panasonic\0\0\0" + packed([(0x0051, 2, text(lens))], place + 12, order)

    return notes


def pentax(setting: int, *, old: bool = False) -> Callable[[int, str], bytes]:
    def notes(place: int, order: str) -> bytes:
        mark = b"II" if order == "<" else b"MM"
        head = b"AOC\0" + mark if old else b"PENTAX \0" + mark
        start = (place if old else 0) + len(head)
        return head + packed([(0x007D, 7, bytes([setting, 0, 0, 0]))], start, order)

    return notes

"""Size, camera, lens and focal length of a photograph, from its EXIF."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from html import unescape
from pathlib import Path
from typing import Any

import numpy as np

from plumbline.observations.facts import FULL_FRAME_MM, LensFacts
from plumbline.photos.cameras import agreed_crop, camera_name
from plumbline.photos.header import read_header
from plumbline.photos.maker_notes import read_maker_notes

_MAKE, _MODEL, _ORIENTATION = 0x010F, 0x0110, 0x0112
_FOCAL, _FOCAL_35MM, _LENS_MAKE, _LENS_MODEL = 0x920A, 0xA405, 0xA433, 0xA434
_WIDTH, _X_RESOLUTION, _Y_RESOLUTION, _UNIT = 0xA002, 0xA20E, 0xA20F, 0xA210
_HEIGHT = 0xA003
_SOFTWARE, _PROCESSING, _HISTORY = 0x0131, 0x000B, 0x9213
_DIGITAL_ZOOM = 0xA404
_MAKER_NOTES, _LENS_SPECIFICATION = 0x927C, 0xA432
"""Tags of EXIF (CIPA DC-008) and TIFF 6.0."""
_PROFILE = re.compile(rb"LensProfileEnable\s*(?:=\s*[\"']|>)\s*1\b")
_LENS_INFO = re.compile(rb"LensInfo\s*(?:=\s*[\"']|>)\s*(\d{1,9})/(\d{1,9}) (\d{1,9})/(\d{1,9})")
_XMP_LENS = re.compile(
    rb"(?:exifEX:LensModel|aux:Lens)\s*(?:=\s*[\"']|>(?:\s*<rdf:Alt>\s*<rdf:li[^>]*>)?)([^\"'<]{3,200})"
)
RANGE_ALONE = re.compile(r"[\d.]+(-[\d.]+)? ?mm( f/[\d.]+(-[\d.]+)?)?", re.IGNORECASE)
"""What programs write where they know a lens's focal lengths and not its name."""
_TAKEN, _CHANGED = 0x9003, 0x0132
_NO_LENS = ("none", "unknown", "no lens", "dt 0.0mm f0.0 sam")

_MM_PER_UNIT = {2: 25.4, 3: 10.0, 4: 1.0}


@dataclass(frozen=True)
class PhotoFacts:
    """What a photograph says of itself.

    Attributes:
        size: Width and height as a viewer shows it, the EXIF orientation applied.
        facts: Camera, lens, focal length and crop factor, as far as EXIF knows.
        turned: Whether the orientation exchanges width and height.
        name: Its file name.
        maker: Maker of the camera, as EXIF has it.
        model: Model of the camera, as EXIF has it.
        orientation: EXIF's orientation, 1 to 8; 1 is upright as stored.
        exif_size: Width and height as stored that EXIF tells of; None where it is silent.
        lens_range_mm: Shortest and longest focal length of the lens, if EXIF, XMP or maker notes
            tell it.
        lens_told_by: Who names the lens, where it is not EXIF itself; else empty.
        taken: EXIF's date and time, as it stands there; may be empty.
        history: What programs wrote of themselves, joined; may be empty.
        profile_applied: Whether XMP says that a lens profile was applied in developing.
        digital_zoom: By how much the camera enlarged the middle of what it saw; None if it did not.
        in_camera: What tells that the camera itself corrected the distortion; else empty.
        not_in_camera: What tells that it did not; else empty.
        notes: What to know of these facts, in plain sentences.
    """

    size: tuple[int, int]
    facts: LensFacts
    turned: bool = False
    name: str = ""
    maker: str = ""
    model: str = ""
    orientation: int = 1
    exif_size: tuple[int, int] | None = None
    lens_range_mm: tuple[float, float] | None = None
    history: str = ""
    profile_applied: bool = False
    digital_zoom: float | None = None
    in_camera: str = ""
    not_in_camera: str = ""
    lens_told_by: str = ""
    taken: str = ""
    notes: tuple[str, ...] = ()

    @property
    def stored_size(self) -> tuple[int, int]:
        """Width and height as stored, the EXIF orientation not applied."""
        width, height = self.size
        return (height, width) if self.turned else (width, height)

    def taken_as_corrected(self) -> PhotoFacts:
        """The same photo where it is meant to be corrected, so that signs of it do not warn."""
        return replace(
            self, history="", profile_applied=False, in_camera="", not_in_camera="told to be"
        )

    def naming(self, lens: str, told_by: str) -> PhotoFacts:
        """The same photo with the name of its lens, from elsewhere than EXIF."""
        return replace(self, facts=replace(self.facts, model=lens), lens_told_by=told_by)


def read_photo(path: str | Path, *, remedy: str = "") -> PhotoFacts:
    """Read the header of a photograph; its pixels are not decoded.

    Args:
        path: The file.
        remedy: What else the user can do if it cannot be read.

    Raises:
        ReadError: the file is missing, or not a picture that can be read.
    """
    hint = f"give a JPEG, TIFF, PNG or WebP{remedy}"
    header = read_header(path, hint)
    tags, packet = header.tags, header.packet
    orientation = int(_positive(tags, _ORIENTATION) or 1)
    turned = orientation in (5, 6, 7, 8)
    notes_of_maker = tags.get(_MAKER_NOTES)
    told = read_maker_notes(
        notes_of_maker if isinstance(notes_of_maker, bytes) else b"",
        header.block,
        _text(tags, _MAKE),
    )
    name, told_by = _lens_name(tags, packet, told.lens)
    facts, notes = _facts(tags, name)
    history = [*(_text(tags, t) for t in (_SOFTWARE, _PROCESSING, _HISTORY)), header.remark]
    width, height = header.size
    return PhotoFacts(
        (height, width) if turned else (width, height),
        facts,
        turned,
        name=Path(path).name,
        maker=_text(tags, _MAKE),
        model=_text(tags, _MODEL),
        orientation=orientation if orientation in range(1, 9) else 1,
        exif_size=_exif_size(tags),
        lens_range_mm=_lens_range(tags, packet) or told.range_mm,
        history="; ".join(filter(None, history)),
        profile_applied=_PROFILE.search(packet) is not None,
        digital_zoom=_digital_zoom(tags),
        in_camera=told.corrected,
        not_in_camera=told.uncorrected,
        lens_told_by=told_by,
        taken=_text(tags, _TAKEN) or _text(tags, _CHANGED),
        notes=notes,
    )


def _lens_name(tags: dict[int, Any], packet: bytes, by_maker: str) -> tuple[str, str]:
    """Name of the lens, and who tells it where EXIF does not."""
    own = _text(tags, _LENS_MODEL)
    if any(character.isalnum() for character in own) and own.casefold() not in _NO_LENS:
        return own, ""
    found = _XMP_LENS.search(packet)
    if found is not None:
        text = unescape(found.group(1).decode("utf-8", "replace"))
        name = " ".join("".join(c if c.isprintable() else " " for c in text).split())[:120]
        if any(character.isdigit() for character in name) and not RANGE_ALONE.fullmatch(name):
            return name, "XMP"
    return (by_maker, "the maker notes") if by_maker else ("", "")


def _exif_size(tags: dict[int, Any]) -> tuple[int, int] | None:
    width, height = _positive(tags, _WIDTH), _positive(tags, _HEIGHT)
    return (int(width), int(height)) if width and height else None


def _digital_zoom(tags: dict[int, Any]) -> float | None:
    ratio = _positive(tags, _DIGITAL_ZOOM)
    return ratio if ratio and 1 < ratio < 100 else None


def _lens_range(tags: dict[int, Any], packet: bytes) -> tuple[float, float] | None:
    found = _LENS_INFO.search(packet)
    try:
        if found is not None:
            numbers = [int(group) for group in found.groups()]
            low, high = numbers[0] / numbers[1], numbers[2] / numbers[3]
        else:
            low, high = (float(value) for value in tags[_LENS_SPECIFICATION][:2])
    except (KeyError, TypeError, ValueError, ZeroDivisionError):
        return None
    return (low, high) if 0 < low <= high < np.inf else None


def _facts(tags: dict[int, Any], lens: str) -> tuple[LensFacts, tuple[str, ...]]:
    make, camera = _text(tags, _MAKE), _text(tags, _MODEL)
    focal_mm = _positive(tags, _FOCAL)
    equivalent, by_sensor = _positive(tags, _FOCAL_35MM), _sensor_crop(tags)
    crop_factor, crop_factor_error, notes = agreed_crop(
        equivalent, focal_mm, by_sensor, make, camera
    )
    facts = LensFacts(
        maker=_text(tags, _LENS_MAKE) or make,
        model=lens,
        camera=camera_name(make, camera),
        exif_make=make,
        exif_model=camera,
        focal_mm=focal_mm,
        crop_factor=crop_factor,
        crop_factor_error=crop_factor_error,
    )
    return facts, notes


def _sensor_crop(tags: dict[int, Any]) -> float | None:
    sides = [_positive(tags, tag) for tag in (_WIDTH, _HEIGHT, _X_RESOLUTION, _Y_RESOLUTION)]
    width, height, across, down = sides
    unit = _MM_PER_UNIT.get(int(_positive(tags, _UNIT) or 2))
    if not (width and height and across and down and unit):
        return None
    crop = FULL_FRAME_MM / float(np.hypot(width / across, height / down) * unit)
    return crop if 0.2 < crop < 20 else None


def _text(tags: dict[int, Any], tag: int) -> str:
    value = tags.get(tag)
    if not isinstance(value, str):
        return ""
    return " ".join("".join(c if c.isprintable() else " " for c in value).split())[:120]


def _positive(tags: dict[int, Any], tag: int) -> float | None:
    try:
        value = float(tags[tag])
    except (KeyError, TypeError, ValueError, ZeroDivisionError):
        return None
    return value if np.isfinite(value) and value > 0 else None

"""Size, camera, lens and focal length of a photograph, from its EXIF."""

from __future__ import annotations

import re
import struct
import warnings
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from plumbline.errors import ReadError
from plumbline.observations.facts import FULL_FRAME_MM, LensFacts
from plumbline.photos.maker_notes import corrected_in_camera

_MAKE, _MODEL, _ORIENTATION, _EXIF_IFD = 0x010F, 0x0110, 0x0112, 0x8769
_FOCAL, _FOCAL_35MM, _LENS_MAKE, _LENS_MODEL = 0x920A, 0xA405, 0xA433, 0xA434
_WIDTH, _X_RESOLUTION, _Y_RESOLUTION, _UNIT = 0xA002, 0xA20E, 0xA20F, 0xA210
_HEIGHT = 0xA003
_SOFTWARE, _PROCESSING, _HISTORY = 0x0131, 0x000B, 0x9213
_DIGITAL_ZOOM = 0xA404
_MAKER_NOTES, _LENS_SPECIFICATION = 0x927C, 0xA432
_PROFILE = re.compile(rb"LensProfileEnable\s*(?:=\s*[\"']|>)\s*1\b")
_LENS_INFO = re.compile(rb"LensInfo\s*(?:=\s*[\"']|>)\s*(\d{1,9})/(\d{1,9}) (\d{1,9})/(\d{1,9})")
_SAMPLE_FORMAT, _FLOATING = 339, 3
_MM_PER_UNIT = {2: 25.4, 3: 10.0, 4: 1.0}

FLOATS = "32-bit float pictures are not supported"
FLOATS_HINT = "save it with 16 bits a channel"


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
        lens_range_mm: Shortest and longest focal length of the lens, if EXIF or XMP tell it.
        history: What programs wrote of themselves, joined; may be empty.
        profile_applied: Whether XMP says that a lens profile was applied in developing.
        digital_zoom: By how much the camera enlarged the middle of what it saw; None if it did not.
        in_camera: What tells that the camera itself corrected the distortion; else empty.
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

    @property
    def stored_size(self) -> tuple[int, int]:
        """Width and height as stored, the EXIF orientation not applied."""
        width, height = self.size
        return (height, width) if self.turned else (width, height)

    def taken_as_corrected(self) -> PhotoFacts:
        """The same photo where it is meant to be corrected: signs of it are no warning."""
        return replace(self, history="", profile_applied=False, in_camera="")


def read_photo(path: str | Path, *, remedy: str = "") -> PhotoFacts:
    """Read the header of a photograph; its pixels are not decoded.

    Args:
        path: The file.
        remedy: What else the user can do where it is none.

    Raises:
        ReadError: the file is missing or no picture that Pillow knows.
    """
    from PIL import Image, UnidentifiedImageError

    hint = f"give a JPEG, TIFF, PNG or WebP{remedy}"
    try:
        if not Path(path).is_file() and Path(path).exists():
            raise ReadError("this is no file", path=path, hint=hint)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with Image.open(path) as image:
                width, height = image.size
                exif = image.getexif()
                tags = dict(exif) | dict(exif.get_ifd(_EXIF_IFD))
                packet = image.info.get("xmp") or b""
    except FileNotFoundError:
        raise ReadError("there is no such photo", path=path, hint=hint) from None
    except UnidentifiedImageError:
        if _is_float_tiff(path):
            raise ReadError(FLOATS, path=path, hint=FLOATS_HINT) from None
        raise ReadError("this is no picture that can be read", path=path, hint=hint) from None
    except Image.DecompressionBombError:
        raise ReadError(
            "this picture claims to have more pixels than any camera", path=path, hint=hint
        ) from None
    except (
        OSError,
        ValueError,
        SyntaxError,
        LookupError,
        TypeError,
        EOFError,
        struct.error,
    ) as error:
        reason = (error.strerror if isinstance(error, OSError) else None) or error
        raise ReadError(f"the photo cannot be read: {reason}", path=path, hint=hint) from None
    orientation = int(_positive(tags, _ORIENTATION) or 1)
    turned = orientation in (5, 6, 7, 8)
    notes_of_maker = tags.get(_MAKER_NOTES)
    if turned:
        width, height = height, width
    return PhotoFacts(
        (width, height),
        _facts(tags),
        turned,
        name=Path(path).name,
        maker=_text(tags, _MAKE),
        model=_text(tags, _MODEL),
        orientation=orientation if orientation in range(1, 9) else 1,
        exif_size=_exif_size(tags),
        lens_range_mm=_lens_range(tags, packet if isinstance(packet, bytes) else b""),
        history="; ".join(
            filter(None, (_text(tags, t) for t in (_SOFTWARE, _PROCESSING, _HISTORY)))
        ),
        profile_applied=isinstance(packet, bytes) and _PROFILE.search(packet) is not None,
        digital_zoom=_digital_zoom(tags),
        in_camera=corrected_in_camera(notes_of_maker) if isinstance(notes_of_maker, bytes) else "",
    )


def _is_float_tiff(path: str | Path) -> bool:
    """Whether this is a TIFF of floating-point numbers, of which Pillow knows grey ones only."""
    from PIL.TiffImagePlugin import ImageFileDirectory_v2

    try:
        with Path(path).open("rb") as file, warnings.catch_warnings():
            warnings.simplefilter("ignore")
            directory = ImageFileDirectory_v2(file.read(8))
            file.seek(directory.next)
            directory.load(file)
            return _FLOATING in directory.get(_SAMPLE_FORMAT, ())
    except (OSError, ValueError, SyntaxError, LookupError, TypeError, struct.error):
        return False


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


def _facts(tags: dict[int, Any]) -> LensFacts:
    make, camera = _text(tags, _MAKE), _text(tags, _MODEL)
    focal_mm = _positive(tags, _FOCAL)
    crop_factor, crop_factor_error = _crop_factor(tags, focal_mm)
    return LensFacts(
        maker=_text(tags, _LENS_MAKE) or make,
        model=_text(tags, _LENS_MODEL),
        camera=camera if not make or camera.startswith(make) else f"{make} {camera}".strip(),
        exif_make=make,
        exif_model=camera,
        focal_mm=focal_mm,
        crop_factor=crop_factor,
        crop_factor_error=crop_factor_error,
    )


def _crop_factor(tags: dict[int, Any], focal_mm: float | None) -> tuple[float | None, float | None]:
    """From the size of the sensor where EXIF tells it, else from the 35-mm equivalent.

    The equivalent is rounded to whole millimetres: that error comes with it.
    """
    equivalent = _positive(tags, _FOCAL_35MM)
    by_focal = equivalent / focal_mm if equivalent and focal_mm else None
    by_sensor = _sensor_crop(tags)
    if by_sensor and (by_focal is None or abs(by_sensor / by_focal - 1) < 0.06):
        return by_sensor, None
    if by_focal is None or equivalent is None:
        return None, None
    return by_focal, 0.5 / equivalent


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

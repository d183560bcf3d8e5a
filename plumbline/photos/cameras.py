"""Cameras by name: one spelling, whether two are the same, and how large their sensors are."""

from __future__ import annotations

import re
from functools import cache
from typing import Any

_COMPANY = frozenset(
    (
        "corporation",
        "corp",
        "company",
        "co",
        "ltd",
        "inc",
        "gmbh",
        "ag",
        "imaging",
        "optical",
        "electronics",
        "techwin",
        "photo",
        "electric",
        "industries",
        "kabushiki",
        "kaisha",
    )
)
"""Words of makers' names in EXIF that people and databases leave out."""

_SAME_CROP = 0.06
"""Chosen because sensors of one name, and lengths of pixels in EXIF, differ by up to 5 %."""

_OTHER_PART = 0.12
"""A larger difference of crop factors is another part of the sensor: chosen because equivalents
by width and by diagonal differ by 4 % on 4:3 sensors and are rounded to whole millimetres, and
the mildest crop mode of a camera, Nikon's, is 1.2."""


def camera_name(maker: str, model: str) -> str:
    """Maker and model, the maker once."""
    if not maker or model.startswith(maker):
        return model
    return f"{maker} {model}".strip()


def same_camera(one: str, other: str) -> bool:
    """Whether two names mean one camera, however they spell its maker."""
    words, others = _words(one), _words(other)
    return bool(words) and words == others


def _words(name: str) -> frozenset[str]:
    words = re.split(r"[\s,._]+", name.casefold())
    return frozenset(words) - _COMPANY - {""}


def agreed_crop(
    equivalent: float | None,
    focal_mm: float | None,
    by_sensor: float | None,
    maker: str,
    model: str,
) -> tuple[float | None, float | None, tuple[str, ...]]:
    """The crop factor that EXIF's values and the database's camera speak for.

    Args:
        equivalent: EXIF's equivalent focal length, in whole millimetres.
        focal_mm: The focal length itself.
        by_sensor: The crop factor by EXIF's size in pixels and pixels a millimetre.
        maker: Maker of the camera, as EXIF has it.
        model: Model of the camera, as EXIF has it.

    Returns:
        The crop factor, its relative error where it is not exact, and what to tell.
    """
    by_focal = equivalent / focal_mm if equivalent and focal_mm else None
    error = 0.5 / equivalent if equivalent else None
    if by_sensor is None:
        return by_focal, error if by_focal else None, ()
    if by_focal and abs(by_sensor / by_focal - 1) < _SAME_CROP:
        return by_sensor, None, ()
    known = crop_factor_of(maker, model)
    said = f"EXIF's pixels a millimetre give a crop factor of {by_sensor:.4g}"
    if known and abs(by_sensor / known - 1) < _SAME_CROP:
        return by_sensor, None, ()
    if by_focal and not (known and by_focal < known * (1 - _OTHER_PART)):
        note = f"{said}, its equivalent focal length {by_focal:.4g}: the latter is taken"
        return by_focal, error, (f"{note} (--crop-factor)",)
    if known:
        note = f"{said}, LensFun's {model} has {known:.4g}: the latter is taken (--crop-factor)"
        return known, None, (note,)
    return by_sensor, None, ()


def shows_other_part(photo_crop: float, camera_crop: float) -> bool:
    """Whether a photo shows less of the sensor than the camera's crop factor says."""
    return photo_crop > camera_crop * (1 + _OTHER_PART)


@cache
def crop_factor_of(maker: str, model: str) -> float | None:
    """The crop factor of a camera in the LensFun database that comes with lensfunpy."""
    if not model:
        return None
    found = _library().find_cameras(maker or None, model)
    return float(found[0].crop_factor) if found else None


@cache
def _library() -> Any:
    from lensfunpy import (
        Database,  # pyright: ignore[reportAttributeAccessIssue]
    )

    return Database(load_common=False, load_bundled=True)

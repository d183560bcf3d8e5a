"""Cameras by name, and crop factors that contradict each other."""

from __future__ import annotations

import pytest

from plumbline.photos.cameras import agreed_crop, camera_name, crop_factor_of, same_camera
from tests.lenses.library import lensfunpy


@pytest.mark.parametrize(
    ("one", "other", "same"),
    [
        ("NIKON CORPORATION NIKON D5000", "Nikon D5000", True),
        ("OLYMPUS OPTICAL CO.,LTD C2500L", "Olympus C2500L", True),
        ("Canon Canon EOS 450D", "Canon EOS 450D", True),
        ("Canon EOS 450D", "Canon EOS 500D", False),
        ("", "", False),
    ],
)
def test_makers_are_spelled_in_many_ways(one: str, other: str, same: bool) -> None:
    assert same_camera(one, other) is same


def test_the_maker_stands_once() -> None:
    assert camera_name("Canon", "Canon EOS 450D") == "Canon EOS 450D"
    assert camera_name("SONY", "ILCE-7M3") == "SONY ILCE-7M3"
    assert camera_name("", "E995") == "E995"


def test_the_database_s_camera() -> None:
    library = lensfunpy.Database(load_common=False, load_bundled=True)
    (camera,) = library.find_cameras("Canon", "Canon EOS 6D")
    assert crop_factor_of("Canon", "Canon EOS 6D") == camera.crop_factor
    assert crop_factor_of("Nobody", "Nothing") is None
    assert crop_factor_of("", "") is None


@pytest.mark.parametrize(
    ("equivalent", "focal", "sensor", "expected", "exact", "told"),
    [
        (None, 35.0, 3.602, 1.005, True, "LensFun's Canon EOS 6D has 1.005"),  # resized
        (None, 35.0, 1.0, 1.0, True, ""),
        (56, 35.0, 3.602, 1.6, False, "its equivalent focal length 1.6"),  # resized, and a mode
        (35, 35.0, 3.602, 1.0, False, "its equivalent focal length 1"),
        (35, 35.0, 1.0, 1.0, True, ""),
        (56, 35.0, None, 1.6, False, ""),
        (None, None, None, None, True, ""),
    ],
)
def test_crop_factors(
    equivalent: float | None,
    focal: float | None,
    sensor: float | None,
    expected: float | None,
    exact: bool,
    told: str,
) -> None:
    crop, error, notes = agreed_crop(equivalent, focal, sensor, "Canon", "Canon EOS 6D")
    assert crop == (None if expected is None else pytest.approx(expected, rel=1e-3))
    assert (error is None) is exact
    assert told in "".join(notes)
    assert bool(notes) is bool(told)

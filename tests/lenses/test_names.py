"""Names of lenses: numbers that must agree, words that need not."""

from __future__ import annotations

import pytest

from plumbline.lenses.names import agree, likeness, numbers_of


@pytest.mark.parametrize(
    ("name", "range_mm", "apertures"),
    [
        ("EF-S18-55mm f/3.5-5.6 IS", (18, 55), (3.5, 5.6)),
        ("Canon EF 300mm f/4L IS USM", (300, 300), (4, 4)),
        ("FE 24-105mm F4 G OSS", (24, 105), (4, 4)),
        ("LUMIX G VARIO 14-42/F3.5-5.6", (14, 42), (3.5, 5.6)),
        ("AF Zoom 24-85mm 1:2.8-4", (24, 85), (2.8, 4)),
        ("smc Pentax-DA 10-17mm f/3.5-4.5 ED IF", (10, 17), (3.5, 4.5)),
        ("E995 & compatibles (Standard)", None, None),
        ("", None, None),
    ],
)
def test_numbers(
    name: str, range_mm: tuple[float, float] | None, apertures: tuple[float, float] | None
) -> None:
    found = numbers_of(name)
    assert (found.range_mm, found.apertures) == (range_mm, apertures)


@pytest.mark.parametrize(
    ("one", "other", "same"),
    [
        ("EF300mm f/4L IS USM", "Canon EF 70-300mm f/4-5.6L IS USM", False),
        ("EF300mm f/4L IS USM", "Canon EF 300mm f/2.8L IS USM", False),
        ("EF300mm f/4L IS USM", "Canon EF 300mm f/4L IS USM", True),
        ("18-55mm", "AF-S 18-55mm f/3.5-5.6G", True),
        ("anything", "AF-S 18-55mm f/3.5-5.6G", True),
    ],
)
def test_agreement(one: str, other: str, same: bool) -> None:
    assert agree(numbers_of(one), numbers_of(other)) is same


def test_likeness_tells_versions_apart() -> None:
    told = "EF70-200mm f/2.8L IS USM"
    assert likeness(told, "Canon EF 70-200mm f/2.8L IS USM") == 1
    assert likeness(told, "Canon EF 70-200mm f/2.8L IS II USM") < 1
    assert likeness(told, "Canon EF 70-200mm f/2.8L USM") < 1
    assert likeness("", "") == 0

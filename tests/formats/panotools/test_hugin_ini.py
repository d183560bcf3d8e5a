"""Hugin lens files."""

from __future__ import annotations

import pytest

from plumbline.errors import ReadError
from plumbline.formats.base import Source
from plumbline.formats.panotools.hugin_ini import HuginLens, hugin_ini, read_hugin_ini


def test_what_is_written_is_read_again() -> None:
    lens = HuginLens(
        (2048, 1536),
        {"a": 0.01, "b": -0.05, "c": 0.02, "d": 3.5, "e": -2.0},
        "rectilinear",
        50.25,
        4.843,
        "NIKON",
        "E995",
        8.2,
    )
    assert read_hugin_ini(Source("lens.ini", hugin_ini(lens, "made by plumbline"))) == lens


def test_a_fisheye_keeps_its_kind() -> None:
    text = "[Lens]\ntype=3\na=0\nb=0\nc=0\n"
    found = read_hugin_ini(Source("lens.ini", text.encode()))
    assert found.projection == "full-frame fisheye"
    assert found.size is None


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("hello", "not a Hugin lens file"),
        ("[Other]\na=1\n", "no [Lens]"),
        ("[Lens]\ntype=0\n", "no a, b, c"),
        ("[Lens]\na=1_0\nb=0\nc=0\n", "not a finite number"),
        ("[Lens]\na=x\nb=0\nc=0\n", "'x' stands where the value of a"),
        ("[Lens]\na=%(b)s\nb=0\nc=0\n", "stands where the value of a"),
    ],
)
def test_damage_ends_in_a_sentence(text: str, sentence: str) -> None:
    with pytest.raises(ReadError) as error:
        read_hugin_ini(Source("lens.ini", text.encode()))
    assert sentence in error.value.message
    assert error.value.hint

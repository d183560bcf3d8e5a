"""LensFun databases, written."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Mapping

import pytest
from hypothesis import given, strategies as st

from plumbline.errors import OptionError, UnsupportedModelError
from plumbline.formats.lens_files.lensfun import Distortion, LensfunLens, lensfun_xml, number

HEAD = LensfunLens("Sigma", "Sigma 18-35mm", "Canon EF", 1.613, 1.5)
ABC = {"a": 0.0123456789, "b": -0.0512345678, "c": 0.0}


def made(
    head: LensfunLens = HEAD,
    *entries: tuple[float, Mapping[str, float]],
    model: str = "ptlens",
) -> ET.Element:
    found = [Distortion(model, focal, values) for focal, values in entries or [(18.0, ABC)]]
    return ET.fromstring(lensfun_xml(head, found))


def test_the_structure_is_what_lensfun_takes_in_the_order_it_is_documented() -> None:
    root = made()
    assert (root.tag, root.attrib) == ("lensdatabase", {"version": "1"})
    (lens,) = root
    assert [child.tag for child in lens] == [
        "maker",
        "model",
        "mount",
        "cropfactor",
        "aspect-ratio",
        "calibration",
    ]
    assert [child.text for child in lens][:5] == [
        "Sigma",
        "Sigma 18-35mm",
        "Canon EF",
        "1.613",
        "1.5",
    ]
    (entry,) = lens.iterfind("calibration/*")
    assert entry.tag == "distortion"
    assert entry.attrib == {
        "model": "ptlens",
        "focal": "18",
        "a": "0.0123456789",
        "b": "-0.0512345678",
        "c": "0",
    }


def test_the_centre_is_written_where_it_is_not_the_images() -> None:
    lens = made(LensfunLens("a", "b", "c", 1.0, 1.5, centre=(0.0125, -0.5)))[0]
    assert lens.find("center") is not None
    assert lens.find("center").attrib == {"x": "0.0125", "y": "-0.5"}  # pyright: ignore[reportOptionalMemberAccess]


def test_several_focal_lengths_in_order() -> None:
    root = made(HEAD, (35.0, ABC), (18.0, ABC), (24.5, ABC))
    assert [e.attrib["focal"] for e in root.iter("distortion")] == ["18", "24.5", "35"]


def test_two_entries_of_one_focal_length_are_refused() -> None:
    with pytest.raises(OptionError, match="the same focal length") as caught:
        made(HEAD, (18.0, ABC), (18.0, ABC))
    assert caught.value.hint


@pytest.mark.parametrize(
    ("model", "names", "version"),
    [
        ("ptlens", "a b c", "1"),
        ("poly3", "k1", "1"),
        ("poly5", "k1 k2", "1"),
        ("acm", "k1 k2 k3 k4 k5", "2"),
    ],
)
def test_models_and_database_versions(model: str, names: str, version: str) -> None:
    values = {name: 0.1 + i for i, name in enumerate(names.split())}
    root = made(HEAD, (20.0, values), model=model)
    assert root.attrib["version"] == version
    (entry,) = root.iter("distortion")
    assert list(entry.attrib) == ["model", "focal", *names.split()]


@pytest.mark.parametrize("model", ["brown", "division", "radial:2,4", "opencv", "fov1", ""])
def test_models_that_lensfun_does_not_know(model: str) -> None:
    with pytest.raises(UnsupportedModelError, match="does not know the model") as caught:
        made(HEAD, (20.0, {}), model=model)
    assert "ptlens, poly3, poly5 or acm" in caught.value.hint


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_numbers_keep_seven_digits_without_an_exponent(value: float) -> None:
    text = number(value)
    assert re.fullmatch(r"-?\d+(\.\d+)?", text)
    assert float(text) == pytest.approx(value, rel=5e-8, abs=0)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (-0.0, "0"),
        (18.0, "18"),
        (-0.1, "-0.1"),
        (1 / 3, "0.333333333"),
        (1.2345e-7, "0.00000012345"),
        (-1e-12, "-0.000000000001"),
        (123456789012.0, "123456789000"),
    ],
)
def test_numbers(value: float, text: str) -> None:
    assert number(value) == text


@pytest.mark.parametrize(
    "name", ["A & B <c> \"d\" 'e'", "größe 18–35 ƒ/1.8", "]]>", "&amp;", "日本", "a---b--c-"]
)
def test_odd_names_come_back(name: str) -> None:
    head = LensfunLens(name, name, name, 1.5, 1.5, comment=f"after {name}")
    lens = made(head)[0]
    assert [lens.findtext(tag) for tag in ("maker", "model", "mount")] == [name] * 3


@given(st.text(), st.text(st.sampled_from("-> <!\n\x1b\ud800a")))
def test_no_text_breaks_the_file(name: str, comment: str) -> None:
    content = lensfun_xml(
        LensfunLens(name, name, name, 1.5, 1.5, comment=comment), [Distortion("ptlens", 1.0, ABC)]
    )
    root = ET.fromstring(content)
    visible = "".join(sign for sign in name if sign.isprintable())
    assert (root.findtext("lens/maker") or "") == visible


def test_the_comment_stands_before_the_lens_and_stays_legible() -> None:
    head = LensfunLens("a", "b", "c", 1.0, 1.5, comment="made by me (--maker) -")
    text = lensfun_xml(head, [Distortion("ptlens", 18.0, ABC)]).decode()
    assert text.startswith("<?xml version='1.0' encoding='UTF-8'?>\n<lensdatabase version=\"1\">\n")
    assert "    <!-- made by me (- -maker) -  -->\n    <lens>\n" in text
    assert text.endswith("</lensdatabase>\n")

"""Records of Panorama Tools scripts, one by one."""

from __future__ import annotations

import pytest
from hypothesis import given, strategies as st

from plumbline.errors import ReadError
from plumbline.formats.base import Source
from plumbline.formats.panotools.script import (
    MAX_RECORD_LENGTH,
    ImageRecord,
    decimal,
    encoded,
    fitted,
    kind_of,
    line_starts,
    masked,
    parse_image,
    readable,
    records,
    size_of,
    with_values,
)

SOURCE = Source("some.pto", b"i")


def image(text: str, *earlier: ImageRecord, row: int = 7) -> ImageRecord:
    return parse_image(SOURCE, row, text, earlier)


def test_numbers_of_an_image_by_name() -> None:
    found = image('i w1712 h1368 f0 v52.44 Ra0 Va1 Eev10.9 a0.03 b-.1 c+6e-2 d1. e0 g0 t0 n"x.jpg"')
    assert found.values == {
        "w": 1712,
        "h": 1368,
        "f": 0,
        "v": 52.44,
        "a": 0.03,
        "b": -0.1,
        "c": 0.06,
        "d": 1,
        "e": 0,
        "g": 0,
        "t": 0,
    }
    assert found.name == "x.jpg"
    assert found.links == {}


def test_capital_tokens_are_no_lens_values() -> None:
    found = image("i Va1 Vb2 Eev3 Er4 Ra5 TrX6 Tpp7 C0,9,0,9 D8 A9 B1 w4 h3")
    assert found.values == {"w": 4, "h": 3}


def test_the_order_of_tokens_and_tabs_do_not_matter() -> None:
    assert image('i\tn"x y.jpg"\tb-1\th3   w4\r').values == {"b": -1, "h": 3, "w": 4}
    assert image('i\tn"x y.jpg"\tb-1\th3   w4\r').name == "x y.jpg"


@pytest.mark.parametrize(
    "name", [" a5 ", r"C:\my photos\v9 b-3 w1.jpg", "t=0 f2.jpg", "", " c7 n d8", "=0"]
)
def test_tokens_within_a_name_are_part_of_the_name(name: str) -> None:
    found = image(f'i w4 h3 n"{name}" f0 a1')
    assert found.values == {"w": 4, "h": 3, "f": 0, "a": 1}
    assert found.name == name
    assert found.crop is None


def test_masking_keeps_every_place() -> None:
    text = 'i a1 n"b2 c3" d4 u"e5'
    assert masked(text) == "i a1 n_______ d4 u___"
    assert len(masked(text)) == len(text)


def test_links_take_the_value_of_the_first_image_in_the_chain() -> None:
    first = image("i w4 h3 a1 b2 c3")
    second = image("i w4 h3 a=0 b=0 c9", first)
    third = image("i w4 h3 a=1 b=1 c=1", first, second)
    assert second.values["a"] == 1
    assert second.links == {"a": 0, "b": 0}
    assert third.values == {"w": 4, "h": 3, "a": 1, "b": 2, "c": 9}
    assert third.links == {"a": 0, "b": 0, "c": 1}


def test_a_link_to_a_value_that_is_not_there_gives_none() -> None:
    assert "g" not in image("i g=0", image("i w4 h3")).values


@pytest.mark.parametrize("link", ["=1", "=2", "=-1", "=0.5", "=99999999999999999999"])
def test_links_that_point_nowhere_or_forward_or_to_themselves(link: str) -> None:
    with pytest.raises(ReadError, match=r"some\.pto, row 7: 'a=.*an earlier image") as caught:
        image(f"i w4 h3 a{link}", image("i w4 h3"))
    assert caught.value.hint


@pytest.mark.parametrize("value", ["=", "=x", "=nan", "=inf", "=1_0", "=٣"])
def test_links_that_are_no_number(value: str) -> None:
    with pytest.raises(ReadError, match=r"some\.pto, row 7: "):
        image(f"i w4 h3 v{value}", image("i"))


@pytest.mark.parametrize("value", ["nan", "inf", "-inf", "1e999", "x", "1,5", "{{p}}", "-", "1_0"])
@pytest.mark.parametrize("name", list("whfvabcdegt"))
def test_what_is_no_finite_number_is_refused_with_its_line(name: str, value: str) -> None:
    with pytest.raises(ReadError, match=r"^some\.pto, row 7: '") as caught:
        image(f"i w4 h3 {name}{value}")
    assert caught.value.line == 7
    assert caught.value.hint


@pytest.mark.parametrize("sides", ["", "w4", "h3", "w0 h3", "w-4 h3", "w4.5 h3", "w4 h0"])
def test_a_size_that_is_missing_or_makes_no_sense(sides: str) -> None:
    with pytest.raises(ReadError, match=r"row 7: the image has no size"):
        size_of(SOURCE, image(f"i {sides} f0"))


def test_sizes() -> None:
    assert size_of(SOURCE, image("i h3 w4.0")) == (4, 3)


@pytest.mark.parametrize(
    ("token", "words"),
    [
        ("f0", "rectilinear"),
        ("", "rectilinear"),
        ("f1", "panoramic"),
        ("f2", "circular fisheye"),
        ("f3", "full-frame fisheye"),
        ("f4", "equirectangular"),
        ("f8", "orthographic fisheye"),
        ("f10", "stereographic fisheye"),
        ("f20", "Thoby fisheye"),
        ("f21", "equisolid fisheye"),
        ("f77", "lens type f77"),
    ],
)
def test_lens_types_in_words(token: str, words: str) -> None:
    assert image(f"i w4 h3 {token}").projection == words


@pytest.mark.parametrize(
    ("text", "crop"),
    [
        ("i C1,2,3,4", (1, 2, 3, 4)),
        ("i C-825,3993,-33,4785 u1", (-825, 3993, -33, 4785)),
        ("i S1,2,3,4", None),
        ('i n" C1,2,3,4 "', None),
        ("i C1,2,3", None),
        ("i C" + "9" * 5000 + ",2,3,4", None),
    ],
)
def test_crops_that_move_the_centre(text: str, crop: tuple[int, ...] | None) -> None:
    assert image(text).crop == crop


def test_facts() -> None:
    facts = image("i w4 h3 f3 v50.5 a1 b2 c3 d4 e5 g6 t7").facts(("a",), 1.5)
    assert facts.stored == {"a": 1, "b": 2, "c": 3, "d": 4, "e": 5, "g": 6, "t": 7}
    assert (facts.hfov_deg, facts.crop_factor, facts.requested) == (50.5, 1.5, ("a",))
    assert facts.projection == "full-frame fisheye"


@pytest.mark.parametrize("angle", ["0", "-5", "180", "393.7"])
def test_a_field_of_view_that_no_rectilinear_lens_has_is_not_known(angle: str) -> None:
    assert image(f"i v{angle}").facts(None, None).hfov_deg is None


def test_kinds() -> None:
    kinds = ["i ", "c\tn0", "v", "", "i", "image", "#-hugin", " i w4", "*", "\ufeffi w"]
    assert [kind_of(text) for text in kinds] == ["i", "c", "", "", "", "", "", "", "", "i"]


def test_values_are_set_in_place_and_all_else_stays() -> None:
    text = 'i  w4\th3 a0.5 Ra0 b=0 c1 c2 d9.25 n"a7 b8" \r'
    done = with_values(text, {"a": 0.25, "b": 3.0, "c": 0.0, "d": 9.25, "e": -1.5}, {"b"})
    assert done == (
        'i  w4\th3 a0.250000000000000000 Ra0 b=0 c0 c0 d9.25 n"a7 b8" e-1.500000000000000000 \r'
    )


def test_links_are_cut_unless_they_are_to_stay() -> None:
    assert with_values("i a=0 b=0", {"a": 0.5, "b": 0.5}, {"b"}) == "i a0.500000000000000000 b=0"


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_decimals_read_back_exactly(value: float) -> None:
    assert float(decimal(value)) == value
    assert not decimal(value).endswith(".0")


@given(st.floats(-10, 10))
def test_fitted_values_keep_eighteen_decimals(value: float) -> None:
    text = fitted(value)
    assert abs(float(text) - value) <= 0.5e-18 + abs(value) * 1e-15
    assert text == "0" or len(text.partition(".")[2]) == 18


@given(st.binary(min_size=1).filter(lambda content: content.strip() and b"\0" not in content))
def test_any_bytes_come_back(content: bytes) -> None:
    if content[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return
    assert encoded(records(Source("x.pto", content))) == content


def test_parts_of_a_script_become_text_whatever_their_encoding() -> None:
    (utf8,) = records(Source("x", "i é".encode()))
    (latin,) = records(Source("x", "i é".encode("latin-1")))
    assert readable(utf8) == readable(latin) == "i é"


@pytest.mark.parametrize("content", [b"", b" \r\n\t\n", b"i w4\0h3"])
def test_empty_and_binary_files(content: bytes) -> None:
    with pytest.raises(ReadError, match=r"x\.pto: the file is (empty|binary)") as caught:
        records(Source("x.pto", content))
    assert caught.value.hint


def test_utf16_is_named() -> None:
    with pytest.raises(ReadError, match="UTF-16") as caught:
        records(Source("x.pto", "i w4 h3".encode("utf-16")))
    assert caught.value.hint


def test_absurd_sizes_are_refused_before_any_work() -> None:
    with pytest.raises(ReadError, match="has 2,000,002 lines"):
        records(Source("x.pto", b"i w4" + b"\n" * 2_000_001))
    with pytest.raises(ReadError, match=r"x\.pto, row 2: the line has 100,001 characters"):
        records(Source("x.pto", b"p\ni" + b"x" * MAX_RECORD_LENGTH))


def test_the_length_of_a_line_is_counted_in_characters() -> None:
    accented = "i n" + "é" * (MAX_RECORD_LENGTH - 3)
    assert records(Source("x.pto", f"p\n{accented}".encode())) == ["p", accented]
    content = f"p\n{accented}é\ni{'x' * MAX_RECORD_LENGTH}".encode()
    with pytest.raises(ReadError, match=r"x\.pto, row 2: the line has 100,001 characters"):
        records(Source("x.pto", content))


@given(st.lists(st.binary(max_size=6).filter(lambda line: not {0, 10} & {*line}), min_size=1))
def test_lines_start_where_the_one_before_has_ended(lines: list[bytes]) -> None:
    content = b"i" + b"\n".join(lines)
    starts = line_starts(Source("x.pto", content))
    spans = zip(starts[:-1].tolist(), starts[1:].tolist(), strict=True)
    assert [content[a:b].removesuffix(b"\n") for a, b in spans] == content.split(b"\n")

"""Control points of a script, whatever stands between them."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given, strategies as st

from plumbline.errors import ReadError
from plumbline.formats.base import Source
from plumbline.formats.panotools import point_records
from plumbline.formats.panotools.point_records import take_points

USUAL = "c n0 N0 x175.00064 y87.999336 X1533.999936 Y62.666712 t3"
numbers = st.floats(-1e6, 1e6).map(repr) | st.integers(-99, 99).map(str)
records = st.builds(
    "c n{} N{} x{} y{} X{} Y{} t{}{}".format,
    *[st.integers(0, 12)] * 2,
    *[numbers] * 4,
    st.integers(0, 400),
    st.sampled_from(["", "", " ", "\r", " \t"]),
)
others = st.sampled_from(
    ["", "c", "cn0 N0", "# c", "v a0", 'i w4 h3 n"\u00e9.jpg"', "p\r", "\ufeffc n0"]
)


def script(*texts: str) -> Source:
    return Source("x.pto", "\n".join(texts).encode())


@given(texts=st.lists(records | others, min_size=1, max_size=12), at_once=st.integers(1, 4))
def test_control_points_and_all_other_lines_keep_their_rows(texts: list[str], at_once: int) -> None:
    texts = [*texts, USUAL]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(point_records, "_AT_ONCE", at_once)
        points, rest = take_points(script(*texts))
    taken = {row: text for row, text in enumerate(texts, 1) if text.startswith("c ")}
    assert points.rows.tolist() == list(taken)
    assert rest == [(row, text) for row, text in enumerate(texts, 1) if row not in taken]
    expected = [
        [float(word) for word in re.findall(r"[nNxyXYt](\S+)", text)] for text in taken.values()
    ]
    found = np.column_stack((points.images, points.ends, points.kinds))
    assert found.tolist() == expected


@pytest.mark.parametrize("at_once", [1, 2, 8192])
def test_the_row_of_a_bad_record_is_named(monkeypatch: pytest.MonkeyPatch, at_once: int) -> None:
    monkeypatch.setattr(point_records, "_AT_ONCE", at_once)
    texts = ["# hugin", USUAL, USUAL, "i w10 h10", USUAL.replace("y87.999336", "y1-2"), USUAL]
    with pytest.raises(ReadError, match="row 5: '1-2'"):
        take_points(script(*texts))
    points, rest = take_points(script(*(texts[i] for i in (0, 1, 2, 3, 5))))
    assert rest == [(1, "# hugin"), (4, "i w10 h10")]
    assert points.rows.tolist() == [2, 3, 5]


def test_of_two_bad_records_the_first_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(point_records, "_AT_ONCE", 2)
    bad = [USUAL.replace("t3", kind) for kind in ("t3.0", "t3-")]
    with pytest.raises(ReadError, match=r"row 4: 't3\.0' is not a whole number"):
        take_points(script(USUAL, USUAL, USUAL, *bad))


@pytest.mark.parametrize("end", ["", "\n", "\r\n"])
def test_the_last_record_needs_no_end_of_line(end: str) -> None:
    points, rest = take_points(script("p", USUAL, USUAL + end))
    assert points.ends[1].tolist() == [175.00064, 87.999336, 1533.999936, 62.666712]
    assert rest == ([(1, "p"), (4, "")] if end else [(1, "p")])


def test_a_script_may_have_no_control_points() -> None:
    points, rest = take_points(script("p", "c"))
    assert rest == [(1, "p"), (2, "c")]
    assert points.ends.shape == (0, 4)
    assert points.images.shape == (0, 2)
    assert points.kinds.shape == points.rows.shape == (0,)

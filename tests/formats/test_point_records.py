"""Control points read in one go are those read one by one."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from plumbline.errors import ReadError
from plumbline.formats import point_records
from plumbline.formats.base import Source

USUAL = "c n0 N0 x175.00064 y87.999336 X1533.999936 Y62.666712 t3"
SOURCE = Source("x.pto", b"")
numbers = st.floats(-1e6, 1e6).map(repr) | st.integers(-99, 99).map(str)
records = st.builds(
    "c n{} N{} x{} y{} X{} Y{} t{}{}".format,
    *[st.integers(0, 12)] * 2,
    *[numbers] * 4,
    st.integers(0, 400),
    st.sampled_from(["", " ", "\r", " \t"]),
)


@given(texts=st.lists(records, min_size=1, max_size=6))
def test_usual_records_are_read_in_one_go(texts: list[str]) -> None:
    table = point_records.table_of(texts)
    assert table is not None
    points, rest = point_records.take_points(SOURCE, texts)
    assert rest == []
    assert np.array_equal(table[:, :2], points.images)
    assert np.array_equal(table[:, 2:6], points.ends)
    assert np.array_equal(table[:, 6], points.kinds)
    words = texts[-1].split()
    assert points.ends[-1].tolist() == [float(word[1:]) for word in words[3:7]]


@given(
    text=st.lists(
        st.sampled_from([*"cnNxyXYt0159.+-eE \t\r", "nan", "1e3", " x", " t"]), max_size=9
    )
    .map("".join)
    .flatmap(lambda junk: st.integers(0, len(USUAL)).map(lambda i: USUAL[:i] + junk + USUAL[i:]))
)
def test_odd_records_are_refused_or_read_the_same(text: str) -> None:
    assume(text.startswith(("c ", "c\t")))
    table = point_records.table_of([USUAL, text])
    if table is None:
        return
    points, _ = point_records.take_points(SOURCE, [USUAL, text])
    assert np.array_equal(table[:, 2:6], points.ends)
    assert np.array_equal(table[:, :2], points.images)


@pytest.mark.parametrize(
    "odd",
    [
        "c n0 N0 x y1-2 X3 Y4 t3",
        "c n0 N0 x1.2.3 y5 X6 Y t3",
        "c n0 N0 x1y2 X3 Y4 t3",
        "c n0 N0 x1 y2 X3 Y4",
        "c N0 n0 x1 y2 X3 Y4 t3",
        "c n0.5 N0 x1 y2 X3 Y4 t3",
        "c n-1 N0 x1 y2 X3 Y4 t3",
        "c n0 N0 x1e999 y2 X3 Y4 t3",
        "c n0 N0 xe5 y2 X3 Y4 t3",
        "c n0 N0 x1 2 y X3 Y4 t3",
    ],
)
def test_what_is_not_usual_is_left_to_the_careful_way(odd: str) -> None:
    assert point_records.table_of([USUAL, odd]) is None


def test_a_long_script_names_the_row_of_a_bad_record(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(point_records, "_MANY", 3)
    texts = ["# hugin", USUAL, USUAL, "i w10 h10", USUAL.replace("y87.999336", "y1-2"), USUAL]
    with pytest.raises(ReadError, match="line 5: '1-2'"):
        point_records.take_points(SOURCE, texts)
    points, rest = point_records.take_points(SOURCE, [texts[i] for i in (0, 1, 2, 3, 5)])
    assert rest == [(1, "# hugin"), (4, "i w10 h10")]
    assert points.rows.tolist() == [2, 3, 5]

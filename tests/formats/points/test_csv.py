"""Plain tables of points."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st

from plumbline.errors import ReadError
from plumbline.formats.base import ReadOptions, Source
from plumbline.formats.known import FORMATS
from plumbline.formats.points.csv import write
from plumbline.observations import Line, Observations, Origin, Photo

Picked = dict[str, list[tuple[float, float]]]


def read(text: str | bytes, path: str = "points.csv") -> Observations:
    content = text.encode() if isinstance(text, str) else text
    return FORMATS["csv"].read(Source(path, content), ReadOptions())


def picked(observations: Observations) -> Picked:
    return {line.label: [(x, y) for x, y in line.points_px.tolist()] for line in observations.lines}


def recognised(text: str | bytes) -> bool:
    content = text.encode() if isinstance(text, str) else text
    return FORMATS["csv"].recognises(Source("points.csv", content))


EXPECTED: Picked = {"left": [(10.5, 20.5), (11.25, 120.0)], "roof": [(5.0, 7.0)]}

SAME = {
    "plain": "line,x,y\nleft,10.5,20.5\nleft,11.25,120\nroof,5,7\n",
    "order and case": "Y,LINE,X\n20.5,left,10.5\n120,left,11.25\n7,roof,5\n",
    "units": "line,x_px,y [px]\nleft,10.5,20.5\nleft,11.25,120\nroof,5,7\n",
    "extra columns": "id,line,x,y,note\n1,left,10.5,20.5,a\n2,left,11.25,120,\n3,roof,5,7,b\n",
    "no header": "left,10.5,20.5\nleft,11.25,120\nroof,5,7\n",
    "semicolons and commas": "line;x;y\nleft;10,5;20,5\nleft;11,25;120\nroof;5;7\n",
    "tabs": "line\tx\ty\nleft\t10.5\t20.5\nleft\t11.25\t120\nroof\t5\t7\n",
    "tabs and commas": "left\t10,5\t20,5\nleft\t11,25\t120,0\nroof\t5,0\t7,0\n",
    "blanks": "line x y\n  left  10.5 20.5\nleft 11.25   120  \nroof 5 7\n",
    "byte-order mark": "\ufeffline,x,y\nleft,10.5,20.5\nleft,11.25,120\nroof,5,7\n",
    "CRLF": "line,x,y\r\nleft,10.5,20.5\r\nleft,11.25,120\r\nroof,5,7\r\n",
    "old Mac": "line,x,y\rleft,10.5,20.5\rleft,11.25,120\rroof,5,7",
    "comments": (
        "# by hand, \"Tuesday\n\nline,x,y\nleft,10.5,20.5\n# it's\n\nleft,11.25,120\nroof,5,7\n"
    ),
    "quotes": '"line","x","y"\n"left","10.5","20.5"\n"left", "11.25","120"\n"roof",5,7\n',
    "quoted commas": 'line,x,y\nleft,"10,5","20,5"\nleft,"11,25","120"\nroof,"5","7"\n',
    "not contiguous": "line,x,y\nleft,10.5,20.5\nroof,5,7\nleft,11.25,120\n",
    "empty cells": "line,x,y,\nleft,10.5,20.5,\n,,,\nleft,11.25,120,,\nroof,5,7\n",
    "signs and exponents": "line,x,y\nleft,+1.05e1,2.05E+1\nleft,1125e-2,12e1\nroof,5.,07\n",
    "underscores": "line,x,y,my_note\nleft,10.5,20.5,ä\nleft,11.25,120,ö\nroof,5,7,ü\n",
}


@pytest.mark.parametrize("name", SAME)
def test_the_same_points_in_every_dialect(name: str) -> None:
    observations = read(SAME[name])
    assert picked(observations) == EXPECTED
    assert recognised(SAME[name])
    assert [photo.size for photo in observations.photos] == [None]


def test_utf16() -> None:
    assert picked(read(SAME["plain"].encode("utf-16"))) == EXPECTED
    assert recognised(SAME["plain"].encode("utf-16"))


@pytest.mark.parametrize("separator", [",", ";", "\t", " "])
@pytest.mark.parametrize("gap", ["\n", "# next\n", "\n\n# next\n\n"])
def test_gaps_part_the_lines_of_two_columns(separator: str, gap: str) -> None:
    rows = [f"1.5{separator}2\n", f"3{separator}4\n", gap, f"5{separator}6\n"]
    assert picked(read("".join(rows))) == {"1": [(1.5, 2.0), (3.0, 4.0)], "2": [(5.0, 6.0)]}


def test_a_header_without_line_uses_gaps_too() -> None:
    assert picked(read("y,x\n1,2\n\n3,4\n")) == {"1": [(2.0, 1.0)], "2": [(4.0, 3.0)]}


def test_rows_count_from_one_in_the_file() -> None:
    observations = read("# c\nline,x,y\r\na,1,1\r\n\r\nb,2,2\r\na,3,3\r\n")
    rows = {line.label: line.rows for line in observations.lines}
    assert rows["a"] is not None
    assert rows["b"] is not None
    assert rows["a"].tolist() == [3, 6]
    assert rows["b"].tolist() == [5]


def test_photos_tell_lines_of_the_same_name_apart() -> None:
    observations = read("image,line,x,y\na.jpg,l,1,2\nb.jpg,l,3,4\na.jpg,l,5,6\n")
    assert [photo.name for photo in observations.photos] == ["a.jpg", "b.jpg"]
    assert [photo.lens for photo in observations.photos] == [0, 0]
    found = [(line.photo, line.label, line.points_px.tolist()) for line in observations.lines]
    assert found == [(0, "l", [[1, 2], [5, 6]]), (1, "l", [[3, 4]])]


ERRORS = {
    "": "empty",
    "line,x,y\n": "no points",
    "# nothing\n\n": "no points",
    "line,x,y\na,1,two\n": "'two'",
    "line,x,y\na,1,\n": "''",
    "line,x,y\na,1,nan\n": "not a finite number",
    "line,x,y\na,1,inf\n": "not a finite number",
    "line,x,y\na,1,1e999\n": "not a finite number",
    "line,x,y\na,1,1_0\n": "'1_0'",
    "line,x,y\na,1,١\n": "'١'",
    "line,x,y\na,1\n": "2 columns where 3",
    "line,x,y\na,1,5,2,5\n": "5 columns where 3",
    "1,10,20\n1,10\n": "2 columns where 3",
    "1,10,5,20,5\n": "neither a header",
    "hello\n": "neither a header",
    "x,y,x,y\n1,2,3,4\n": "two columns are named x",
    "line,x,y\n,1,2\n": "names no line",
    "photo,line,x,y\n,a,1,2\n": "names no photo",
    "line;x;y\na;1,5;2.5\n": "decimal",
    "line;x;y\na;1.234,5;2\n": "'1.234,5'",
    'line,x,y\n"a,1,2\n': "quotation mark",
    'line,x,y\n"a"b"",1,2\n': "cannot be split",
    "line,x,y\n" + "a" * 200_000 + ",1,2\n": "cannot be split",
    "1" * 1_000_001: "1,000,001 characters",
}


@pytest.mark.parametrize("text", ERRORS, ids=range(len(ERRORS)))
def test_errors_name_what_is_wrong(text: str) -> None:
    with pytest.raises(ReadError) as caught:
        read(text)
    assert ERRORS[text] in caught.value.message
    assert caught.value.path == "points.csv"


def test_errors_name_the_line() -> None:
    with pytest.raises(ReadError) as caught:
        read("# comment\nline,x,y\n\na,1,2\na,1,oops\n")
    assert caught.value.line == 5
    assert caught.value.hint


@pytest.mark.parametrize(
    "text",
    [
        "",
        "hello world\nthis is prose",
        " ,Area,X,Y\n1,0,5,6\n",
        "roof,,left,\nX,Y,X,Y\n1,2,3,4\n",
        "filename,file_size,region_shape_attributes\n",
        '{"shapes": []}',
        "<annotations/>",
        "# hugin project file\np f0 w3000\n",
        "  Shape1\n  a\n  b\n  0.1 0.2\n",
        b"\x00\x01\x02",
        b"\xff\xfe\x00",
    ],
)
def test_other_files_are_not_claimed(text: str | bytes) -> None:
    assert not recognised(text)


def test_too_many_lines_are_refused_at_once() -> None:
    with pytest.raises(ReadError, match="more than the"):
        read(b"\n" * 6_000_000 + b"1,2\n")


NUMBERS = st.floats(allow_nan=False, allow_infinity=False)
LABELS = st.one_of(st.text(max_size=12), st.sampled_from(["#a", '"', " b ", "a,b", "x\ny", "1"]))


@st.composite
def drawn(draw: st.DrawFn) -> Observations:
    photos = draw(st.integers(1, 3))
    lines = [
        Line(
            np.array(draw(st.lists(st.tuples(NUMBERS, NUMBERS), min_size=1, max_size=5))),
            draw(st.integers(0, photos - 1)),
            draw(LABELS),
        )
        for _ in range(draw(st.integers(1, 6)))
    ]
    names = [draw(LABELS) for _ in range(photos)]
    return Observations(tuple(Photo(None, name) for name in names), tuple(lines))


@given(drawn())
def test_written_points_are_read_back_exactly(observations: Observations) -> None:
    text = write(observations)
    back = read(text)
    assert len(back.lines) == len(observations.lines)
    for line, again in zip(observations.lines, back.lines, strict=True):
        assert again.points_px.tobytes() == line.points_px.tobytes()
    # Labels are clean by now, and so are kept to the letter.
    assert write(back) == text or len(back.photos) < len(observations.photos)


@given(drawn())
def test_written_lines_lie_on_the_same_photos(observations: Observations) -> None:
    back = read(write(observations))
    pairs = {
        (line.photo, again.photo)
        for line, again in zip(observations.lines, back.lines, strict=True)
    }
    assert len(pairs) == len({line.photo for line in observations.lines}) == len(back.photos)


def test_the_writer_names_photos_only_where_there_are_several() -> None:
    points = np.array([[0.1, 0.2], [1e-300, -0.0]])
    one = Observations((Photo(None),), (Line(points, 0, "a, b"), Line(points[:1], 0, "#c")))
    assert write(one).decode() == 'line,x,y\n"a, b",0.1,0.2\n"a, b",1e-300,-0.0\n"#c",0.1,0.2\n'
    two = Observations((Photo(None, "p.jpg"), Photo(None)), (Line(points[:1], 1, "a"),))
    assert write(two).decode() == "line,x,y,photo\na,0.1,0.2,1\n"


def test_the_writer_keeps_the_order_of_a_table_and_groups_other_files() -> None:
    table = "line,x,y\nb,3.0,4.0\na,1.0,2.0\n#\nb,5.0,6.0\na,1.5,2.5\n"
    raw = read(table.encode())
    grouped = "line,x,y\nb,3.0,4.0\nb,5.0,6.0\na,1.0,2.0\na,1.5,2.5\n"
    assert write(raw).decode() == grouped
    of_table = replace(raw, origins=(Origin("p.csv", "csv", b""),))
    assert write(of_table).decode() == table.replace("#\n", "")
    assert write(replace(raw, origins=(Origin("p.mrf", "winmorph", b""),))).decode() == grouped
    assert write(replace(of_table, origins=of_table.origins * 2)).decode() == grouped

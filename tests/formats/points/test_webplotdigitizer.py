"""All datasets of WebPlotDigitizer. Pixel edges there, centres here: 0.5 less."""

from __future__ import annotations

import pytest

from plumbline.errors import ReadError
from plumbline.formats.base import ReadOptions, Source
from plumbline.formats.known import FORMATS
from plumbline.observations import Observations

SAMPLE = "roof,,left wall,\nX,Y,X,Y\n10.5,20.5,5.25,7.75\n120,21,5.5,80\n231,22.5,,\n"
EXPECTED = {
    "roof": [[10.0, 20.0], [119.5, 20.5], [230.5, 22.0]],
    "left wall": [[4.75, 7.25], [5.0, 79.5]],
}


def read(text: str) -> Observations:
    return FORMATS["webplotdigitizer"].read(
        Source("wpd_datasets.csv", text.encode()), ReadOptions()
    )


@pytest.mark.parametrize(
    "text",
    [
        SAMPLE,
        "\ufeff" + SAMPLE.replace("\n", "\r\n"),
        SAMPLE.replace(",,\n", "\n").replace("wall,", "wall"),
        SAMPLE.replace("roof", '"roof"').replace("X,Y", "x,y"),
        SAMPLE.replace(",", ";").replace(".", ","),
        "roof,,left wall,,\nX,Y,X,Y,\n10.5,20.5,5.25,7.75,\n120,21,5.5,80,\n231,22.5,,,\n",
    ],
)
def test_one_line_a_dataset(text: str) -> None:
    observations = read(text)
    assert {line.label: line.points_px.tolist() for line in observations.lines} == EXPECTED
    rows = [line.rows.tolist() for line in observations.lines if line.rows is not None]
    assert rows == [[3, 4, 5], [3, 4]]
    assert FORMATS["webplotdigitizer"].recognises(Source("wpd_datasets.csv", text.encode()))


def test_a_single_dataset_and_a_gap() -> None:
    assert read("Default Dataset,\nX,Y\n1,2\n\n3,4\n").lines[0].points_px.tolist() == [
        [0.5, 1.5],
        [2.5, 3.5],
    ]


def test_names_that_repeat_or_lack() -> None:
    labels = [line.label for line in read("a,,a,,,\nX,Y,X,Y,X,Y\n1,2,3,4,5,6\n").lines]
    assert labels == ["a", "a (2)", "1"]


def test_empty_datasets_are_named_in_a_note() -> None:
    observations = read("a,,b,\nX,Y,X,Y\n1,2,,\n")
    assert [line.label for line in observations.lines] == ["a"]
    assert "1 shape left aside (1 × dataset without points)" in observations.notes[0]


@pytest.mark.parametrize(
    ("text", "message", "line"),
    [
        ("", "empty", None),
        ("a,,b,\n", "not X, Y", 2),
        ("a,,b,\nX,Y,X,Label\n1,2,3,4\n", "not X, Y", 2),
        ("a,b,c,d\nX,Y,X,Y\n1,2,3,4\n", "names of the first row", 1),
        ("a,,b,\nX,Y,X,Y\n1,2,3,\n", "''", 3),
        ("a,,b,\nX,Y,X,Y\n1,2,3\n", "''", 3),
        ("a,\nX,Y\n1,2\nNaN,2\n", "not a finite number", 4),
        ("a,\nX,Y\n1,2,3\n", "more columns", 3),
        ("a,\nX,Y\n1,b\n", "'b'", 3),
        ("a,\nX,Y\n\n", "no line", None),
        ("a," * 10_001 + "\n" + "X,Y," * 10_001 + "\n", "10,001 datasets", 2),
    ],
)
def test_errors(text: str, message: str, line: int | None) -> None:
    with pytest.raises(ReadError) as caught:
        read(text)
    assert message in caught.value.message
    assert caught.value.line == line


@pytest.mark.parametrize(
    "text",
    ["", "line,x,y\n1,2,3\n", "x,y\n1,2\n", "1,2\nx,y\n", "a,,b,\nX,Y,Z,Y\n", " ,X,Y\n1,2,3\n"],
)
def test_other_files_are_not_claimed(text: str) -> None:
    assert not FORMATS["webplotdigitizer"].recognises(Source("points.csv", text.encode()))


def test_names_may_stand_over_both_columns() -> None:
    text = "roof,roof,wall,wall\nX,Y,X,Y\n1,2,3,4\n5,6,7,8\n"
    assert FORMATS["webplotdigitizer"].recognises(Source("a.csv", text.encode()))
    assert [line.label for line in read(text).lines] == ["roof", "wall"]

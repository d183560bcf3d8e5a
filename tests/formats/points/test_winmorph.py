"""WinMorph projects. A photo of 2000x1000: x = fraction × 2000 − 0.5, y = × 1000 − 0.5."""

from __future__ import annotations

import pytest

from plumbline.errors import ReadError
from plumbline.formats.base import Order, ReadOptions, Source
from plumbline.formats.known import FORMATS
from plumbline.observations import Observations

SIZE = (2000, 1000)
HEAD = "WinMorph\n  Shape1\n  unknown\n  0 1 2\n"
ROWS = [
    ("0.100000", "0.200000"), ("0.200000", "0.201000"), ("0.300000", "0.200000"),
    ("0.100000", "0.400000"), ("0.200000", "0.401000"), ("0.300000", "0.400000"),
]  # fmt: skip
ONE = HEAD + "".join(f"  {x} {y}\n" for x, y in ROWS[:3]) + "  Sets = 0\nrest 1 2\n"
GRID = HEAD + "".join(f"  {x} {y}\n" for x, y in ROWS) + "  Sets = 0\n"
ROW_1, ROW_2 = [[199.5, 199.5], [399.5, 200.5], [599.5, 199.5]], [
    [199.5, 399.5], [399.5, 400.5], [599.5, 399.5],
]  # fmt: skip


def read(
    text: str,
    *,
    size: tuple[int, int] | None = SIZE,
    grid: tuple[int, int] | None = None,
    order: Order = "raster",
) -> Observations:
    return FORMATS["winmorph"].read(
        Source("grid.mrf", text.encode()), ReadOptions(size, grid, order)
    )


def points(observations: Observations) -> dict[str, list[list[float]]]:
    return {
        line.label: [[round(x, 9), round(y, 9)] for x, y in line.points_px.tolist()]
        for line in observations.lines
    }


@pytest.mark.parametrize(
    "text",
    [
        ONE,
        ONE.replace("\n", "\r\n"),
        ONE.replace("Shape1", "SHAPE one").replace("unknown", "").replace("Sets = 0", "sets=0"),
        HEAD + "".join(f"{x};{y}\n" for x, y in ROWS[:3]),
        HEAD + "".join(f"{x}, {y}\n" for x, y in ROWS[:3]),
        HEAD + "".join(f"{x},{y}\n" for x, y in ROWS[:3]),
        HEAD + "".join(f"{x}\t{y}\n" for x, y in ROWS[:3]).replace(".", ","),
        HEAD + "".join(f"{x};{y}\n" for x, y in ROWS[:3]).replace(".", ","),
        HEAD + "".join(f"{x},{y}\n" for x, y in ROWS[:3]).replace(".", ","),
    ],
)
def test_one_shape_is_one_line(text: str) -> None:
    observations = read(text)
    assert list(points(observations).values()) == [ROW_1]
    rows = observations.lines[0].rows
    assert rows is not None
    assert rows.tolist() == [5, 6, 7]
    assert observations.photos[0].size == SIZE
    assert FORMATS["winmorph"].recognises(Source("grid.mrf", text.encode()))


def test_other_rows_are_left_aside_with_a_note() -> None:
    lines = ONE.splitlines()
    observations = read("\n".join([*lines[:5], "a comment", "1 2 3", *lines[5:]]))
    assert points(observations) == {"Shape1": ROW_1}
    assert observations.notes == ("2 rows without a pair of numbers left aside",)


def test_points_too_near_the_header_are_told() -> None:
    observations = read("Shape1\n" + "".join(f"{x} {y}\n" for x, y in ROWS))
    assert observations.n_points == 4
    assert "2 rows left aside for standing in the two after the header" in observations.notes[0]


def test_several_shapes_are_one_line_each() -> None:
    other = "".join(f"  {x} {y}\n" for x, y in ROWS[3:])
    observations = read(ONE + "  Shape1\n\n\n" + other + "Sets = 0\n  Shape3\n a\n b\nSets = 0\n")
    assert points(observations) == {"Shape1": ROW_1, "Shape1 (2)": ROW_2}


def test_a_grid_in_rows_and_columns() -> None:
    observations = read(GRID, grid=(2, 3))
    expected = {"row 1": ROW_1, "row 2": ROW_2}
    expected |= {f"column {n + 1}": [ROW_1[n], ROW_2[n]] for n in range(3)}
    assert points(observations) == expected
    assert [line.rows.tolist() for line in observations.lines if line.rows is not None] == [
        [5, 6, 7], [8, 9, 10], [5, 8], [6, 9], [7, 10],
    ]  # fmt: skip


def test_a_grid_back_and_forth() -> None:
    ordered = ROWS[:3] + ROWS[:2:-1]
    text = HEAD + "".join(f"{x} {y}\n" for x, y in ordered)
    assert points(read(text, grid=(2, 3), order="zigzag")) == points(read(GRID, grid=(2, 3)))
    rows = read(text, grid=(2, 3), order="zigzag").lines[1].rows
    assert rows is not None
    assert rows.tolist() == [10, 9, 8]


@pytest.mark.parametrize(
    ("text", "size", "grid", "message", "hint"),
    [
        (ONE, None, None, "size is not known", "--size WIDTHxHEIGHT"),
        (GRID, SIZE, (2, 2), "holds 6 points, but a grid of 2x2 has 4", "--grid"),
        (GRID, SIZE, (-2, -3), "has 6", "--grid"),
        (GRID + GRID, SIZE, (2, 3), "the file holds 2", "--grid"),
        ("no shape\n0.1 0.2\n", SIZE, None, "no shape", "polyline"),
        ("Shape1\na\nb\nSets = 0\n0.1 0.2\n", SIZE, None, "no shape", "polyline"),
        (ONE.replace("0.100000", "1e999"), SIZE, None, "inf 0.2 are not fractions", "0 to 1"),
        (ONE.replace("0.100000", "1e308"), SIZE, None, "not fractions of the photo", "0 to 1"),
        (GRID.replace("0.1000", "2.1000"), SIZE, (2, 3), "not fractions of the photo", "0 to 1"),
        ("", SIZE, None, "empty", ""),
    ],
)
def test_errors(
    text: str,
    size: tuple[int, int] | None,
    grid: tuple[int, int] | None,
    message: str,
    hint: str,
) -> None:
    with pytest.raises(ReadError) as caught:
        read(text, size=size, grid=grid)
    assert message in caught.value.message
    assert hint in caught.value.hint


def test_a_bent_line_is_no_grid() -> None:
    # A parabola with a sagitta of a tenth of its length, picked to and fro.
    places = [0, 8, 1, 7, 2, 6, 3, 5, 4]
    rows = "".join(f"{0.1 + t / 10:.6f} {0.1 + 0.02 * (t - 4) ** 2 / 16:.6f}\n" for t in places)
    assert len(read(HEAD + rows).lines[0].points_px) == 9


@pytest.mark.parametrize(
    ("path", "text"),
    [("a.mrf", "0.1 0.2"), ("a.txt", "Shape1\n"), ("a.csv", "line,x,y\n1,2,3\n"), ("a", "")],
)
def test_other_files_are_not_claimed(path: str, text: str) -> None:
    assert not FORMATS["winmorph"].recognises(Source(path, text.encode()))


def test_it_is_recognised_without_its_suffix() -> None:
    assert FORMATS["winmorph"].recognises(Source("a.txt", ONE.encode()))

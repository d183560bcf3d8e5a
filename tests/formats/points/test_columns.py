"""Which column of a table names the lines."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from plumbline.formats.base import Source
from plumbline.formats.known import FORMATS
from plumbline.observations import Observations

ALONG = np.linspace(-1, 1, 7)
EDGES = {
    name: np.column_stack([400 + 380 * ALONG, y + (y - 300) / 30 * (ALONG**2 - 1)]).round(2)
    for name, y in (("top", 20.0), ("upper", 45.0), ("middle", 210.0), ("low", 560.0))
}
EDGES["left"] = np.column_stack([30 + 12 * ALONG**2, 300 + 250 * ALONG]).round(2)
EDGES["right"] = np.column_stack([770 - 12 * ALONG**2, 300 + 250 * ALONG]).round(2)
ROWS = [
    {"edge": name, "number": n, "x": x, "y": y, "point": i}
    for n, (name, points) in enumerate(EDGES.items(), start=1)
    for i, (x, y) in enumerate(points)
]


def read(*columns: tuple[str, Sequence[object]], shuffled: bool = False) -> Observations:
    """A table of these columns and x and y."""
    order = np.random.default_rng(2).permutation(len(ROWS)) if shuffled else range(len(ROWS))
    text = ",".join([*(name for name, _ in columns), "x", "y"]) + "\n"
    for i in order:
        cells = [str(values[i]) for _, values in columns]
        text += ",".join([*cells, str(ROWS[i]["x"]), str(ROWS[i]["y"])]) + "\n"
    return FORMATS["csv"].read(Source("points.csv", text.encode()))


def of(name: str) -> list[object]:
    return [row[name] for row in ROWS]


def every(*values: object) -> list[object]:
    """These values over and over."""
    return [values[i % len(values)] for i in range(len(ROWS))]


def labels(observations: Observations) -> list[str]:
    return [line.label for line in observations.lines]


NAMES = (
    "line_id", "lineid", "LineID", "line no", "polyline", "polyline_id", "series", "segment", "id",
    "name", "edge", "edge_name", "row", "Kante", "Linie", "Strecke", "ligne", "track", "feature",
    "object", "part", "Bezeichnung",
)  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("shuffled", [False, True])
@pytest.mark.parametrize("value", ["edge", "number"])
def test_natural_names(name: str, shuffled: bool, value: str) -> None:
    found = read((name, of(value)), shuffled=shuffled)
    assert sorted(labels(found)) == sorted({str(row[value]) for row in ROWS})
    assert [len(line.points_px) for line in found.lines] == [7] * 6
    assert found.notes == ()


@pytest.mark.parametrize(
    "other",
    [
        ("visible", every(1, 1, 0)),
        ("quality", every("good", "fair", "poor", "good")),
        ("point", of("point")),
        ("wall", ["a"] * 14 + ["b"] * 28),
        ("direction", ["h"] * 28 + ["v"] * 14),
        ("group", ["h"] * 28 + ["v"] * 14),
        ("label", list(range(len(ROWS)))),
        ("weight", (np.arange(len(ROWS)) / 7).tolist()),
        ("series", ["s"] * len(ROWS)),
        ("empty", [""] * len(ROWS)),
    ],
    ids=lambda other: str(other[0]),
)
@pytest.mark.parametrize("first", [True, False])
def test_other_columns_are_passed_over_and_named(
    other: tuple[str, list[object]], first: bool
) -> None:
    pair = [other, ("kennung", of("edge"))] if first else [("kennung", of("edge")), other]
    found = read(*pair)
    assert labels(found) == list(EDGES)
    assert found.notes == (f"column kennung names the lines; column {other[0]} was ignored",)


def test_a_column_called_line_always_counts() -> None:
    found = read(("line", ["h"] * 28 + ["v"] * 14), ("edge", of("edge")))
    assert labels(found) == ["h", "v"]


def test_two_columns_that_say_the_same() -> None:
    found = read(("nr", of("number")), ("edge", of("edge")))
    assert labels(found) == list(EDGES)


def test_nothing_names_the_lines() -> None:
    found = read(("left", [0] * 42), ("right", [0] * 42))
    assert len(found.lines) == 1
    assert found.notes == ("no column names the lines (columns left, right ignored)",)


def test_blank_rows_part_the_lines() -> None:
    text = "x,y,visible\n"
    for points in EDGES.values():
        text += "".join(f"{x},{y},{i % 2}\n" for i, (x, y) in enumerate(points)) + "\n"
    found = FORMATS["csv"].read(Source("points.csv", text.encode()))
    assert labels(found) == ["1", "2", "3", "4", "5", "6"]
    assert found.notes == ("column visible was ignored",)


def test_two_lines_near_each_other() -> None:
    rows = ROWS[:14]
    text = "strich,x,y\n" + "".join(f"{r['edge']},{r['x']},{r['y']}\n" for r in rows)
    found = FORMATS["csv"].read(Source("points.csv", text.encode()))
    assert labels(found) == ["top", "upper"]


def test_one_line_with_a_name() -> None:
    rows = ROWS[:7]
    text = "edge,x,y\n" + "".join(f"{r['edge']},{r['x']},{r['y']}\n" for r in rows)
    assert labels(FORMATS["csv"].read(Source("points.csv", text.encode()))) == ["top"]


def test_lines_of_several_photos() -> None:
    text = "file,strich,x,y\n"
    for photo in ("a.jpg", "b.jpg"):
        text += "".join(f"{photo},{r['number']},{r['x']},{r['y']}\n" for r in ROWS)
    found = FORMATS["csv"].read(Source("points.csv", text.encode()))
    assert [photo.name for photo in found.photos] == ["a.jpg", "b.jpg"]
    assert labels(found) == [str(n) for n in range(1, 7)] * 2


@pytest.mark.parametrize(
    "pair", [("x_px", "y_px"), ("pos_x", "pos_y"), ("X [px]", "Y [px]"), ("x coord", "y coord")]
)
def test_names_of_the_axes(pair: tuple[str, str]) -> None:
    text = ",".join(("line", *pair)) + "\na,1,2\na,3,4\na,5,7\n"
    found = FORMATS["csv"].read(Source("points.csv", text.encode()))
    assert found.lines[0].points_px.tolist() == [[1, 2], [3, 4], [5, 7]]

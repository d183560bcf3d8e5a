"""Rows and columns of a grid, whatever the format; and one line of everything refused."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import plumbline
from plumbline.errors import PlumblineError, ReadError
from plumbline.formats.base import Order
from plumbline.formats.grid import follows_one_line

SIZE = (931, 998)
X, Y = (100, 330, 560, 790), (90, 340, 590)
POINTS = [(x, y) for y in Y for x in X]
ZIGZAG = [(x, y) for n, y in enumerate(Y) for x in (X if n % 2 == 0 else X[::-1])]
Points = list[tuple[int, int]]


def csv(points: Points) -> str:
    return "x,y,left,right\n" + "".join(f"{x},{y},0,0\n" for x, y in points)


def headerless(points: Points) -> str:
    return "".join(f"{x}\t{y}\n" for x, y in points)


def labelme(points: Points) -> str:
    shape = f'{{"label": "g", "shape_type": "linestrip", "points": {[list(p) for p in points]}}}'
    return f'{{"shapes": [{shape}], "imageWidth": 931, "imageHeight": 998, "imagePath": "a"}}'


def winmorph(points: Points) -> str:
    rows = "".join(f"{(x + 0.5) / SIZE[0]:.9f} {(y + 0.5) / SIZE[1]:.9f}\n" for x, y in points)
    return f"Shape1\na\nb\n{rows}Sets = 0\n"


@pytest.mark.parametrize("of", [csv, headerless, labelme, winmorph])
@pytest.mark.parametrize(("points", "order"), [(POINTS, "raster"), (ZIGZAG, "zigzag")])
def test_a_grid_in_any_format(
    of: Callable[[Points], str], points: Points, order: Order, tmp_path: Path
) -> None:
    path = tmp_path / f"grid.{'json' if of is labelme else 'txt'}"
    path.write_text(of(points))
    found = plumbline.read(
        path, size=SIZE, grid=(3, 4), order="zigzag" if order == "zigzag" else "raster"
    )
    shift = 0.5 if of is labelme else 0
    expected = {f"row {n + 1}": [(x, y) for x in X] for n, y in enumerate(Y)}
    expected |= {f"column {n + 1}": [(x, y) for y in Y] for n, x in enumerate(X)}
    assert {line.label: (line.points_px + shift).round(5).tolist() for line in found.lines} == {
        label: [list(map(float, p)) for p in line] for label, line in expected.items()
    }
    with pytest.raises(ReadError, match="all 12 points were taken as one line") as caught:
        plumbline.read(path, size=SIZE)
    assert "--grid" in caught.value.hint
    assert "column 'line'" in caught.value.hint
    with pytest.raises(ReadError, match="holds 12 points, but a grid of 3x5 has 15"):
        plumbline.read(path, size=SIZE, grid=(3, 5))
    assert plumbline.read(path, size=SIZE, singly=True).n_points == 12


def test_a_grid_is_one_line(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("line,x,y\n" + "".join(f"{n % 2},{x},{y}\n" for n, (x, y) in enumerate(POINTS)))
    with pytest.raises(ReadError, match="the file holds 2"):
        plumbline.read(path, size=SIZE, grid=(3, 4))
    with pytest.raises(PlumblineError, match="at least two rows"):
        plumbline.read(path, size=SIZE, grid=(1, 12))


RNG = np.random.default_rng(11)
ALONG = np.linspace(-1, 1, 15)


@pytest.mark.parametrize("angle", [0.0, 0.3, 1.2, np.pi / 2])
@pytest.mark.parametrize(
    ("points", "one"),
    [
        (np.column_stack([400 * ALONG, 160 * ALONG**2]), True),  # a fifth of its length
        (np.column_stack([400 * ALONG, 0 * ALONG]), True),
        (np.column_stack([20 * ALONG, RNG.normal(0, 1.0, 15)]), True),  # short and rough
        (np.column_stack([400 * ALONG, 80 * (ALONG > 0.9)]), True),  # a stray pick
        (np.column_stack([400 * np.abs(ALONG), 400 * np.minimum(ALONG, 0)]), False),  # a corner
        (np.array([(x, y) for x in range(3) for y in range(2)], dtype=float), False),
        (np.array([(x, y) for x in range(9) for y in (0.0, 5.0)]), False),  # two edges
    ],
)
def test_what_follows_one_line(points: np.ndarray, one: bool, angle: float) -> None:
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    shuffled = RNG.permutation(points @ turn)
    assert follows_one_line(shuffled) is one

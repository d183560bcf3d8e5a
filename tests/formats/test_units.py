"""Fractions of the photo are read, other units refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import plumbline
from plumbline.errors import ReadError

SIZE = (4000, 3000)
POINTS = np.column_stack([np.linspace(20, 3900, 8), 100 + np.linspace(-1, 1, 8) ** 2 * 30])


def put(tmp_path: Path, points: np.ndarray) -> Path:
    path = tmp_path / "points.csv"
    path.write_text("line,x,y\n" + "".join(f"a,{x!r},{y!r}\n" for x, y in points.tolist()))
    return path


def test_fractions_of_the_photo(tmp_path: Path) -> None:
    found = plumbline.read(put(tmp_path, (POINTS + 0.5) / SIZE), size=SIZE)
    assert np.allclose(found.lines[0].points_px, POINTS, atol=1e-9)
    assert found.notes == (
        "coordinates from 0 to 1 were taken as fractions of the photo's width and height, y down",
    )


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (POINTS / 100, "within 38.8 of a 4000x3000 photo, so that they are in the unit of a"),
        (POINTS * [1, -1], "8 of 8 points lie outside the 4000x3000 photo"),
        (POINTS * 25.4, "points lie outside the 4000x3000 photo"),
    ],
)
def test_calibrated_axes(tmp_path: Path, points: np.ndarray, message: str) -> None:
    path = put(tmp_path, points)
    with pytest.raises(ReadError) as caught:
        plumbline.read(path, size=SIZE)
    assert message in caught.value.message
    assert "axes 'Image'" in caught.value.hint
    assert caught.value.line == 2


def test_a_single_stray_pick_is_named_as_such(tmp_path: Path) -> None:
    stray = POINTS.copy()
    stray[3, 1] = -7
    with pytest.raises(ReadError, match="of line a lies outside the 4000x3000 photo"):
        plumbline.read(put(tmp_path, stray), size=SIZE)

"""A rectification written in one call."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import plumbline
from plumbline.errors import WriteError

ROAD = Path(__file__).parents[2] / "sample_projects" / "road"
COARSE = plumbline.PictureRequest(resolution_m=0.1)


def test_picture_world_file_and_rectification(tmp_path: Path) -> None:
    road = plumbline.rectify(ROAD / "road.jpg", ROAD / "points.csv")
    target = tmp_path / "road.png"
    written, _ = plumbline.write_rectified(road, ROAD / "road.jpg", target, COARSE)
    assert {path.name for path in written} == {"road.png", "road.pgw", "road.json"}
    across, _, _, down, x, y = map(float, (tmp_path / "road.pgw").read_text().split())
    assert (across, down) == (0.1, -0.1)
    with Image.open(target) as picture:
        left, top = x - across / 2, y - down / 2
        right, bottom = left + across * picture.width, top + down * picture.height
    places = np.loadtxt(ROAD / "points.csv", delimiter=",", skiprows=1, usecols=(2, 3))
    assert np.all((places > (left, bottom)) & (places < (right, top)))
    back = plumbline.read_rectification(tmp_path / "road.json")
    assert back.photo == "road.jpg"
    picks = road.to_photo(places)
    assert np.array_equal(back.rectification.to_ground(picks), road.to_ground(picks))


def test_files_of_others_are_kept(tmp_path: Path) -> None:
    road = plumbline.rectify(ROAD / "road.jpg", ROAD / "points.csv")
    (tmp_path / "road.json").write_text("mine")
    with pytest.raises(WriteError, match="was not written by plumbline"):
        plumbline.write_rectified(road, ROAD / "road.jpg", tmp_path / "road.png", COARSE)
    assert [path.name for path in tmp_path.iterdir()] == ["road.json"]

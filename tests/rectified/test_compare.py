"""Overlays and mosaics of pictures on one ground."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from plumbline.errors import OptionError, ReadError
from plumbline.ground.world_file import World
from plumbline.photos.files.metadata import Metadata
from plumbline.photos.files.picture import Picture, Storage
from plumbline.rectified.compare import grid_like, mosaic, overlay
from plumbline.rectified.grid import Grid
from plumbline.rectified.picture import RectifiedPicture
from plumbline.rectified.render import Rendered

GRID = Grid(World.north_up(0.0, 2.0, 0.01), (300, 200))


def made(left: int, right: int, grey: int = 100) -> RectifiedPicture:
    """A picture that shows something between two columns."""
    shown = np.zeros((200, 300), bool)
    shown[:, left:right] = True
    pixels = np.where(shown, grey, 0).astype(np.uint8)
    alpha = np.where(shown, 255, 0).astype(np.uint8)
    picture = Picture(np.dstack((pixels, alpha)), False, Metadata(), Storage("PNG"))
    return RectifiedPicture(picture, Rendered(pixels, shown, 0.0), GRID, ())


def saved(path: Path, pixels: np.ndarray, world: World = GRID.world) -> str:
    Image.fromarray(pixels).save(path)
    path.with_suffix(".pgw").write_text(world.text())
    return str(path)


def test_the_aerial_picture_is_red_and_the_photo_green(tmp_path: Path) -> None:
    """At half the resolution, a step at X = 1.5 m; the photo shows X from 1 to 3 m."""
    aerial = np.zeros((100, 200), np.uint8)
    world = World.north_up(0.0, 2.0, 0.02)
    aerial[:, 76:] = 200
    found = overlay(made(100, 300), saved(tmp_path / "aerial.png", aerial, world)).pixels
    assert tuple(found[100, 250]) == (0, 100, 200)
    assert tuple(found[100, 120]) == (0, 100, 0)
    assert tuple(found[100, 50]) == (0, 0, 0)
    edge = np.flatnonzero(found[100, :, 2] > 100)[0]
    assert GRID.world.places(np.array([float(edge), 0.0]))[0] == pytest.approx(1.51, abs=0.011)


def test_no_common_ground_is_refused(tmp_path: Path) -> None:
    far = World.north_up(500.0, 2.0, 0.02)
    path = saved(tmp_path / "aerial.png", np.zeros((10, 10), np.uint8), far)
    with pytest.raises(OptionError, match="no common ground"):
        overlay(made(100, 300), path)


def test_a_mosaic_is_soft_where_both_show(tmp_path: Path) -> None:
    other = made(0, 200, grey=200)
    path = saved(tmp_path / "other.png", other.picture.pixels)
    row = mosaic(made(100, 300), path).pixels[100]
    assert row[20, 0] == 200
    assert row[280, 0] == 100
    assert row[150, 0] == pytest.approx(150, abs=2), "half and half in the middle"
    assert np.all(np.diff(row[101:199, 0].astype(int)) <= 0)
    assert np.all(row[:, 1] == 255)


def test_a_picture_of_another_size_is_refused(tmp_path: Path) -> None:
    path = saved(tmp_path / "other.png", np.zeros((10, 10), np.uint8))
    with pytest.raises(OptionError, match="another size"):
        mosaic(made(100, 300), path)


def test_the_grid_of_another_picture(tmp_path: Path) -> None:
    path = saved(tmp_path / "other.png", np.zeros((20, 30), np.uint8))
    found = grid_like(path)
    assert found.size == (30, 20)
    assert np.allclose(found.world.origin, GRID.world.origin)
    (tmp_path / "other.pgw").unlink()
    with pytest.raises(ReadError, match="no world file"):
        grid_like(path)

"""Photographs: found by name, read whatever they are, and never shown where they do not fit."""

from __future__ import annotations

import hashlib
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageOps

import plumbline
from plumbline.errors import ReadError
from plumbline.observations import Origin
from plumbline.report.photos import find_photos
from plumbline.result.calibration import Calibration
from tests.report.made import HEIGHT, SAMPLES, WIDTH, grid

ORIENTATION = 0x0112


def calibration(
    name: str = "facade.jpg", size: tuple[int, int] = (WIDTH, HEIGHT), origin: str | None = None
) -> Calibration:
    lines = [line * [size[0] / WIDTH, size[1] / HEIGHT] for line in grid()]
    observations = plumbline.Observations.from_arrays(lines, size=size)
    made = plumbline.calibrate(observations, free=("b",))
    photos = (replace(observations.photos[0], name=name),)
    origins = () if origin is None else (Origin(origin, "csv"),)
    return replace(made, observations=replace(observations, photos=photos, origins=origins))


def picture(path: Path, size: tuple[int, int] = (WIDTH, HEIGHT), mode: str = "RGB") -> Path:
    """A picture whose left third is dark, whose right third is bright, and whose top is red."""
    x, y = np.meshgrid(np.linspace(0, 1, size[0]), np.linspace(0, 1, size[1]))
    values = np.stack((255 - 200 * y, 255 * x, 255 * x), axis=-1).astype(np.uint8)
    Image.fromarray(values).convert(mode).save(path, quality=95)
    return path


def test_found_beside_the_result_before_the_points(tmp_path: Path) -> None:
    for folder in ("points", "result"):
        (tmp_path / folder).mkdir()
    made = calibration(origin=str(tmp_path / "points" / "picks.csv"))
    beside = tmp_path / "result" / "building.json"
    (found,) = find_photos([made], None, beside)
    assert found.pictures == (None,)
    assert found.notes == ("facade.jpg was not found and is not shown (--photo names it)",)
    for folder in ("points", "result"):
        path = picture(tmp_path / folder / "facade.jpg")
        (found,) = find_photos([made], None, beside)
        assert found.pictures[0] is not None
        assert found.pictures[0].path == path
        assert found.pictures[0].sha256 == hashlib.sha256(path.read_bytes()).hexdigest()
        (note,) = found.notes
        assert "is the picture that the points were picked in is not known" in note


@pytest.mark.parametrize("name", [r"C:\photos\facade.jpg", "/elsewhere/facade.jpg", "a/facade.jpg"])
def test_the_folder_in_a_name_does_not_count(name: str, tmp_path: Path) -> None:
    picture(tmp_path / "facade.jpg")
    (found,) = find_photos([calibration(name)], None, tmp_path / "x.json")
    assert found.pictures[0] is not None


@pytest.mark.parametrize("name", ["", "..", "a\0b", "x" * 400, "folder", "a/"])
def test_a_name_that_leads_nowhere_shows_nothing(name: str, tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    (found,) = find_photos([calibration(name)], None, tmp_path / "x.json")
    assert found.pictures == (None,)
    assert found.notes


def test_a_photo_of_another_size_is_said_and_not_shown(tmp_path: Path) -> None:
    picture(tmp_path / "facade.jpg", (WIDTH + 1, HEIGHT))
    (found,) = find_photos([calibration()], None, tmp_path / "x.json")
    assert found.pictures == (None,)
    assert "the photo is 641x480 and the points were picked at 640x480" in found.notes[0]


def test_a_photo_cut_short_is_said_and_not_shown(tmp_path: Path) -> None:
    path = picture(tmp_path / "facade.jpg")
    path.write_bytes(path.read_bytes()[:5000])
    (found,) = find_photos([calibration()], None, tmp_path / "x.json")
    assert found.pictures == (None,)
    assert "cut short" in found.notes[0]


def test_a_named_photo_is_taken_for_the_only_one(tmp_path: Path) -> None:
    path = picture(tmp_path / "another name.png")
    (found,) = find_photos([calibration()], str(path))
    assert found.pictures[0] is not None
    with pytest.raises(ReadError, match="there is no such photo"):
        find_photos([calibration()], str(tmp_path / "missing.jpg"))


def test_a_named_photo_is_one_of_several(tmp_path: Path) -> None:
    shutil.copytree(SAMPLES / "zoom", tmp_path / "zoom")
    made = [calibration("one.jpg"), calibration("two.jpg")]
    path = picture(tmp_path / "two.jpg")
    found = find_photos(made, str(path))
    assert found[0].pictures == (None,)
    assert found[1].pictures[0] is not None
    stranger = picture(tmp_path / "three.jpg")
    with pytest.raises(ReadError, match="none of the 2 photos has this name"):
        find_photos(made, str(stranger))


@pytest.mark.parametrize("orientation", range(1, 9))
def test_a_photo_lies_as_its_picks_do(orientation: int, tmp_path: Path) -> None:
    path = tmp_path / "facade.png"
    picture(path)
    with Image.open(path) as image:
        exif = image.getexif()
        exif[ORIENTATION] = orientation
        image.save(path, exif=exif)
    with Image.open(path) as image:
        stored, upright = np.asarray(image), np.asarray(ImageOps.exif_transpose(image))
    shown: list[np.ndarray] = []
    for expected in (upright, stored):
        made = calibration("facade.png", (expected.shape[1], expected.shape[0]))
        (found,) = find_photos([made], None, tmp_path / "x.json")
        assert found.pictures[0] is not None
        shown.append(found.pictures[0].pixels)
    assert np.array_equal(shown[0], upright)
    # One turned on its head is of the same size as stored: it is taken as a viewer shows it.
    assert np.array_equal(shown[1], stored if orientation >= 5 else upright)


@pytest.mark.parametrize("mode", ["L", "LA", "P", "RGBA", "CMYK", "1"])
def test_every_kind_of_pixel_is_shown_alike(mode: str, tmp_path: Path) -> None:
    suffix = ".tif" if mode == "CMYK" else ".png"
    path = picture(tmp_path / f"facade{suffix}", mode=mode)
    (found,) = find_photos([calibration(path.name)], None, tmp_path / "x.json")
    assert found.pictures[0] is not None
    with Image.open(path) as image:
        expected = np.asarray(image.convert("RGB")).astype(int)
    assert np.abs(found.pictures[0].pixels - expected).max() <= 1


def test_sixteen_bits_are_reduced_to_eight(tmp_path: Path) -> None:
    values = np.tile(np.linspace(0, 65535, WIDTH).astype(np.uint16), (HEIGHT, 1))
    Image.fromarray(values).save(tmp_path / "facade.png")
    (found,) = find_photos([calibration("facade.png")], None, tmp_path / "x.json")
    assert found.pictures[0] is not None
    assert np.array_equal(found.pictures[0].pixels[..., 1], values // 256)


def test_large_photos_are_reduced(tmp_path: Path) -> None:
    size = (4000, 3000)
    picture(tmp_path / "facade.jpg", size)
    (found,) = find_photos([calibration(size=size)], None, tmp_path / "x.json")
    assert found.pictures[0] is not None
    pixels = found.pictures[0].pixels.astype(int)
    assert pixels.shape == (1200, 1600, 3)
    assert pixels[600, 400, 1] == pytest.approx(64, abs=3)
    assert pixels[600, 1200, 1] == pytest.approx(191, abs=3)
    assert pixels[100, 800, 0] > pixels[1100, 800, 0] + 100

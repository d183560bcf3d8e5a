"""Photos as tiles: upright, of every depth and colour, small first, corrected."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from PIL import Image, ImageCms, ImageOps

from plumbline.errors import OptionError, ReadError
from plumbline.frame import Frame
from plumbline.geometry.lens import Lens
from plumbline.models import get_model
from plumbline.pick.photos import LoadedPhoto, is_photo
from plumbline.pick.tiles import SIDE, tile
from plumbline.pick.tracing import Tracer

WIDTH, HEIGHT = 1100, 700


def ramp(width: int = WIDTH, height: int = HEIGHT) -> np.ndarray[Any, Any]:
    """Red grows to the right, green downwards, blue is constant."""
    x, y = np.meshgrid(np.linspace(0, 255, width), np.linspace(0, 255, height))
    return np.stack((x, y, np.full_like(x, 100)), axis=-1).round().astype(np.uint8)


def opened(path: Path) -> LoadedPhoto:
    photo = LoadedPhoto(path)
    photo.load()
    if photo.failure is not None:
        raise photo.failure
    return photo


def shown(photo: LoadedPhoto, level: int, column: int, row: int, lens: Lens | None = None) -> Any:
    """A tile's pixels, red first."""
    data = np.frombuffer(tile(photo, level, column, row, lens), dtype=np.uint8)
    decoded = cv2.imdecode(data, cv2.IMREAD_COLOR)
    assert decoded is not None
    return decoded[..., ::-1].astype(int)


@pytest.mark.parametrize("name", ["a.png", "a.tif", "a.jpg", "a.webp"])
def test_tiles_hold_their_part_of_the_photo(name: str, tmp_path: Path) -> None:
    pixels = ramp()
    Image.fromarray(pixels).save(tmp_path / name, quality=95)
    photo = opened(tmp_path / name)
    assert photo.n_levels == 4
    for column, row in ((0, 0), (1, 1), (2, 0)):
        part = pixels[row * SIDE : (row + 1) * SIDE, column * SIDE : (column + 1) * SIDE]
        found = shown(photo, 0, column, row)
        assert found.shape == part.shape
        assert np.median(np.abs(found - part)) <= 2
    half = shown(photo, 1, 0, 0)
    assert half.shape == (350, 512, 3)
    assert np.median(np.abs(half - pixels[::2, ::2][:350, :512])) <= 2


@pytest.mark.parametrize("orientation", range(1, 9))
def test_every_orientation_stands_upright(orientation: int, tmp_path: Path) -> None:
    pixels = ramp()
    exif = Image.Exif()
    exif[0x0112] = orientation
    # What a viewer shows is what Pillow makes of the stored pixels by the tag.
    Image.fromarray(pixels).save(tmp_path / "a.jpg", quality=95, exif=exif)
    with Image.open(tmp_path / "a.jpg") as stored:
        expected = np.asarray(ImageOps.exif_transpose(stored)).astype(int)
    photo = opened(tmp_path / "a.jpg")
    assert photo.size == expected.shape[1::-1]
    found = shown(photo, 0, 0, 0)
    assert np.median(np.abs(found - expected[:SIDE, :SIDE])) <= 2


def test_sixteen_bits_and_grey(tmp_path: Path) -> None:
    deep = ramp()[..., 0].astype(np.uint16) * 257
    cv2.imwrite(str(tmp_path / "grey.png"), deep)
    photo = opened(tmp_path / "grey.png")
    assert photo.source().dtype == np.uint16  # edges are traced at full depth
    assert np.median(np.abs(shown(photo, 0, 0, 0)[..., 0] - ramp()[:SIDE, :SIDE, 0])) <= 2
    cv2.imwrite(str(tmp_path / "colour.png"), ramp()[..., ::-1].astype(np.uint16) * 257)
    found = shown(opened(tmp_path / "colour.png"), 0, 1, 0)
    assert np.median(np.abs(found - ramp()[:SIDE, SIDE : 2 * SIDE])) <= 2


def test_inks_are_shown_and_not_traced(tmp_path: Path) -> None:
    Image.fromarray(ramp()).convert("CMYK").save(tmp_path / "inks.tif")
    photo = opened(tmp_path / "inks.tif")
    assert np.median(np.abs(shown(photo, 0, 0, 0) - ramp()[:SIDE, :SIDE])) <= 6
    with pytest.raises(ReadError, match="printing inks"):
        Tracer([photo])(0, ((1.0, 1.0), (50.0, 50.0)), None, 0)


def test_a_colour_profile_is_applied(tmp_path: Path) -> None:
    profile = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    Image.fromarray(ramp()).save(tmp_path / "srgb.png", icc_profile=profile)
    same = shown(opened(tmp_path / "srgb.png"), 0, 0, 0)
    assert np.median(np.abs(same - ramp()[:SIDE, :SIDE])) <= 2
    # With the places of red and green exchanged in the profile, red light is shown green.
    exchanged = (
        profile.replace(b"rXYZ", b"....").replace(b"gXYZ", b"rXYZ").replace(b"....", b"gXYZ")
    )
    Image.fromarray(ramp()).save(tmp_path / "exchanged.png", icc_profile=exchanged)
    other = shown(opened(tmp_path / "exchanged.png"), 0, 0, 0)
    assert np.median(np.abs(other[..., [1, 0, 2]] - ramp()[:SIDE, :SIDE])) <= 3
    Image.fromarray(ramp()).save(tmp_path / "damaged.png", icc_profile=b"nonsense" * 30)
    same = shown(opened(tmp_path / "damaged.png"), 0, 0, 0)
    assert np.median(np.abs(same - ramp()[:SIDE, :SIDE])) <= 2


def test_a_corrected_tile_takes_pixels_from_where_the_lens_saw_them(tmp_path: Path) -> None:
    Image.fromarray(ramp()).save(tmp_path / "a.png")
    photo = opened(tmp_path / "a.png")
    b = -0.03
    zero = dict.fromkeys(("a", "c", "d", "e"), 0.0)
    lens = Lens(get_model("ptlens"), Frame(WIDTH, HEIGHT), zero | {"b": b})
    found = shown(photo, 0, 0, 0, lens)
    y, x = np.mgrid[40:500:60, 40:500:60]
    centre = np.array([(WIDTH - 1) / 2, (HEIGHT - 1) / 2])
    q = (np.stack((x, y), axis=-1) - centre) / (HEIGHT / 2)
    observed = centre + q * (b * (q**2).sum(-1, keepdims=True) + 1 - b) * HEIGHT / 2
    expected = observed / np.array([WIDTH - 1, HEIGHT - 1]) * 255
    assert np.abs(found[y, x, :2] - expected).max() <= 2.5


def test_a_large_jpeg_is_small_first(tmp_path: Path) -> None:
    Image.fromarray(ramp(3000, 2000)).save(tmp_path / "a.jpg", quality=90)
    photo = LoadedPhoto(tmp_path / "a.jpg")
    photo._show_small((tmp_path / "a.jpg").read_bytes())  # pyright: ignore[reportPrivateUsage]
    small = photo.level(3, timeout_s=1).pixels
    assert small.shape == (250, 375, 3)
    with pytest.raises(ReadError, match="not decoded yet"):
        photo.level(0, timeout_s=0.01)
    photo.load()
    assert photo.level(0).pixels.shape == (2000, 3000, 3)


def test_what_is_no_photo(tmp_path: Path) -> None:
    for name, content in (("a.csv", b"line,x,y\n"), ("b.jpg", b""), ("c.png", b"\x89PNG\r\n")):
        (tmp_path / name).write_bytes(content)
        assert not is_photo(tmp_path / name)
    with pytest.raises(ReadError):
        LoadedPhoto(tmp_path / "missing.jpg")
    Image.fromarray(ramp()).save(tmp_path / "cut.jpg")
    data = (tmp_path / "cut.jpg").read_bytes()
    (tmp_path / "cut.jpg").write_bytes(data[: len(data) // 2])
    with pytest.raises(ReadError, match="cut short"):
        opened(tmp_path / "cut.jpg")


@pytest.mark.parametrize("where", [(9, 0, 0), (0, 5, 0), (0, 0, 5), (-1, 0, 0)])
def test_tiles_that_do_not_exist(where: tuple[int, int, int], tmp_path: Path) -> None:
    Image.fromarray(ramp()).save(tmp_path / "a.png")
    with pytest.raises(OptionError):
        tile(opened(tmp_path / "a.png"), *where, None)


def test_a_photo_that_changes_is_noticed(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    Image.fromarray(ramp()).save(path)
    photo = opened(path)
    assert photo.trouble == ""
    Image.fromarray(ramp()[:100]).save(path)
    assert "was changed" in photo.trouble
    path.unlink()
    assert "moved or deleted" in photo.trouble


def test_two_clicks_find_the_edge_between_them(tmp_path: Path) -> None:
    """A slanted step, drawn with 16 samples a pixel: its samples lie on it to 0.03 px."""
    y, x = np.mgrid[:400, :600]
    fine = [
        (y + (j + 0.5) / 4 - 0.5 > 180 + 0.05 * (x + (i + 0.5) / 4 - 0.5))
        for i in range(4)
        for j in range(4)
    ]
    light = 0.1 + 0.6 * np.mean(fine, axis=0)
    blurred = cv2.GaussianBlur(light, (0, 0), 0.8)
    stored = np.where(blurred > 0.0031308, 1.055 * blurred ** (1 / 2.4) - 0.055, 12.92 * blurred)
    Image.fromarray((255 * stored).round().astype(np.uint8)).save(tmp_path / "a.png")
    found = Tracer([opened(tmp_path / "a.png")])(0, ((30.0, 184.0), (560.0, 206.0)), None, 0)
    assert not found.refusal
    points = np.array(found.points)
    assert np.abs(points[:, 1] - 180 - 0.05 * points[:, 0]).max() < 0.03
    flat = Tracer([opened(tmp_path / "a.png")])(0, ((30.0, 40.0), (560.0, 60.0)), None, 0)
    assert "edge" in flat.refusal

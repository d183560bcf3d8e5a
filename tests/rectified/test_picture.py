"""The rectified picture: places, aliasing, what is cut, and what lays it over a map."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from plumbline.errors import OptionError, ReadError
from plumbline.frame import Frame
from plumbline.ground.camera import Camera
from plumbline.ground.optics import Optics
from plumbline.ground.rectification import Rectification
from plumbline.ground.world_file import World, read_world
from plumbline.lenses.mapping import PhotoLens
from plumbline.models import get_model
from plumbline.photos.files.metadata import Metadata
from plumbline.photos.files.tiff_writing import with_metadata
from plumbline.rectified import grid as grids
from plumbline.rectified.georeference import epsg_code, geotiff
from plumbline.rectified.grid import Grid, grid_over
from plumbline.rectified.ground_map import GroundMap
from plumbline.rectified.picture import (
    PictureRequest,
    RectifiedPicture,
    picture_files,
    rectify_picture,
)
from plumbline.rectified.render import Renderer
from tests.ground.scenes import Scene
from tests.ground.test_camera import camera_of
from tests.rectified.painted import checker, photograph
from tests.truth import Array

rasterio = pytest.importorskip("rasterio")

SCENE = Scene(height=1.6, pitch=14, size=(512, 384), focal=550.0)


def rectification(camera: Camera) -> Rectification:
    size = 9 + len(camera.optics.names) + 8
    places = np.array([[-1.0, 3.0], [1.0, 3.0], [1.5, 8.0], [-1.5, 8.0]])
    return Rectification(
        camera, tuple("ABCD"), np.zeros((4, 2)), places, np.eye(size), {}, 0.5, 0.02
    )


def camera() -> Camera:
    made = camera_of(SCENE)
    lens = PhotoLens(Frame(*SCENE.size), get_model("ptlens"), (0.0, SCENE.b, 0.0), 192.0)
    return replace(made, optics=Optics(lens))


@pytest.fixture(scope="module")
def photo() -> Array:
    return photograph(SCENE, checker)


def saved(tmp_path: Path, pixels: Array, name: str = "photo.png") -> Path:
    path = tmp_path / name
    Image.fromarray(np.rint(pixels).astype(np.uint8)).save(path)
    return path


def rendered(photo: Array, grid: Grid, coarsest: float = 0.5) -> tuple[Array, NDArray[np.bool_]]:
    pixels = np.rint(photo).astype(np.uint8)
    made = Renderer(pixels, GroundMap(camera(), grid, coarsest), threads=1).render((0.0,))
    return made.pixels.astype(float), made.shown


def truth(grid: Grid, samples: int = 8) -> Array:
    """The painted plane averaged over each pixel of the grid."""
    width, height = grid.size
    columns, rows = np.meshgrid(np.arange(width, dtype=float), np.arange(height, dtype=float))
    total = np.zeros(width * height)
    for i in range(samples):
        for j in range(samples):
            move = np.array([(i + 0.5) / samples - 0.5, (j + 0.5) / samples - 0.5])
            points = np.stack((columns, rows), axis=-1).reshape(-1, 2) + move
            total += checker(grid.world.places(points))
    return (total / samples**2).reshape(height, width)


def test_the_picture_is_the_plane(photo: Array) -> None:
    grid = grid_over((-1.0, 3.5, 1.0, 5.5), 0.01, 1)
    pixels, shown = rendered(photo, grid)
    assert shown.all()
    # edges of squares are blurred by the photo's own pixels; their places must agree
    wanted = truth(grid)
    inner = np.abs(wanted - 120) == 60
    assert np.mean(np.abs(pixels - wanted) > 60) < 0.02
    assert np.median(np.abs(pixels - wanted)[inner]) < 2


def test_every_pixel_is_taken_from_where_the_independent_camera_sees_it() -> None:
    grid = Grid(World.north_up(-3.0, 12.0, 0.02), (300, 600))
    ground = GroundMap(camera(), grid, 10.0)
    worst = 0.0
    for whole in ground.tiles():
        for tile, part in ground.parts(whole):
            x, y = ground.places(tile, part, 1, 1)
            rows, columns = (np.arange(each.start, each.stop, dtype=float) for each in tile)
            points = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
            seen = SCENE.photo(grid.world.places(points)).reshape(len(rows), len(columns), 2)
            inside = np.all((seen > 0) & (seen < np.array(SCENE.size) - 1), axis=-1)
            away = np.hypot(x - seen[..., 0], y - seen[..., 1])
            worst = max(worst, float(np.max(away[inside], initial=0.0)))
    assert 0 < worst < 0.01


def test_aliasing_is_a_quarter_of_plain_cubic_s(photo: Array) -> None:
    """A fine pattern near the camera, where a pixel of 3 cm takes in many of the photo."""
    fine = photograph(SCENE, lambda places: checker(places, 0.02), samples=6)
    grid = grid_over((-0.6, 2.6, 0.6, 3.6), 0.03, 1)
    pixels, _ = rendered(fine, grid)
    width, height = grid.size
    points = np.stack(np.meshgrid(np.arange(float(width)), np.arange(float(height))), axis=-1)
    at = camera().project(
        np.column_stack((grid.world.places(points).reshape(-1, 2), np.zeros(width * height)))
    )
    x, y = np.moveaxis(at.reshape(height, width, 2), -1, 0).astype(np.float32)
    plain = cv2.remap(np.rint(fine).astype(np.uint8), x, y, cv2.INTER_CUBIC).astype(float)

    def wanted() -> Array:
        total = np.zeros((height, width))
        for i in range(16):
            for j in range(16):
                move = (np.array([i, j]) + 0.5) / 16 - 0.5
                total += checker(grid.world.places(points + move).reshape(-1, 2), 0.02).reshape(
                    height, width
                )
        return total / 256

    def rms(found: Array) -> float:
        return float(np.sqrt(np.mean((found - wanted()) ** 2)))

    assert rms(plain) > 10
    assert rms(pixels) < rms(plain) / 4


def test_what_lies_behind_or_beyond_is_cut_and_said(photo: Array, tmp_path: Path) -> None:
    path, target = saved(tmp_path, photo), tmp_path / "out.png"
    request = PictureRequest(0.05, (-5.0, -5.0, 5.0, 600.0), coarsest_m=0.5)
    made = rectify_picture(rectification(camera()), path, target, request)
    rows = np.flatnonzero(made.rendered.shown.any(axis=1))
    far, near = made.grid.world.places(np.array([[0.0, rows[0]], [0.0, rows[-1]]]))[:, 1]
    assert near > 0, "behind the camera nothing is seen"
    depth = np.sqrt(0.5 * SCENE.focal * SCENE.height)  # where a pixel covers half a metre
    assert far == pytest.approx(depth / np.cos(np.radians(SCENE.pitch)), rel=0.1)
    assert any("covers more than 0.5 m" in note for note in made.notes)
    assert any("outside of what the photo shows" in note for note in made.notes)


def test_no_ghosts_of_ground_beyond_the_fold() -> None:
    """b = −0.1: ground far aside maps back into the photo by the formula alone."""
    bent = camera()
    bent = replace(bent, optics=bent.optics.with_coefficients(np.array([0.0, -0.12, 0.0])))
    grid = Grid(World.north_up(-60.0, 20.0, 0.1), (1200, 200))
    pixels = np.full((384, 512), 255, np.uint8)
    shown = Renderer(pixels, GroundMap(bent, grid, 50.0), threads=1).render((0.0,)).shown
    columns = np.flatnonzero(shown.any(axis=0))
    seen = grid.world.places(np.stack((columns, 0 * columns), axis=1).astype(float))[:, 0]
    fold = np.sqrt(1.12 / 0.36) * 192 / SCENE.focal  # ideal, over the focal length
    assert shown.any()
    assert np.max(np.abs(seen)) < fold * 24


def test_a_picture_larger_than_memory_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(grids, "free_bytes", lambda: 10_000_000)
    with pytest.raises(OptionError, match=r"10,000 x 10,000 pixels") as error:
        grid_over((0.0, 0.0, 100.0, 100.0), 0.01, 4)
    coarser = float(error.value.hint.split("as ")[1].split(",")[0])
    assert grid_over((0.0, 0.0, 100.0, 100.0), coarser, 4).size[0] == pytest.approx(1118, abs=60)


@pytest.mark.parametrize("extent", [(1.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0, 1.0)])
def test_an_empty_extent_is_refused(extent: tuple[float, float, float, float]) -> None:
    with pytest.raises(OptionError, match="has no area"):
        grid_over(extent, 0.01, 1)


def files(
    photo: Array, tmp_path: Path, name: str, crs: str | None
) -> tuple[Path, RectifiedPicture]:
    target = tmp_path / name
    request = PictureRequest(0.0371, (1000.013, 3.0, 1002.0, 7.0), crs=crs)
    moved = camera()
    moved = replace(moved, place=moved.place + np.array([1001.0, 0.0, 0.0]))
    made = rectify_picture(rectification(moved), saved(tmp_path, photo), target, request)
    for path, data in picture_files(made, target, request, "a test")[0].items():
        path.write_bytes(data)
    return target, made


@pytest.mark.parametrize("name", ["out.tif", "out.png", "out.jpg", "out.webp"])
@pytest.mark.parametrize("crs", [None, "EPSG:25832"])
def test_rasterio_reads_the_place_back(
    photo: Array, tmp_path: Path, name: str, crs: str | None
) -> None:
    target, made = files(photo, tmp_path, name, crs)
    with rasterio.open(target) as source:
        assert (source.width, source.height) == made.grid.size
        for pixel in ((0, 0), (source.height - 1, source.width - 1)):
            theirs = np.array(source.xy(*pixel))
            ours = made.grid.world.places(np.array([pixel[1], pixel[0]], dtype=float))
            assert np.max(np.abs(theirs - ours)) < 1e-6
        assert source.crs == (None if crs is None else rasterio.crs.CRS.from_epsg(25832))
    world = read_world(target)
    assert np.allclose(world.matrix, made.grid.world.matrix, rtol=0, atol=1e-12)
    assert np.allclose(world.origin, made.grid.world.origin, rtol=0, atol=1e-9)


def test_a_rotated_world_is_kept_in_geotiff(tmp_path: Path) -> None:
    path = tmp_path / "out.tif"
    Image.new("L", (20, 10)).save(path)
    world = World(np.array([[0.02, 0.01], [0.01, -0.02]]), np.array([500_000.125, 6_000_000.25]))
    path.write_bytes(
        geotiff(with_metadata(path.read_bytes(), Metadata(), "x", alpha=False), world, 25832)
    )
    with rasterio.open(path) as source:
        for pixel in ((0, 0), (9, 19)):
            ours = world.places(np.array([pixel[1], pixel[0]], dtype=float))
            assert np.max(np.abs(np.array(source.xy(*pixel)) - ours)) < 1e-6


def test_what_is_not_shown_is_transparent_where_the_format_can(
    photo: Array, tmp_path: Path
) -> None:
    target, made = files(photo, tmp_path, "out.png", None)
    alpha = np.asarray(Image.open(target))[..., -1]
    assert np.array_equal(alpha > 0, made.rendered.shown)
    request, path = PictureRequest(0.05, border="transparent"), saved(tmp_path, photo)
    with pytest.raises(OptionError, match="cannot be transparent"):
        rectify_picture(rectification(camera()), path, tmp_path / "o.jpg", request)


def test_another_photo_is_refused(photo: Array, tmp_path: Path) -> None:
    path = saved(tmp_path, photo[:100])
    with pytest.raises(OptionError, match="512x100 pixels"):
        rectify_picture(rectification(camera()), path, tmp_path / "o.png", PictureRequest())


@pytest.mark.parametrize("code", ["EPSG:4326", "4258", "ETRS89", "EPSG:99999", ""])
def test_codes_that_are_not_of_a_plane_are_refused(code: str) -> None:
    with pytest.raises(OptionError):
        epsg_code(code)


def test_a_world_file_is_six_numbers_of_a_plane(tmp_path: Path) -> None:
    for text, match in (("1\n0\n0\n", "six numbers"), ("0\n" * 6, "no area"), ("a\n" * 6, "'a'")):
        (tmp_path / "a.pgw").write_text(text)
        with pytest.raises(ReadError, match=match):
            read_world(tmp_path / "a.png")
    (tmp_path / "a.pgw").write_text("0,5\n0\n0\n-0,5\n10\n20\n")
    assert read_world(tmp_path / "a.png").resolution_m == 0.5


@pytest.mark.parametrize("name", ["out.jpg", "out.png", "out.tif"])
def test_exif_is_carried_and_tells_the_new_size(photo: Array, tmp_path: Path, name: str) -> None:
    path = tmp_path / "photo.jpg"
    image = Image.fromarray(np.rint(photo).astype(np.uint8))
    tags = image.getexif()
    tags[0x010F], tags[0x0112] = "Maker", 1
    tags.get_ifd(0x8769).update({0x9003: "2024:05:06 07:08:09", 0xA002: 512, 0xA003: 384})
    image.save(path, exif=tags)
    target, request = tmp_path / name, PictureRequest(0.05)
    made = rectify_picture(rectification(camera()), path, target, request)
    files, _ = picture_files(made, target, request, "x")
    target.write_bytes(files[target])
    with Image.open(target) as written:
        told = written.getexif()
        assert (told[0x010F], told[0x0112]) == ("Maker", 1)
        own = told.get_ifd(0x8769)
        assert own[0x9003] == "2024:05:06 07:08:09"
        assert (own[0xA002], own[0xA003]) == written.size

"""ImageMagick, nona and LensFun correct the same photo with the same coefficients alike."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

import plumbline
from plumbline.imaging.resample import Interpolation
from plumbline.lenses.request import LensRequest
from tests.imaging.painted import BARREL, barrel, centroids, dots, grid_inside
from tests.peers.tools import program, run

FACADE = Path(__file__).parents[2] / "sample_projects" / "building" / "facade.jpg"
SIZE = (901, 600)
ABC = {name: BARREL[name] for name in "abc"}
LENS = LensRequest(ptlens=ABC)
KERNELS: dict[Interpolation, tuple[str, str]] = {
    "linear": ("bilinear", "5"),
    "cubic": ("catrom", "1"),
    "lanczos": ("", "3"),
}
"""The like of it in ImageMagick, where there is one, and in Panorama Tools.

Panorama Tools' own cubic has a = −0.75 and moves dots by 0.05 px; its 16-point spline does not.
"""


def _imagemagick(source: Path, target: Path, how: list[str], depth: int = 8) -> None:
    convert = program("convert-im6.q16", "magick")
    barrel_of = ("-distort", "Barrel", " ".join(str(ABC[name]) for name in "abc"))
    black = ("-virtual-pixel", "black")
    run([convert, str(source), *how, *black, *barrel_of, "-depth", str(depth), str(target)])


def _nona(source: Path, target: Path, size: tuple[int, int], interpolator: str) -> None:
    width, height = size
    coefficients = " ".join(f"{name}{ABC[name]}" for name in "abc")
    project = target.with_suffix(".pto")
    project.write_text(
        f'p f0 w{width} h{height} v50 E0 R0 n"TIFF_m c:NONE"\nm i{interpolator}\n'
        f'i w{width} h{height} f0 v50 r0 p0 y0 {coefficients} d0 e0 g0 t0 Eev0 n"{source}"\n'
    )
    run([program("nona"), "-o", str(target.with_suffix("")), str(project)])
    target.with_name(f"{target.stem}0000.tif").rename(target)


def _grey(path: Path) -> NDArray[Any]:
    pixels: Any = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    return pixels if pixels.ndim == 2 else pixels[..., 1]


def _painted(path: Path) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    ideal = grid_inside(SIZE)
    observed = barrel(SIZE).distort(ideal)
    values = np.rint(dots(SIZE, observed) * 60000).astype(np.uint16)
    assert cv2.imwrite(str(path), np.dstack([values] * 3))
    return ideal, observed


@pytest.mark.parametrize("kernel", KERNELS)
def test_dots_land_where_the_peers_put_them(tmp_path: Path, kernel: Interpolation) -> None:
    ideal, observed = _painted(tmp_path / "a.tif")
    assert np.max(np.hypot(*(observed - ideal).T)) > 8
    done = plumbline.correct(tmp_path / "a.tif", LENS, interpolation=kernel)
    ours = centroids(_grey(done.output), ideal)
    assert np.max(np.hypot(*(ours - ideal).T)) < 0.05
    magick, interpolator = KERNELS[kernel]
    if magick:
        how = ["-filter", "point", "-interpolate", magick]
        _imagemagick(tmp_path / "a.tif", tmp_path / "im.png", how, depth=16)
        theirs = centroids(_grey(tmp_path / "im.png"), ideal)
        assert np.max(np.hypot(*(ours - theirs).T)) < 0.05
    _nona(tmp_path / "a.tif", tmp_path / "nona.tif", SIZE, interpolator)
    theirs = centroids(_grey(tmp_path / "nona.tif"), ideal)
    assert np.max(np.hypot(*(ours - theirs).T)) < 0.05


def _decoded(path: Path) -> Any:
    return cv2.imread(str(path))


def _inside(pixels: NDArray[Any]) -> NDArray[np.float64]:
    """Grey values away from the edges of the frame."""
    grey = cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY) if pixels.ndim == 3 else pixels
    rows, columns = grey.shape
    margin = rows // 20
    return grey[margin : rows - margin, margin : columns - margin].astype(float)


@pytest.fixture(scope="module")
def facade(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The sample photo without JPEG's losses, so that nothing but resampling differs."""
    path = tmp_path_factory.mktemp("facade") / "facade.tif"
    Image.open(FACADE).convert("RGB").save(path, compression="raw")
    return path


@pytest.fixture(scope="module")
def ours(facade: Path) -> NDArray[np.float64]:
    done = plumbline.correct(facade, LENS)
    return _inside(_decoded(done.output))


def _mean_gap(ours: NDArray[np.float64], path: Path) -> float:
    return float(np.mean(np.abs(ours - _inside(_decoded(path)))))


def test_a_photo_agrees_with_imagemagick(facade: Path, ours: Any, tmp_path: Path) -> None:
    _imagemagick(facade, tmp_path / "im.tif", ["-filter", "point", "-interpolate", "catrom"])
    assert _mean_gap(ours, tmp_path / "im.tif") < 1


def test_a_photo_agrees_with_imagemagick_s_default_filter(
    facade: Path, ours: Any, tmp_path: Path
) -> None:
    _imagemagick(facade, tmp_path / "im.tif", [])
    assert _mean_gap(ours, tmp_path / "im.tif") < 1


def test_a_photo_agrees_with_nona(facade: Path, ours: Any, tmp_path: Path) -> None:
    with Image.open(facade) as image:
        size = image.size
    _nona(facade, tmp_path / "nona.tif", size, "0")
    assert _mean_gap(ours, tmp_path / "nona.tif") < 1


def test_a_photo_agrees_with_lensfun(facade: Path, ours: Any) -> None:
    lensfunpy = pytest.importorskip("lensfunpy", reason="lensfunpy is not installed")
    xml = (
        '<lensdatabase version="1"><lens><maker>M</maker><model>L</model><mount>Generic</mount>'
        "<cropfactor>1.534</cropfactor><aspect-ratio>1.5</aspect-ratio><calibration>"
        f'<distortion model="ptlens" focal="18" a="{ABC["a"]}" b="{ABC["b"]}" c="{ABC["c"]}"/>'
        "</calibration></lens></lensdatabase>"
    )
    database = lensfunpy.Database(xml=xml, load_common=False, load_bundled=False)
    photo = _decoded(facade)
    modifier = lensfunpy.Modifier(database.lenses[0], 1.534, photo.shape[1], photo.shape[0])
    modifier.initialize(18.0, 8.0, scale=1.0, flags=lensfunpy.ModifyFlags.DISTORTION)
    field = modifier.apply_geometry_distortion()
    theirs = cv2.remap(photo, field[..., 0], field[..., 1], cv2.INTER_CUBIC)
    assert float(np.mean(np.abs(ours - _inside(theirs)))) < 1


def test_bilinear_is_nona_s_to_the_last_digit(facade: Path, tmp_path: Path) -> None:
    with Image.open(facade) as image:
        size = image.size
    _nona(facade, tmp_path / "nona.tif", size, "5")
    done = plumbline.correct(facade, LENS, tmp_path / "ours.tif", interpolation="linear")
    assert _mean_gap(_inside(_decoded(done.output)), tmp_path / "nona.tif") < 0.01


def test_the_peers_tell_another_lens_apart(facade: Path, ours: Any, tmp_path: Path) -> None:
    wrong = LensRequest(ptlens=ABC | {"b": ABC["b"] + 0.005})
    done = plumbline.correct(facade, wrong, tmp_path / "wrong.tif")
    assert _mean_gap(ours, done.output) > 1.5

"""Lenses in other programs' words, read back by those programs."""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from plumbline.errors import OptionError
from plumbline.formats.known import FORMATS
from plumbline.frame import Array, Frame
from plumbline.geometry.lens import Lens
from plumbline.lenses.lookup import find_correction
from plumbline.lenses.request import LensRequest
from plumbline.lenses.stored import StoredLens
from plumbline.models import get_model
from plumbline.observations.facts import LensFacts
from plumbline.photos.exif import PhotoFacts, read_photo
from plumbline.writing.export import export
from plumbline.writing.files import export_file, write_export
from plumbline.writing.refit import refit
from plumbline.writing.targets import TARGETS
from tests.lenses.library import lensfunpy
from tests.lenses.made import calibration, saved
from tests.lenses.photos import photo
from tests.peers.tools import program, run
from tests.truth import scale

SIZE = (2048, 1536)
POINTS = np.random.default_rng(3).uniform((0, 0), (2047, 1535), (300, 2))
ABC = {"a": 0.02, "b": -0.06, "c": 0.01}
SHOT = PhotoFacts(SIZE, LensFacts(camera="NIKON E995", focal_mm=8.2), maker="NIKON", model="E995")


def stored(
    model: str = "ptlens",
    focal_px: float | None = None,
    coefficients: Mapping[str, float] | None = None,
    **values: float,
) -> StoredLens:
    kind = get_model(model)
    zero = dict.fromkeys((*kind.coefficients, "d", "e"), 0.0)
    facts = LensFacts(maker="NIKON", camera="NIKON E995", focal_mm=8.2, crop_factor=4.843)
    return StoredLens(
        Lens(kind, Frame(*SIZE), zero | dict(coefficients or {}) | values, focal_px), facts
    )


def straightened(points: Array) -> Array:
    """Points about their middle at their own scale: what straight lines can see."""
    centred = points - points.mean(axis=0)
    return centred / np.sqrt((centred**2).sum())


def alike(found: Array, expected: Array, px: float) -> None:
    """Same but for scale and translation, in pixels of the expected points."""
    size = np.sqrt(((expected - expected.mean(axis=0)) ** 2).sum())
    off = (straightened(found) - straightened(expected)) * size
    assert np.max(np.hypot(*off.T)) <= px


@pytest.mark.parametrize("name", ["lensfun", "pto", "hugin-ini", "ptlens"])
@pytest.mark.parametrize("shift", [{}, {"d": 25.0, "e": -14.0}])
def test_what_plumbline_writes_it_finds_again(
    name: str, shift: dict[str, float], tmp_path: Path
) -> None:
    lens = stored(coefficients=ABC | shift)
    made = export(lens, name)
    path = tmp_path / f"lens{FORMATS[name].suffixes[0]}"
    path.write_bytes(made.content)
    found = find_correction(SHOT, LensRequest(source=str(path)))
    # LensFun centres both sides, PTLens knows no centre.
    expected = lens.lens.undistort(POINTS)
    if name == "lensfun":
        expected = expected + np.array([shift.get("d", 0.0), shift.get("e", 0.0)])
    if name == "ptlens" and shift:
        assert made.deviation_px is not None
        assert made.deviation_px > 0.1
        return
    assert np.max(np.hypot(*(found.undistort(POINTS) - expected).T)) < 1e-3


def test_lensfun_s_own_library_reads_it() -> None:
    content = export(stored("poly5", k1=-0.04, k2=0.006), "lensfun").content
    (lens,) = lensfunpy.Database(xml=content.decode(), load_common=False, load_bundled=False).lenses
    assert lens.model == "NIKON E995 lens"
    np.testing.assert_allclose(
        lens.interpolate_distortion(8.2).terms[:2], [-0.04, 0.006], rtol=1e-6
    )


def test_pano_trafo_reads_the_project(tmp_path: Path) -> None:
    trafo = program("pano_trafo")
    lens = replace(stored(coefficients=ABC, d=25.0, e=-14.0), facts=LensFacts(hfov_deg=50.0))
    path = tmp_path / "lens.pto"
    path.write_bytes(export(lens, "pto").content)
    text = "".join(f"{x} {y}\n" for x, y in POINTS)
    rows = run([trafo, str(path), "0"], text).splitlines()
    theirs = np.array([[float(value) for value in row.split()] for row in rows])
    assert np.max(np.hypot(*(theirs - lens.lens.undistort(POINTS)).T)) < 2e-3


def test_opencv_reads_its_file_and_bends_points_alike(tmp_path: Path) -> None:
    lens = stored(
        "opencv", focal_px=2200.0, k1=-0.12, k2=0.03, p1=0.001, p2=-0.002, k3=0.004, d=9.0
    )
    lens = replace(lens, facts=LensFacts(focal_px=2200.0))
    path = tmp_path / "lens.yml"
    made = export(lens, "opencv")
    assert made.deviation_px is None
    path.write_bytes(made.content)
    store = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    matrix = store.getNode("camera_matrix").mat()
    k = store.getNode("distortion_coefficients").mat()
    # Their ideal points are about the principal point, ours about the image centre.
    ideal = (POINTS - np.array([1023.5 + 9.0, 767.5])) / 2200.0
    theirs = cv2.projectPoints(
        np.column_stack((ideal, np.ones(len(ideal)))), np.zeros(3), np.zeros(3), matrix, k
    )[0][:, 0]
    ours = lens.lens.distort(POINTS - np.array([9.0, 0.0]))
    np.testing.assert_allclose(theirs, ours, atol=1e-8)


def test_imagemagick_runs_the_script(tmp_path: Path) -> None:
    convert = program("convert-im6.q16", "convert")
    lens = stored(coefficients=ABC, d=25.0, e=-14.0)
    script = export(lens, "imagemagick").content.decode()
    # Dots that are wide enough to be found again, their centres measured by weight.
    y, x = np.mgrid[0 : SIZE[1], 0 : SIZE[0]]
    dots = [(300, 300), (1700, 250), (1000, 760), (400, 1300), (1750, 1200)]
    picture = sum(np.exp(-((x - u) ** 2 + (y - v) ** 2) / 50.0) for u, v in dots)
    Image.fromarray((np.clip(picture, 0, 1) * 255).astype(np.uint8)).save(tmp_path / "in.png")
    # Without a `magick`, as on Debian, `convert` of ImageMagick 6 does it.
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "convert").symlink_to(convert)
    (tmp_path / "correct.sh").write_text(f"PATH={tmp_path}/bin\n{script}")
    run(
        [
            "/bin/sh",
            str(tmp_path / "correct.sh"),
            *(str(tmp_path / n) for n in ("in.png", "out.png")),
        ]
    )
    theirs = np.asarray(Image.open(tmp_path / "out.png").convert("L"), dtype=float)
    ideal = lens.lens.undistort(np.array(dots, dtype=float)) + np.array([25.0, -14.0])
    for u, v in ideal:
        window = np.hypot(x - u, y - v) < 30
        weight = theirs * window
        found = np.array([(x * weight).sum(), (y * weight).sum()]) / weight.sum()
        assert np.hypot(*(found - [u, v])) < 0.1


class TestRefit:
    """A model in the words of another."""

    def test_an_equivalent_model_is_found_exactly(self) -> None:
        lens = stored("poly3", k1=-0.04).lens
        found = refit(lens, get_model("ptlens"), centre=False)
        assert found.deviation_px < 1e-6
        assert found.lens.coefficients["b"] == pytest.approx(-0.04, abs=1e-9)

    def test_opencv_and_brown_of_one_curve(self) -> None:
        # poly5 is opencv with k1, k2 alone, its k in focal lengths.
        lens = stored("poly5", k1=-0.03, k2=0.004).lens
        found = refit(lens, get_model("opencv"), centre=False, focal_px=3072.0)
        assert found.deviation_px < 1e-6
        assert found.lens.coefficients["k1"] == pytest.approx(-0.03 * 16, rel=1e-6)
        assert found.lens.coefficients["k2"] == pytest.approx(0.004 * 256, rel=1e-4)

    def test_the_centre_is_kept(self) -> None:
        lens = stored("division", l1=-0.03, d=20.0, e=-11.0).lens
        found = refit(lens, get_model("ptlens"), centre=True)
        assert found.deviation_px < 0.1
        assert found.lens.coefficients["d"] == pytest.approx(20.0, abs=0.5)
        without = refit(lens, get_model("ptlens"), centre=False)
        assert without.deviation_px > 5 * found.deviation_px

    def test_the_deviation_is_what_an_independent_fit_leaves(self) -> None:
        """Radial only: ideal radii of the division model, ptlens fitted to them by lstsq."""
        values = {"l1": -0.12, "l2": 0.02}
        found = refit(
            stored("division", coefficients=values).lens, get_model("ptlens"), centre=False
        )
        y, x = np.mgrid[0:1535:41j, 0:2047:41j]
        observed = np.hypot(x - 1023.5, y - 767.5).ravel() / 768
        ideal = observed * scale("division", values, observed)
        basis = np.stack([ideal**k for k in (4, 3, 2, 1)], axis=1)
        best = np.linalg.lstsq(basis, observed, rcond=None)[0]
        expected = np.max(np.abs(basis @ best - observed)) * 768
        assert found.deviation_px == pytest.approx(expected, rel=1e-3)

    def test_tangential_terms_count_but_for_a_perspective(self) -> None:
        lens = stored("brown", k1=0.02, p1=0.002, p2=-0.001).lens
        found = refit(lens, get_model("opencv"), centre=True, focal_px=2000.0)
        assert found.deviation_px < 0.05
        assert abs(found.lens.coefficients["d"]) > 10
        assert refit(lens, get_model("opencv"), centre=False, focal_px=2000.0).deviation_px > 0.5


@pytest.mark.parametrize("name", TARGETS)
def test_every_target_takes_every_model(name: str) -> None:
    lenses = {
        "brown": {"k1": 0.02},
        "division": {"l1": -0.02},
        "poly3": {"k1": -0.01},
        "radial:2,4": {"a2": 0.01},
        "poly5": {"k1": -0.01},
    }
    for model, values in lenses.items():
        made = export(stored(model, coefficients=values), name)
        assert made.content
        if made.deviation_px is not None:
            assert made.deviation_px < 0.1


def test_a_large_deviation_needs_force(tmp_path: Path) -> None:
    made = calibration("division", l1=-0.15, errors={"l1": 0.001})
    path = saved(tmp_path / "r.json", made)
    with pytest.raises(OptionError, match="px off over the photo") as error:
        export_file(path, "lensfun", None, None, {})
    assert "--force" in error.value.hint
    forced = export_file(path, "lensfun", None, None, {}, force=True)
    assert forced.deviation_px is not None
    assert forced.deviation_px > 0.1
    assert forced.path == tmp_path / "r.lensfun.xml"


def test_square_pixels(tmp_path: Path) -> None:
    """Points of a 720x576 video frame at 16:15, against the same lens at 768x576."""
    made = calibration(size=(720, 576), pixel_aspect=16 / 15, b=-0.05, d=9.0)
    path = saved(tmp_path / "r.json", made)
    exported = export_file(path, "hugin-ini", None, None, {})
    assert any("square pixels, 768x576" in note for note in exported.notes)
    assert b"image_width=768" in exported.content
    assert b"\nd=9.6\n" in exported.content


def test_labels_and_what_is_missing(tmp_path: Path) -> None:
    path = saved(tmp_path / "r.json", calibration(focal_mm=None, crop_factor=None, b=-0.02))
    with pytest.raises(OptionError, match="crop factor is not known"):
        export_file(path, "lensfun", None, None, {"focal_mm": 18.0})
    with pytest.raises(OptionError, match="focal length is not known"):
        export_file(path, "lensfun", None, None, {"crop_factor": 1.5})
    facts = {"focal_mm": 18.0, "crop_factor": 1.5, "model": "My lens", "maker": "Me"}
    content = export_file(path, "lenses-txt", None, None, facts).content.decode()
    assert "My lens: Me, nikon995, 1.5, 4:3" in content
    assert "distortion(18mm) = 0.000000000, -0.020000000, 0.000000000" in content


def test_a_project_s_lens_is_exported_and_several_are_asked_about(tmp_path: Path) -> None:
    path = tmp_path / "pano.pto"
    path.write_text(
        "# hugin project file\n"
        'i w2048 h1536 f0 v50 a0.01 b-0.05 c0.02 d0 e0 n"a.jpg"\n'
        'i w2048 h1536 f0 v=0 a=0 b=0 c=0 d=0 e=0 n"b.jpg"\n'
    )
    content = export_file(str(path), "imagemagick", None, None, {}).content.decode()
    assert 'Barrel "0.01 -0.05 0.02 1.02"' in content
    with pytest.raises(OptionError, match="holds lens values only"):
        export_file(str(path), "json", None, None, {})
    path.write_text(path.read_text() + 'i w2048 h1536 f0 v50 a0 b0 c0 d0 e0 n"c.jpg"\n')
    with pytest.raises(OptionError, match="holds 3 lenses"):
        export_file(str(path), "imagemagick", None, None, {})
    chosen = export_file(str(path), "imagemagick", None, 2, {}).content.decode()
    assert 'Barrel "0 0 0 1"' in chosen


def test_json_is_the_result_itself(tmp_path: Path) -> None:
    path = saved(tmp_path / "r.json", calibration(b=-0.02))
    made = export_file(path, "json", tmp_path / "copy.json", None, {})
    assert made.content == Path(path).read_bytes()
    assert io.BytesIO(made.content).read(1) == b"{"


@pytest.mark.parametrize(
    ("make", "model", "menu"),
    [
        ("Canon", "Canon EOS 450D", ("Canon", "EOS 450D")),
        ("NIKON CORPORATION", "NIKON D7100", ("NIKON CORPORATION", "D7100")),
        ("NIKON", "E995", ("NIKON", "E995")),
    ],
)
def test_a_ptlens_profile_names_the_camera_as_exif_does(
    make: str, model: str, menu: tuple[str, str], tmp_path: Path
) -> None:
    shot = read_photo(photo(tmp_path / "a.jpg", make=make, model=model, focal=18.0))
    made = calibration(size=(400, 300), b=-0.02)
    facts = replace(shot.facts, crop_factor=1.6)
    observations = replace(made.observations, lenses=(facts,))
    result = saved(tmp_path / "r.json", replace(made, observations=observations))
    content = export_file(result, "ptlens", None, None, {}).content
    assert f"menu_make: {menu[0]}\nmenu_model: {menu[1]}\n" in content.decode()
    assert f"exif_make: {make}\nexif_model: {model}\n" in content.decode()
    path = tmp_path / "x.txt"
    path.write_bytes(content)
    assert "b = -0.02" in find_correction(shot, LensRequest(source=str(path))).description
    # Profiles of other programs spell the model without its maker, or with.
    path.write_bytes(
        content.replace(f"exif_model: {model}".encode(), f"exif_model: {menu[1]}".encode())
    )
    assert "b = -0.02" in find_correction(shot, LensRequest(source=str(path))).description


@pytest.mark.parametrize("model", ["ptlens", "division", "opencv", "brown"])
def test_opencv_makes_plumbline_s_own_picture(model: str, tmp_path: Path) -> None:
    values = {
        "ptlens": {"b": -0.03, "d": 12.0, "e": -7.0},
        "division": {"l1": -0.03},
        "opencv": {"k1": -0.1, "k2": 0.02, "p1": 0.001, "d": 9.0, "e": 4.0},
        "brown": {"k1": 0.02, "p1": 0.0005, "p2": -0.0003},
    }[model]
    lens = stored(model, focal_px=2200.0, coefficients=values)
    lens = replace(lens, facts=LensFacts(focal_px=2200.0))
    made = export(lens, "opencv")
    assert any("new_camera_matrix" in note for note in made.notes)
    path = tmp_path / "lens.yml"
    path.write_bytes(made.content)
    store = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    names = ("camera_matrix", "distortion_coefficients", "new_camera_matrix")
    matrix, k, new = (store.getNode(name).mat() for name in names)
    x, y = cv2.initUndistortRectifyMap(matrix, k, None, new, SIZE, cv2.CV_32FC1)  # type: ignore[call-overload]
    theirs = np.stack((x, y), axis=-1)[::97, ::89]
    rows, columns = np.mgrid[0 : SIZE[1] : 97, 0 : SIZE[0] : 89]
    ideal = np.stack((columns, rows), axis=-1).astype(float)
    ours = lens.lens.distort(ideal)
    inside = np.all((ours >= 0) & (ours <= np.array(SIZE) - 1.0), axis=-1)
    off = np.hypot(*np.moveaxis(theirs - ours, -1, 0))[inside]
    assert np.max(off) < (made.deviation_px or 0.0) * 1.2 + 0.002


@pytest.mark.parametrize("target", ["stmap", "csv", "lensfum"])
def test_a_target_that_is_not_one(tmp_path: Path, target: str) -> None:
    result = saved(tmp_path / "r.json", calibration())
    with pytest.raises(OptionError, match="there is no target") as caught:
        write_export(result, target)
    assert "imagemagick" in caught.value.hint

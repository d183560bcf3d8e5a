"""Calibrations joined over focal length."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from plumbline.errors import OptionError, ReadError, UnsupportedModelError, WriteError
from plumbline.formats.base import Source
from plumbline.frame import Array
from plumbline.lenses.lookup import find_correction
from plumbline.lenses.request import LensRequest
from plumbline.lenses.zoom.join import join
from plumbline.lenses.zoom.json import read_zoom, zoom_text
from plumbline.lenses.zoom.needs import needs
from plumbline.lenses.zoom.zoom_lens import ZoomLens, pool
from plumbline.observations.facts import LensFacts
from plumbline.photos.exif import PhotoFacts
from plumbline.report.figures.zoom import plot_zoom
from plumbline.result.calibration import Calibration
from plumbline.writing.zoom import zoom_bytes
from tests.lenses.library import lensfunpy
from tests.lenses.made import calibration

FOCALS = (8.2, 10.1, 13.6, 18.4, 23.4, 28.3, 31.0)
B = (-0.019966, -0.010931, -0.002049, 0.003845, 0.006884, 0.008666, 0.009298)
SHOT = PhotoFacts((2048, 1536), LensFacts(camera="NIKON E995", focal_mm=12.0))


def named(*made: Calibration) -> list[tuple[str, Calibration]]:
    return [(f"{index}.json", each) for index, each in enumerate(made)]


def coolpix(method: str = "hermite", degree: int = 3) -> ZoomLens:
    made = [calibration(b=b, focal_mm=f) for f, b in zip(FOCALS, B, strict=True)]
    return join(named(*made), method, degree)  # type: ignore[arg-type]


def spread(seed: int, size: int) -> Array:
    """A covariance with strong correlations."""
    root = np.random.default_rng(seed).normal(size=(size, size)) * 1e-3
    return root @ root.T + 1e-9 * np.eye(size)


def test_the_literature_s_cubic() -> None:
    found = coolpix("polynomial").polynomials()
    assert list(found) == ["b"]
    expected = [0.000005142, -0.000380839, 0.009606325, -0.075316854]
    assert np.max(np.abs(found["b"] - expected)) < 5e-10
    at_12 = coolpix("polynomial").at(12.0)[1]
    assert at_12 == pytest.approx(np.polyval(expected, 12.0), abs=1e-6)


def test_the_lens_of_a_zoom_json_is_evaluated_at_the_photo_s_focal_length(tmp_path: Path) -> None:
    path = tmp_path / "zoom.json"
    path.write_text(zoom_text(coolpix("polynomial")))
    found = find_correction(SHOT, LensRequest(source=str(path)))
    b = np.polyval([0.000005142, -0.000380839, 0.009606325, -0.075316854], 12.0)
    x = found.distort(np.array([1023.5 + 1152, 767.5]))[0]
    assert x == pytest.approx(1023.5 + 1152 * (1 - b + b * 1.5**2), abs=2e-3)
    assert "polynomial over 7 focal lengths" in found.description
    tele = PhotoFacts((2048, 1536), LensFacts(camera="NIKON E995", focal_mm=33.0))
    assert any(
        "as at 31 mm" in n for n in find_correction(tele, LensRequest(source=str(path))).notes
    )
    far = PhotoFacts((2048, 1536), LensFacts(camera="NIKON E995", focal_mm=35.0))
    with pytest.raises(OptionError, match="more than 10 %"):
        find_correction(far, LensRequest(source=str(path)))


def test_calibrations_at_one_focal_length_are_pooled_by_their_covariances() -> None:
    truth = np.array([0.01, -0.05, 0.02])
    covariances = [spread(1, 3), spread(2, 3), 4 * spread(3, 3)]
    random = np.random.default_rng(4)
    values = [random.multivariate_normal(truth, c) for c in covariances]
    padded = [np.append(v, [0.0, 0.0]) for v in values]
    wide = [np.pad(c, (0, 2)) for c in covariances]
    node = pool(18.0, padded, wide)
    # The same as stacked generalised least squares for one vector.
    design = np.tile(np.eye(3), (3, 1))
    weight = np.zeros((9, 9))
    for index, c in enumerate(covariances):
        weight[3 * index : 3 * index + 3, 3 * index : 3 * index + 3] = np.linalg.inv(c)
    normal = design.T @ weight @ design
    expected = np.linalg.solve(normal, design.T @ weight @ np.concatenate(values))
    np.testing.assert_allclose(node.values[:3], expected, rtol=1e-6)
    residual = np.concatenate(values) - design @ expected
    birge = max(1.0, np.sqrt(residual @ weight @ residual / 6))
    assert node.birge == pytest.approx(birge, rel=1e-6)
    np.testing.assert_allclose(
        node.covariance[:3, :3], np.linalg.inv(normal) * birge**2, rtol=1e-5, atol=1e-15
    )


def test_pooling_is_honest_over_many_specimens() -> None:
    """The pooled error covers the truth as often as it says, and widens for differing lenses."""
    random, inside = np.random.default_rng(7), 0
    for _ in range(400):
        draws = [np.array([x, 0, 0]) for x in random.normal(0.02, 0.003, 4)]
        node = pool(10.0, draws, [np.diag([0.003**2, 0, 0])] * 4)
        inside += abs(node.values[0] - 0.02) <= 1.96 * node.errors[0]
    assert 0.92 <= inside / 400 <= 1.0
    apart = pool(10.0, [np.array([x, 0, 0]) for x in (0.0, 0.1)], [np.diag([1e-6, 0, 0])] * 2)
    assert apart.birge == pytest.approx(0.1 / np.sqrt(2) / 1e-3, rel=1e-9)
    assert apart.scatter[0] == pytest.approx(0.1 / np.sqrt(2))


def test_the_scatter_of_the_centre_is_that_of_the_literature() -> None:
    """Three specimens whose centres lie 30 px apart."""
    errors = {"b": 0.001, "d": 2.0, "e": 2.0}
    made = [
        calibration(b=-0.02, errors=errors, d=d, e=e) for d, e in ((0, 0), (30.0, 0), (15.0, 10.0))
    ]
    (node,) = join(named(*made)).nodes
    assert node.centre_spread * 768 == pytest.approx(30.0)
    assert len(node.sources) == 3
    assert node.values[3] * 768 == pytest.approx(15.0)  # equal errors: the mean
    assert node.errors[3] * 768 == pytest.approx(2.0 / np.sqrt(3) * node.birge)


def test_focal_lengths_that_differ_by_rounding_are_one() -> None:
    lens = join(named(calibration(focal_mm=18.0), calibration(focal_mm=18.05)))
    assert len(lens.nodes) == 1


def test_errors_of_the_curve_are_those_of_its_nodes_joined() -> None:
    lens = coolpix("linear")
    middle = (8.2 + 10.1) / 2
    assert lens.covariance_at(8.2)[1, 1] == pytest.approx(1e-6)
    assert lens.covariance_at(middle)[1, 1] == pytest.approx(2 * 0.25e-6)


def test_the_largest_gap_needs_a_calibration_most() -> None:
    """A bend that two of three focal lengths hide."""
    made = [
        calibration(b=b, focal_mm=f, errors={"b": 1e-6})
        for f, b in ((10.0, -0.05), (12.0, -0.04), (40.0, 0.02), (45.0, 0.021))
    ]
    first = needs(join(named(*made)))[0]
    assert first.between == (12.0, 40.0)
    assert first.focal_mm == pytest.approx(np.sqrt(12 * 40))
    noisy = [calibration(b=0.0, focal_mm=f, errors={"b": s}) for f, s in ((10, 1e-6), (20, 1e-2))]
    assert needs(join(named(*noisy)))[0].focal_mm == 20.0


def test_json_reads_back_exactly(tmp_path: Path) -> None:
    made = [
        calibration(a=0.1, b=-0.05, d=3.0, focal_mm=f, errors={"a": 0.01, "b": 0.02, "d": 1.0})
        for f in (10.0, 20.0)
    ]
    lens = join(named(*made), "linear")
    again = read_zoom(Source("zoom.json", zoom_text(lens).encode())).lens
    assert zoom_text(again) == zoom_text(lens)
    np.testing.assert_array_equal(again.at(13.0), lens.at(13.0))


@pytest.mark.parametrize(
    "change",
    [
        ("nodes", []),
        ("method", "magic"),
        ("size", [0, 5]),
        ("model", "opencv"),
        ("nodes", None),
        ("free", ["z"]),
        ("lens", 5),
        ("degree", "x"),
    ],
)
def test_damaged_json_ends_in_a_sentence(change: tuple[str, object]) -> None:
    import json

    whole = json.loads(zoom_text(coolpix()))
    whole[change[0]] = change[1]
    with pytest.raises(ReadError) as error:
        read_zoom(Source("zoom.json", json.dumps(whole).encode()))
    assert "zoom.json" in error.value.message
    assert error.value.hint


def test_lensfun_reads_the_zoom_and_interpolates_as_hermite_does() -> None:
    lens = coolpix()
    content, notes = zoom_bytes(lens, Path("zoom.xml"))
    assert notes == []
    database = lensfunpy.Database(xml=content.decode(), load_common=False, load_bundled=False)
    (found,) = database.lenses
    for focal in np.linspace(8.2, 31.0, 40):
        terms = found.interpolate_distortion(float(focal)).terms
        np.testing.assert_allclose(terms, lens.at(float(focal))[:3], atol=1e-6)


def test_what_lensfun_makes_of_another_curve_is_measured() -> None:
    _, notes = zoom_bytes(coolpix("linear"), Path("zoom.xml"))
    assert any(
        "LensFun interpolates between these focal lengths in its own way" in n for n in notes
    )


def test_lensfun_holds_one_centre() -> None:
    errors = {"b": 0.001, "d": 1.0}
    made = [calibration(b=-0.02, d=d, focal_mm=f, errors=errors) for f, d in ((10, 0.0), (20, 8.0))]
    _, notes = zoom_bytes(join(named(*made)), Path("zoom.xml"))
    assert any("one distortion centre" in note and "4.0 px" in note for note in notes)


def test_lenses_txt() -> None:
    lens = join(named(*[calibration(b=b, focal_mm=f) for f, b in ((10, -0.02), (20, 0.01))]))
    content, _ = zoom_bytes(lens, Path("lenses.txt"))
    rows = content.decode().splitlines()[1:]
    assert rows == [
        "NIKON E995 lens: Nikon, nikon995, 4.843, 4:3",
        "distortion(10mm) = 0.000000000, -0.020000000, 0.000000000",
        "distortion(20mm) = 0.000000000, 0.010000000, 0.000000000",
    ]


def test_files_that_cannot_be_made() -> None:
    with pytest.raises(WriteError, match="zoom lenses are not written as"):
        zoom_bytes(coolpix(), Path("zoom.doc"))
    division = join(named(calibration("division", l1=-0.02)))
    with pytest.raises(UnsupportedModelError, match="does not know the model division"):
        zoom_bytes(division, Path("zoom.xml"))
    bare = join(named(calibration(crop_factor=None)))
    with pytest.raises(OptionError, match="crop factor is not known"):
        zoom_bytes(bare, Path("zoom.xml"))
    with pytest.raises(WriteError, match="plots are not written"):
        plot_zoom(coolpix(), Path("zoom.gif"))


@pytest.mark.parametrize(("suffix", "magic"), [(".png", b"\x89PNG"), (".svg", b"<?xml")])
def test_plots(suffix: str, magic: bytes) -> None:
    made = [
        calibration(b=b, focal_mm=f, errors={"b": 1e-3, "d": 1.0})
        for f, b in ((10, -0.02), (20, 0.01))
    ]
    content = plot_zoom(join(named(*made)), Path("plot" + suffix))
    assert content.startswith(magic)
    assert b"made by plumbline" in content[:1024]


@pytest.mark.parametrize(
    ("other", "sentence"),
    [
        ({"model": "poly3", "k1": 0.01}, "was fitted with poly3"),
        ({"lens": "Other"}, "is a calibration of Other"),
        ({"crop_factor": 1.5}, "the crop factor of 1.json is 1.5"),
        ({"size": (2000, 1000)}, "differ in their shape"),
        ({"focal_mm": None}, "the focal length of this calibration is not known"),
        ({"errors": {"a": 0.1, "b": 0.1}}, "do not free the same coefficients"),
        ({"a": 0.01}, "hold a coefficient at different values"),
        ({"size": (1536, 2048), "d": 4.0}, "stands upright"),
    ],
)
def test_calibrations_that_do_not_belong_together(other: dict[str, object], sentence: str) -> None:
    first = calibration(lens="Zoom")
    wrong = calibration(**({"lens": "Zoom"} | other))  # type: ignore[arg-type]
    with pytest.raises(OptionError, match=sentence):
        join(named(first, wrong))


def test_models_in_focal_lengths_are_refused() -> None:
    with pytest.raises(OptionError, match="focal lengths, which change as the lens zooms"):
        join(named(calibration("opencv", focal_px=2000.0)))

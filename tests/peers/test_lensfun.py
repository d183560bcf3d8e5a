"""The LensFun library loads the profiles that plumbline writes, and bends a photo as it does."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import lensfunpy as _lensfunpy
import numpy as np
import pytest
from lxml import etree  # pyright: ignore[reportAttributeAccessIssue]

import plumbline
from plumbline.formats.lens_files.lensfun import Distortion, LensfunLens, lensfun_xml
from plumbline.frame import Array, Frame
from plumbline.geometry.lens import Lens
from plumbline.models import get_model
from tests.truth import TrueLens

lensfunpy: Any = _lensfunpy  # it has no types

FOCAL_MM = 18.0
CROP = 1.534
SIZES = {
    "3:2 landscape": (3000, 2000),
    "3:2 portrait": (2000, 3000),
    "4:3 landscape": (2048, 1536),
    "4:3 portrait": (1536, 2048),
}
CASES = {
    "ptlens": ({"a": 0.0244, "b": -0.0649, "c": 0.0015}, 0.05, 0.4),
    "poly3": ({"k1": -0.0312}, 0.05, 0.4),
    "poly5": ({"k1": -0.0383, "k2": 0.0052}, 0.05, 0.05),
}


def _modifier(xml: bytes, size: tuple[int, int]) -> Any:
    database = lensfunpy.Database(xml=xml.decode(), load_common=False, load_bundled=False)
    (lens,) = database.lenses
    modifier = lensfunpy.Modifier(lens, CROP, *size)
    modifier.initialize(FOCAL_MM, 8.0, scale=1.0, flags=lensfunpy.ModifyFlags.DISTORTION)
    return modifier


def _profile(
    model: str, coefficients: dict[str, float], aspect: float, centre: tuple[float, float] = (0, 0)
) -> bytes:
    head = LensfunLens("Maker", "A lens", "Generic", CROP, aspect, centre)
    return lensfun_xml(head, [Distortion(model, FOCAL_MM, coefficients)])


def _as_lensfun_measures(lens: Lens, points_px: Array) -> Array:
    """Distort as the lens does, with radii in half the shorter side less one pixel.

    LensFun 0.3 takes (short side − 1)/2 for half the shorter side; a frame one pixel smaller has
    that radius and, shifted by half a pixel, the same centre.
    """
    frame = Frame(lens.frame.width - 1, lens.frame.height - 1)
    same = Lens(lens.model, frame, lens.coefficients, lens.focal_px)
    return same.distort(points_px - 0.5) + 0.5


@pytest.mark.parametrize("model", CASES)
@pytest.mark.parametrize("shape", SIZES)
def test_lensfun_displaces_points_as_plumbline_does(model: str, shape: str) -> None:
    coefficients, median_px, largest_px = CASES[model]
    width, height = size = SIZES[shape]
    modifier = _modifier(_profile(model, coefficients, max(size) / min(size)), size)
    theirs = modifier.apply_geometry_distortion()
    y, x = np.mgrid[0:height:37, 0:width:37]
    points = np.stack((x, y), axis=-1).astype(float)
    lens = Lens(get_model(model), Frame(width, height), coefficients | {"d": 0.0, "e": 0.0})
    ours = _as_lensfun_measures(lens, points)
    off = np.hypot(*np.moveaxis(theirs[::37, ::37] - ours, -1, 0))
    moved = np.hypot(*np.moveaxis(ours - points, -1, 0))
    assert np.median(moved) > 5
    assert np.median(off) <= median_px
    assert np.max(off) <= largest_px


def test_the_centre_of_a_profile_is_where_plumbline_puts_it() -> None:
    """LensFun centres both sides on (d, e), plumbline the observed one: a shift apart."""
    width, height = size = (3000, 2000)
    coefficients, d, e = CASES["poly5"][0], 31.0, -17.0
    xml = _profile("poly5", coefficients, 1.5, (d / 1000, e / 1000))
    theirs = _modifier(xml, size).apply_geometry_distortion()[::50, ::50]
    y, x = np.mgrid[0:height:50, 0:width:50]
    ideal = np.stack((x, y), axis=-1).astype(float)
    lens = Lens(get_model("poly5"), Frame(width, height), coefficients | {"d": d, "e": e})
    ours = _as_lensfun_measures(lens, ideal - np.array([d, e]))
    assert np.max(np.hypot(*np.moveaxis(theirs - ours, -1, 0))) <= 0.05
    wrong = _as_lensfun_measures(lens, ideal + np.array([d, e]))
    assert np.max(np.hypot(*np.moveaxis(theirs - wrong, -1, 0))) > 1


def test_acm_is_refused_by_the_released_library_and_right_by_its_formula() -> None:
    values = {"k1": -0.08, "k2": 0.03, "k3": -0.004, "k4": 0.0007, "k5": -0.0004}
    xml = _profile("acm", values, 1.5)
    assert etree.fromstring(xml).get("version") == "2"
    with pytest.raises(lensfunpy.LensfunError):
        lensfunpy.Database(xml=xml.decode(), load_common=False, load_bundled=False)
    # Adobe's formula, radius in focal lengths, written out here from LensFun's documentation.
    frame, focal_px = Frame(3000, 2000), 2300.0
    points = np.random.default_rng(5).uniform([0, 0], [2999, 1999], (500, 2))
    x, y = ((points - [1499.5, 999.5]) / focal_px).T
    r2 = x**2 + y**2
    radial = 1 + values["k1"] * r2 + values["k2"] * r2**2 + values["k3"] * r2**3
    cross = 2 * (values["k4"] * y + values["k5"] * x)
    expected = np.stack(
        (
            x * radial + x * cross + values["k5"] * r2,
            y * radial + y * cross + values["k4"] * r2,
        ),
        axis=1,
    ) * focal_px + [1499.5, 999.5]
    lens = Lens(get_model("acm"), frame, values | {"d": 0.0, "e": 0.0}, focal_px)
    assert np.max(np.abs(lens.distort(points) - expected)) < 1e-9


def test_a_wrong_aspect_ratio_shows(tmp_path: Path) -> None:
    """Negative control: the same values read as of another sensor shape bend differently."""
    size = (3000, 2000)
    right = _modifier(_profile("poly5", CASES["poly5"][0], 1.5), size).apply_geometry_distortion()
    wrong = _modifier(_profile("poly5", CASES["poly5"][0], 4 / 3), size)
    assert np.max(np.abs(right - wrong.apply_geometry_distortion())) > 1


@pytest.mark.parametrize("shape", SIZES)
@pytest.mark.parametrize("model", ["ptlens", "poly5"])
def test_a_fitted_profile_bends_as_the_fit_does(model: str, shape: str, tmp_path: Path) -> None:
    """From picks to the written file to LensFun's own arithmetic, centre included."""
    width, height = size = SIZES[shape]
    d, e = 12.0, -7.0
    truth = TrueLens("ptlens", {"a": 0.0244, "b": -0.0649, "c": 0.0015, "d": d, "e": e}, size)
    made = plumbline.calibrate(
        plumbline.Observations.from_arrays(truth.lines(16, 12), size),
        model,
        free=(*plumbline.get_model(model).coefficients, "d", "e"),
    )
    facts = plumbline.LensFacts(focal_mm=FOCAL_MM, crop_factor=CROP)
    made = replace(made, observations=replace(made.observations, lenses=(facts,)))
    xml = plumbline.write(made, tmp_path / "made.xml").read_bytes()
    theirs = _modifier(xml, size).apply_geometry_distortion()[::50, ::50]
    y, x = np.mgrid[0:height:50, 0:width:50]
    ideal = np.stack((x, y), axis=-1).astype(float)
    centre = np.array([made.coefficients["d"], made.coefficients["e"]])
    # LensFun centres both sides on (d, e), plumbline the observed one.
    ours = _as_lensfun_measures(made.lens, ideal - centre)
    off = np.hypot(*np.moveaxis(theirs - ours, -1, 0))
    assert np.median(off) <= 0.05
    assert np.max(off) <= (0.4 if model == "ptlens" else 0.05)
    assert centre == pytest.approx([d, e], abs=0.5 if model == "ptlens" else 40)

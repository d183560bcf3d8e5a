"""A model in a frame: points in, points out, in pixels."""

from __future__ import annotations

from typing import Any

import lensfunpy as untyped_lensfun
import numpy as np
import pytest

from plumbline.errors import OptionError
from plumbline.frame import Frame
from plumbline.geometry.lens import Lens
from plumbline.models import MODELS, get_model
from tests import truth
from tests.truth import TrueLens

FRAME = Frame(3001, 2001)


def ptlens(frame: Frame = FRAME, **given: float) -> Lens:
    return Lens(MODELS["ptlens"], frame, dict.fromkeys("abcde", 0.0) | given)


def test_barrel_pulls_the_corners_in() -> None:
    """The direction trap: b < 0 is barrel, and straightening moves the corners out."""
    lens = ptlens(b=-0.03)
    middle, corner = np.array(lens.centre_px), np.array([3000.0, 2000.0])
    ideal = lens.undistort(corner)
    assert np.hypot(*(ideal - middle)) > np.hypot(*(corner - middle)) + 50
    assert np.hypot(*(lens.distort(corner) - middle)) < np.hypot(*(corner - middle)) - 50


def test_ptlens_is_true_to_scale_at_half_the_shorter_side() -> None:
    lens = ptlens(a=0.02, b=-0.05, c=0.03)
    circle = np.linspace(0, 2 * np.pi, 12)
    rim = np.array(lens.centre_px) + 1000.5 * np.stack((np.cos(circle), np.sin(circle)), axis=-1)
    np.testing.assert_allclose(lens.undistort(rim), rim, rtol=0, atol=1e-9)


def test_the_distortion_centre_moves_right_and_down_in_pixels() -> None:
    lens = ptlens(b=-0.05, d=40.0, e=-25.0)
    assert lens.centre_px == (1540.0, 975.0)
    np.testing.assert_allclose(lens.distort(FRAME.centre_px), (1540.0, 975.0), rtol=0, atol=1e-9)
    np.testing.assert_allclose(lens.undistort((1540.0, 975.0)), FRAME.centre_px, rtol=0, atol=1e-9)


@pytest.mark.parametrize("aspect", [0.9, 1.0, 1.422])
@pytest.mark.parametrize("size", [(720, 576), (576, 720)])
def test_pixels_that_are_not_square_agree_with_the_truth(
    aspect: float, size: tuple[int, int]
) -> None:
    c = {"a": 0.01, "b": -0.06, "c": 0.02, "d": 9.0, "e": -4.0}
    lens = ptlens(Frame(*size, aspect), **c)
    true = TrueLens("ptlens", c, size, aspect=aspect)
    points = truth.grid_px(size)
    np.testing.assert_allclose(lens.undistort(points), true.undistort(points), rtol=0, atol=1e-9)
    np.testing.assert_allclose(lens.distort(points), true.distort(points), rtol=0, atol=1e-9)


@pytest.mark.parametrize("shape", [(2,), (1, 2), (3, 4, 2), (0, 2)])
@pytest.mark.parametrize("name", ["ptlens", "brown", "division"])
def test_shapes_are_kept(name: str, shape: tuple[int, ...]) -> None:
    model = get_model(name)
    lens = Lens(model, FRAME, dict.fromkeys((*model.coefficients, "d", "e"), 0.001))
    points = np.full(shape, 77.0)
    assert lens.undistort(points).shape == shape
    assert lens.distort(points).shape == shape
    if points.size:
        single = lens.undistort([77.0, 77.0])
        np.testing.assert_array_equal(lens.undistort(points).reshape(-1, 2)[0], single)


def test_points_given_are_left_as_they_were() -> None:
    points = np.array([[10, 20], [30, 40]])
    ptlens(b=-0.03).undistort(points)
    ptlens(b=-0.03).distort(points)
    assert points.tolist() == [[10, 20], [30, 40]]


def test_vector_has_the_models_order() -> None:
    c = {"k3": 3.0, "p2": 5.0, "k1": 1.0, "p1": 4.0, "k2": 2.0, "e": 0.0, "d": 0.0}
    assert Lens(MODELS["brown"], FRAME, c).vector.tolist() == [1, 2, 3, 4, 5]
    assert Lens(MODELS["opencv"], FRAME, c, focal_px=9.0).vector.tolist() == [1, 2, 4, 5, 3]


def test_unit_is_the_focal_length_or_half_the_shorter_side() -> None:
    zero = dict.fromkeys((*MODELS["acm"].coefficients, "d", "e"), 0.0)
    assert Lens(MODELS["acm"], FRAME, zero, focal_px=2345.0).unit_px == 2345.0
    assert ptlens().unit_px == 1000.5


@pytest.mark.parametrize("focal_px", [None, 0.0, -5.0, float("nan")])
def test_a_model_in_focal_lengths_needs_one(focal_px: float | None) -> None:
    zero = dict.fromkeys((*MODELS["acm"].coefficients, "d", "e"), 0.0)
    with pytest.raises(OptionError, match="focal") as caught:
        Lens(MODELS["acm"], FRAME, zero, focal_px=focal_px)
    assert "--focal-px" in caught.value.hint


@pytest.mark.parametrize(
    "coefficients",
    [
        {},
        {"a": 0.0, "b": 0.0, "c": 0.0},
        {"a": 0.0, "b": 0.0, "c": 0.0, "d": 0.0, "e": 0.0, "k1": 0.0},
        {"k1": 0.0, "d": 0.0, "e": 0.0},
    ],
)
def test_coefficients_must_be_all_of_the_models(coefficients: dict[str, float]) -> None:
    with pytest.raises(OptionError, match="a, b, c, d, e"):
        Lens(MODELS["ptlens"], FRAME, coefficients)


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), float("-inf")])
@pytest.mark.parametrize("name", ["b", "d"])
def test_coefficients_must_be_finite(name: str, bad: float) -> None:
    with pytest.raises(OptionError, match="not finite"):
        Lens(MODELS["ptlens"], FRAME, dict.fromkeys("abcde", 0.0) | {name: bad})


def test_a_displaced_centre_brings_the_fold_into_the_photo() -> None:
    # b alone folds at an observed radius of 2/3 (1−b) √((b−1)/3b).
    b = -0.125
    fold_px = 1000.5 * 2 / 3 * (1 - b) * np.sqrt((b - 1) / (3 * b))
    corner_px = np.hypot(1500, 1000)
    assert fold_px < corner_px
    assert ptlens(b=b).fold_radius_px() == pytest.approx(fold_px, abs=1e-6)
    milder = -0.05
    fold_px = 1000.5 * 2 / 3 * (1 - milder) * np.sqrt((milder - 1) / (3 * milder))
    assert corner_px < fold_px < np.hypot(1620, 1080)
    assert ptlens(b=milder).fold_radius_px() is None
    shifted = ptlens(b=milder, d=-120.0, e=-80.0)
    assert shifted.fold_radius_px() == pytest.approx(fold_px, abs=1e-6)


lensfunpy: Any = untyped_lensfun

LENSFUN = """<lensdatabase version="1">
  <mount><name>M</name></mount>
  <camera><maker>K</maker><model>K1</model><mount>M</mount><cropfactor>1.5</cropfactor></camera>
  <lens>
    <maker>K</maker><model>K 18mm</model><mount>M</mount><cropfactor>1.5</cropfactor>
    <calibration><distortion focal="18" {terms}/></calibration>
  </lens>
</lensdatabase>"""


@pytest.mark.parametrize(
    ("name", "c"),
    [
        ("ptlens", {"a": 0.0213, "b": -0.0764, "c": 0.0321}),
        ("ptlens", {"a": 0.0, "b": 0.04, "c": 0.0}),
        ("poly3", {"k1": -0.055}),
        ("poly5", {"k1": -0.07, "k2": 0.012}),
    ],
)
@pytest.mark.parametrize("size", [(1501, 1001), (1001, 1501)])
def test_lensfun_distorts_alike(name: str, c: dict[str, float], size: tuple[int, int]) -> None:
    """The real LensFun 0.3.4.

    It takes half of the shorter side less one pixel for R, which is 0.08 px here, and rounds
    ptlens and poly3 to 0.5 px at the corner by approximate square roots.
    """
    terms = f'model="{name}" ' + " ".join(f'{key}="{value}"' for key, value in c.items())
    database = lensfunpy.Database(
        xml=LENSFUN.format(terms=terms), load_common=False, load_bundled=False
    )
    camera = database.find_cameras("K", "K1")[0]
    modifier = lensfunpy.Modifier(database.find_lenses(camera)[0], 1.5, *size)
    modifier.initialize(18.0, 8.0, 10.0, 1.0, flags=lensfunpy.ModifyFlags.DISTORTION)
    theirs = np.asarray(modifier.apply_geometry_distortion(), dtype=np.float64)
    lens = Lens(get_model(name), Frame(*size), {**c, "d": 0.0, "e": 0.0})
    x, y = np.meshgrid(np.arange(0, size[0], 50.0), np.arange(0, size[1], 50.0))
    ours = lens.distort(np.stack((x, y), axis=-1))
    bend = np.max(np.abs(ours - np.stack((x, y), axis=-1)))
    assert bend > 20
    assert np.max(np.abs(ours - theirs[::50, ::50])) < (0.1 if name == "poly5" else 0.7)

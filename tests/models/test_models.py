"""Every distortion model against an independent truth, its closed forms and its peers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import cv2
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import assume, example, given, settings, strategies as st

from plumbline.errors import FoldedError, OptionError, UnsupportedModelError
from plumbline.frame import Frame
from plumbline.geometry.lens import Lens
from plumbline.models import CENTRE, MODELS, Model, get_model
from plumbline.models.inverse import REACH, first_fold, invert
from tests import truth
from tests.truth import TrueLens

Array = truth.Array

NAMES = (*MODELS, "radial:1,2,3", "radial:2,4")
FOCAL_PX = 2100.0

every_model = pytest.mark.parametrize("name", NAMES)


def moderate(name: str, shares: list[float], corner: float, most: float = 0.3) -> dict[str, float]:
    """Coefficients whose terms bend the corner by at most that share of its radius in all."""
    terms = truth.powers(name)
    return {
        key: most * share / len(terms) / (corner**power if power else 8 * corner)
        for (key, power), share in zip(terms.items(), shares, strict=False)
    }


def some_coefficients(name: str, seed: int, corner: float = 1.8) -> dict[str, float]:
    rng = np.random.default_rng(seed)
    return moderate(name, rng.uniform(-1, 1, 12).tolist(), corner, most=0.15)


def vector(model: Model, c: Mapping[str, float]) -> Array:
    return np.array([c[name] for name in model.coefficients])


def some_points(n: int = 60, most: float = 1.25) -> Array:
    rng = np.random.default_rng(5)
    points = rng.uniform(-most, most, (n, 2))
    points[:3] = [[0.0, 0.0], [1e-9, -2e-9], [0.0, 0.7]]
    return points


def applied(model: Model, points: Array, c: Any) -> Array:
    return np.stack(model.apply(points[..., 0], points[..., 1], c), axis=-1)


@every_model
def test_coefficients_are_named_and_ordered_as_the_equation_has_them(name: str) -> None:
    model = get_model(name)
    assert model.coefficients == tuple(truth.powers(name))
    assert model.tangential == truth.TANGENTIAL.get(name, ())
    assert model.direction == (
        "ideal to observed" if name in truth.IDEAL_TO_OBSERVED else "observed to ideal"
    )
    assert (model.unit == "focal length") == (name in truth.IN_FOCAL_LENGTHS)
    assert get_model(model.label) == model


@every_model
@pytest.mark.parametrize("seed", range(5))
def test_own_direction_agrees_with_the_truth(name: str, seed: int) -> None:
    model, c, points = get_model(name), some_coefficients(name, seed), some_points()
    np.testing.assert_allclose(
        applied(model, points, vector(model, c)),
        truth.forward(name, c, points),
        rtol=1e-12,
        atol=1e-12,
    )


@every_model
@pytest.mark.parametrize("seed", range(3))
def test_inverse_agrees_with_bisection(name: str, seed: int) -> None:
    model, c = get_model(name), some_coefficients(name, seed)
    images = truth.forward(name, c, some_points())
    solved = invert(model, vector(model, c), images, REACH * 1.8)
    np.testing.assert_allclose(solved, truth.backward(name, c, images), rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(solved, some_points(), rtol=1e-12, atol=1e-12)


@every_model
def test_slope_is_the_derivative_of_the_radius(name: str) -> None:
    model, r, step = get_model(name), np.linspace(0.0, 1.7, 35), 1e-30
    for seed in range(4):
        c = vector(model, some_coefficients(name, seed))
        turned = r + step * 1j
        by_complex_step = (turned * model.factor(turned, c)).imag / step
        np.testing.assert_allclose(model.slope(r, c), by_complex_step, rtol=1e-13, atol=1e-13)


@every_model
def test_jacobian_is_the_derivative_of_the_point(name: str) -> None:
    model, c, h = get_model(name), some_coefficients(name, 1), 1e-3
    points = some_points()[2:]
    kernel = np.array([1.0, -8.0, 8.0, -1.0]) / 12  # fourth order
    xx, xy, yx, yy = model.jacobian(points[:, 0], points[:, 1], vector(model, c))
    for axis, (dx, dy) in enumerate(((xx, yx), (xy, yy))):
        moves = np.zeros((4, 2))
        moves[:, axis] = np.array([-2.0, -1.0, 1.0, 2.0]) * h
        images = [truth.forward(name, c, points + move) for move in moves]
        derivative = np.tensordot(kernel, np.array(images), axes=1) / h
        np.testing.assert_allclose(np.stack((dx, dy), -1), derivative, rtol=0, atol=1e-10)


@every_model
def test_jacobian_at_the_centre_is_the_central_scale(name: str) -> None:
    model, c = get_model(name), some_coefficients(name, 2)
    here = np.zeros(1)
    xx, xy, yx, yy = (float(v[0]) for v in model.jacobian(here, here, vector(model, c)))
    central = float(truth.scale(name, c, 0.0))
    assert (xx, xy, yx, yy) == pytest.approx((central, 0, 0, central), abs=1e-15)


@every_model
@given(shares=st.lists(st.floats(-1, 1), min_size=12, max_size=12))
def test_scale_is_one_at_the_gauge(name: str, shares: list[float]) -> None:
    model = get_model(name)
    assert model.gauge == (1 if name in truth.TRUE_AT_ONE else 0)
    c = vector(model, moderate(name, shares, 1.0))
    assert float(model.factor(np.float64(model.gauge), c)) == pytest.approx(1.0, abs=1e-15)


@every_model
def test_zero_coefficients_change_nothing(name: str) -> None:
    model = get_model(name)
    nothing = np.zeros(len(model.coefficients))
    points = some_points()
    np.testing.assert_array_equal(applied(model, points, nothing), points)
    np.testing.assert_allclose(invert(model, nothing, points, 20.0), points, rtol=1e-15, atol=0)
    assert first_fold(model, nothing, 20.0) is None


@every_model
def test_jax_and_numpy_give_the_same_numbers(name: str) -> None:
    model, c = get_model(name), vector(get_model(name), some_coefficients(name, 3))
    x, y = some_points().T
    with jax.enable_x64(True):
        jx, jy, jc = (jnp.asarray(values) for values in (x, y, c))
        pairs = zip(
            (*model.apply(x, y, c), *model.jacobian(x, y, c)),
            (*model.apply(jx, jy, jc), *model.jacobian(jx, jy, jc)),
            strict=True,
        )
        for by_numpy, by_jax in pairs:
            assert by_jax.dtype == np.float64
            np.testing.assert_allclose(by_numpy, np.asarray(by_jax), rtol=2e-15, atol=2e-15)


SIZES = [(3000, 2250), (2250, 3000), (1920, 1080), (641, 641)]


@every_model
@settings(max_examples=40)
@given(
    shares=st.lists(st.floats(-1, 1), min_size=12, max_size=12),
    size=st.sampled_from(SIZES),
    off_centre=st.tuples(st.floats(-0.03, 0.03), st.floats(-0.03, 0.03)),
    places=st.lists(st.tuples(st.floats(0, 1), st.floats(0, 1)), min_size=1, max_size=8),
    near=st.floats(1e-12, 1e-3),
)
@example([-1.0] * 12, SIZES[0], (0.03, -0.03), [(0.0, 0.0), (1.0, 1.0)], 1e-12)
@example([1.0] * 12, SIZES[1], (0.0, 0.0), [(1.0, 0.0), (0.5, 0.5)], 1e-9)
@example([0.0] * 12, SIZES[2], (0.01, 0.0), [(0.0, 1.0)], 1e-5)
def test_a_lens_maps_there_and_back(
    name: str,
    shares: list[float],
    size: tuple[int, int],
    off_centre: tuple[float, float],
    places: list[tuple[float, float]],
    near: float,
) -> None:
    model, frame = get_model(name), Frame(*size)
    corner = frame.corner_radius * 1.06
    c = moderate(name, shares, 1.4 if name in truth.IN_FOCAL_LENGTHS else corner, most=0.25)
    centre = {"d": off_centre[0] * size[0], "e": off_centre[1] * size[1]}
    focal = frame.corner_radius * frame.radius_px
    lens = Lens(model, frame, c | centre, focal_px=focal)
    true = TrueLens(name, c | centre, size, focal_px=focal)
    assume(truth.monotonic_to(name, c) > 1.8 * corner)
    observed = np.array(places) * (np.array(size) - 1)
    middle = np.array(lens.centre_px)
    close = middle + near * np.array([[1.0, 0.0], [0.0, -1.0], [0.6, 0.8]])
    observed = np.vstack((observed, middle, close))
    ideal = lens.undistort(observed)
    np.testing.assert_allclose(ideal, true.undistort(observed), rtol=0, atol=1e-8)
    np.testing.assert_allclose(lens.distort(ideal), observed, rtol=0, atol=1e-9)
    np.testing.assert_allclose(lens.undistort(lens.distort(observed)), observed, rtol=0, atol=1e-9)


# Closed forms


@pytest.mark.parametrize("l1", [-0.25, -0.01, 0.02, 0.4])
def test_division_distorts_by_the_quadratic_formula(l1: float) -> None:
    ideal = np.linspace(0.01, 1.5, 40)
    within = 1 - 4 * l1 * ideal**2
    observed = 2 * ideal / (1 + np.sqrt(np.maximum(within, 0.0)))
    reachable = within > 0
    points = np.stack((0.6 * ideal, -0.8 * ideal), axis=-1)
    with np.errstate(all="ignore"):
        solved = invert(MODELS["division"], np.array([l1, 0.0]), points, 20.0)
    np.testing.assert_allclose(
        np.hypot(*solved[reachable].T), observed[reachable], rtol=1e-12, atol=0
    )
    assert np.all(np.isnan(solved[~reachable]))


@pytest.mark.parametrize("k1", [-0.12, -0.02, 1e-6, 0.05, 0.3])
def test_poly3_undistorts_by_the_cubic_formula(k1: float) -> None:
    observed = np.linspace(0.05, 1.2, 24)
    points = np.stack((observed, np.zeros_like(observed)), axis=-1)
    solved = invert(MODELS["poly3"], np.array([k1]), points, 15.0)[:, 0]
    for out, inner in zip(observed, solved, strict=True):
        roots = np.roots([k1, 0.0, 1 - k1, -out])
        real = [root.real for root in roots.tolist() if abs(root.imag) < 1e-9 and root.real > 0]
        assert inner == pytest.approx(min(real), rel=1e-9)


def test_poly3_is_ptlens_with_b_alone() -> None:
    points = some_points()
    for b in (-0.1, 0.004, 0.2):
        np.testing.assert_allclose(
            applied(MODELS["poly3"], points, [b]),
            applied(MODELS["ptlens"], points, [0.0, b, 0.0]),
            rtol=1e-14,
        )


def test_even_powers_are_brown_without_tangential_terms() -> None:
    points, k = some_points(), [-0.1, 0.02, -0.001]
    np.testing.assert_allclose(
        applied(get_model("radial:2,4,6"), points, k),
        applied(MODELS["brown"], points, [*k, 0.0, 0.0]),
        rtol=1e-14,
    )
    assert get_model("radial") == get_model("radial:2,4,6")


def test_opencv_is_poly5_in_focal_lengths() -> None:
    frame, k1, k2 = Frame(3000, 2250), -0.08, 0.011
    ratio = frame.radius_px / FOCAL_PX
    centre = dict.fromkeys(CENTRE, 0.0)
    opencv = Lens(
        MODELS["opencv"],
        frame,
        {"k1": k1, "k2": k2, "p1": 0.0, "p2": 0.0, "k3": 0.0, **centre},
        focal_px=FOCAL_PX,
    )
    poly5 = Lens(MODELS["poly5"], frame, {"k1": k1 * ratio**2, "k2": k2 * ratio**4, **centre})
    points = truth.grid_px(frame.size)
    np.testing.assert_allclose(opencv.distort(points), poly5.distort(points), rtol=0, atol=1e-9)
    np.testing.assert_allclose(opencv.undistort(points), poly5.undistort(points), rtol=0, atol=1e-9)


def test_acm_is_opencv_in_another_order() -> None:
    points = some_points()
    np.testing.assert_array_equal(
        applied(MODELS["acm"], points, [-0.1, 0.03, 0.002, 0.004, -0.003]),
        applied(MODELS["opencv"], points, [-0.1, 0.03, 0.004, -0.003, 0.002]),
    )


@pytest.mark.parametrize("seed", range(4))
def test_opencv_agrees_with_opencv(seed: int) -> None:
    c = vector(MODELS["opencv"], some_coefficients("opencv", seed))
    points = some_points(200, 1.2)
    solid = np.hstack((points, np.ones((len(points), 1))))
    nowhere = np.zeros(3)
    projected = np.asarray(cv2.projectPoints(solid, nowhere, nowhere, np.eye(3), c)[0])
    np.testing.assert_allclose(
        applied(MODELS["opencv"], points, c), projected.reshape(-1, 2), rtol=0, atol=1e-13
    )


def test_a_lens_agrees_with_opencv_in_pixels() -> None:
    """OpenCV counts from the centre of the top-left pixel too."""
    c = {"k1": -0.21, "k2": 0.05, "p1": 0.002, "p2": -0.001, "k3": 0.003, "d": 11.5, "e": -7.25}
    lens = Lens(MODELS["opencv"], Frame(1000, 700), c, focal_px=900.0)
    ideal = truth.grid_px((1000, 700))
    middle = np.array([499.5, 349.5])
    solid = np.hstack(((ideal - middle) / 900.0, np.ones((len(ideal), 1))))
    camera = np.array([[900.0, 0, 499.5 + 11.5], [0, 900.0, 349.5 - 7.25], [0, 0, 1]])
    nowhere, k = np.zeros(3), vector(MODELS["opencv"], c)
    projected = np.asarray(cv2.projectPoints(solid, nowhere, nowhere, camera, k)[0])
    np.testing.assert_allclose(lens.distort(ideal), projected.reshape(-1, 2), rtol=0, atol=1e-9)


# Folding


def test_ptlens_folds_where_its_derivative_vanishes() -> None:
    # b alone: 1 − b + 3 b r² = 0 at r = √((b − 1) / 3b).
    b = -0.2
    fold = np.sqrt((b - 1) / (3 * b))
    found = first_fold(MODELS["ptlens"], np.array([0.0, b, 0.0]), 16.0)
    assert found == pytest.approx(fold, abs=1e-12)
    farthest = fold * (1 - b + b * fold**2)
    beside = np.array([[farthest - 1e-6, 0.0], [farthest + 1e-6, 0.0]])
    solved = invert(MODELS["ptlens"], np.array([0.0, b, 0.0]), beside, 16.0)
    assert np.isfinite(solved[0]).all()
    assert np.isnan(solved[1]).all()


def test_the_first_of_two_folds_counts() -> None:
    # slope = (1 − r²)(1 − r²/4) = 1 − 1.25 r² + 0.25 r⁴: folds at 1 and at 2.
    c = np.array([-1.25 / 3, 0.25 / 5])
    assert first_fold(MODELS["poly5"], c, 16.0) == pytest.approx(1.0, abs=1e-12)


def test_no_fold_where_the_radius_only_rises() -> None:
    assert first_fold(MODELS["poly5"], np.array([0.1, 0.01]), 16.0) is None


def test_a_lens_refuses_points_beyond_the_fold() -> None:
    frame = Frame(3000, 2250)
    zero = {"a": 0.0, "c": 0.0, "d": 0.0, "e": 0.0}
    lens = Lens(MODELS["ptlens"], frame, {**zero, "b": -0.2})
    b = -0.2
    fold = np.sqrt((b - 1) / (3 * b))
    farthest_px = float(fold * (1 - b + b * fold**2)) * 1125
    assert lens.fold_radius_px() == pytest.approx(farthest_px, abs=1e-6)
    middle = np.array(lens.centre_px)
    lens.undistort(middle + np.array([farthest_px - 0.01, 0.0]))
    with pytest.raises(FoldedError, match="1 of the 1 points"):
        lens.undistort(middle + np.array([farthest_px + 0.01, 0.0]))
    with pytest.raises(FoldedError, match="2 of the 3 points"):
        lens.undistort(middle + np.array([[0, 0], [farthest_px + 1, 0], [0, farthest_px + 1]]))


def test_a_lens_that_folds_outside_the_photo_does_not_fold() -> None:
    lens = Lens(MODELS["poly3"], Frame(3000, 2250), {"k1": -0.02, "d": 0.0, "e": 0.0})
    assert lens.fold_radius_px() is None


def test_the_pole_of_the_division_model_is_a_fold() -> None:
    # 1 + l1 r² = 0 at r = 1 / √−l1; no ideal point corresponds to anything beyond.
    for l1 in (-0.5, -1.0):
        pole = 1 / np.sqrt(-l1)
        found = first_fold(MODELS["division"], np.array([l1, 0.0]), 16.0)
        assert found == pytest.approx(pole, abs=1e-9)
    far = invert(MODELS["division"], np.array([-1.0, 0.0]), np.array([[1e6, 0.0]]), 16.0)
    # The pole maps the unit disc onto the whole plane: r/(1−r²) = 1e6 just inside it.
    assert float(far[0, 0]) == pytest.approx(1 - 0.5e-6, abs=1e-11)


@pytest.mark.parametrize("name", ["radial:2,4", "brown", "division"])
def test_undistorting_beyond_the_fold_is_refused_in_either_direction(name: str) -> None:
    """Beyond the fold one ideal point has two observed ones: nothing to be trusted."""
    model, frame = get_model(name), Frame(3000, 2250)
    c = dict.fromkeys((*model.coefficients, *CENTRE), 0.0)
    first = model.coefficients[0]
    c[first] = -0.5 if name == "division" else -0.2  # folds at √2 or √(1/0.6), corner at 1.67
    lens = Lens(model, frame, c)
    fold_px = 1125 * (np.sqrt(2) if name == "division" else np.sqrt(1 / 0.6))
    assert lens.fold_radius_px() == pytest.approx(fold_px, abs=1e-6)
    middle = np.array(lens.centre_px)
    lens.undistort(middle + np.array([fold_px - 1, 0.0]))
    with pytest.raises(FoldedError):
        lens.undistort(middle + np.array([fold_px + 1, 0.0]))


def test_coefficients_beyond_reason_do_not_hang() -> None:
    for name in NAMES:
        model = get_model(name)
        for size in (-1e4, 1e4):
            c = np.full(len(model.coefficients), size)
            with np.errstate(all="ignore"):
                solved = invert(model, c, some_points(), 14.0)
            back = applied(model, solved, c)
            found = np.isfinite(solved[:, 0])
            np.testing.assert_allclose(back[found], some_points()[found], rtol=0, atol=1e-6)


# Names


@pytest.mark.parametrize(
    "name",
    ["", "nonsense", "ptlens:1", "radial:", "radial:0", "radial:2,2", "radial:1.5", "radial:x",
     "radial:13", "radial:-1", "PTLENS"],
)  # fmt: skip
def test_unknown_models_are_refused_with_a_remedy(name: str) -> None:
    with pytest.raises(UnsupportedModelError) as caught:
        get_model(name)
    assert caught.value.hint
    assert isinstance(caught.value, OptionError)
    assert isinstance(caught.value, ValueError)


def test_powers_are_sorted() -> None:
    assert get_model("radial:4,1,2").coefficients == ("a1", "a2", "a4")
    assert get_model("radial:4,1,2") == get_model("radial:1,2,4")
    assert get_model("radial:12").label == "radial:12"


def test_rows_are_named_after_their_models() -> None:
    assert all(name == model.name for name, model in MODELS.items())
    assert all(model.formula and model.use for model in MODELS.values())
    assert len(set(MODELS.values())) == len(MODELS)


@every_model
def test_each_radial_coefficient_goes_with_its_power(name: str) -> None:
    """Its term in r f(r) grows with r^(n + 1), seen at the truth's own scale."""
    model = get_model(name)
    assert model.powers == tuple(p for p in truth.powers(name).values() if p)
    assert model.radial == tuple(c for c, p in truth.powers(name).items() if p)
    assert len(model.powers) == len(model.radial)
    assert not set(model.next_powers) & set(model.powers)
    for coefficient, power in zip(model.radial, model.powers, strict=True):
        zero = dict.fromkeys(truth.powers(name), 0.0)
        r = np.array([0.0, 0.5, 1.0])
        tiny = truth.scale(name, zero | {coefficient: 1e-6}, r) - truth.scale(name, zero, r)
        tiny = (tiny - tiny[0]) / 1e-6
        assert tiny[1] / tiny[2] == pytest.approx(0.5**power, rel=1e-4)


def test_what_a_richer_model_has_besides() -> None:
    ptlens, brown = get_model("ptlens"), get_model("brown")
    assert ptlens.richer(("b",)) == (3, 1)
    assert ptlens.richer(("a", "b", "c", "d")) == (4,)
    assert brown.richer(("k1", "p1", "p2")) == (4, 6)
    assert brown.richer(("k1", "k2", "k3")) == (8,)
    assert get_model("poly3").richer(("k1",)) == (1, 3)
    assert get_model("radial:2,4").richer(("a2", "a4")) == (6,)
    assert get_model("radial:1,2,3").richer(("a1", "a2", "a3")) == (4,)


@every_model
def test_a_model_maps_both_ways_and_loses_what_lies_beyond_the_fold(name: str) -> None:
    model, reach = get_model(name), 4.0
    for seed in range(4):
        c = moderate(name, np.random.default_rng(seed).uniform(-1, 1, 12).tolist(), 1.0, most=1.2)
        values, points = vector(model, c), some_points()
        forward, backward = model.distort, model.undistort
        if name not in truth.IDEAL_TO_OBSERVED:
            forward, backward = backward, forward
        fold = truth.monotonic_to(name, c, reach)
        beyond = np.hypot(*points.T) > fold
        near = np.abs(np.hypot(*points.T) - fold) < 1e-3
        there = forward(points, values, reach)
        np.testing.assert_array_equal(np.isnan(there[~near, 0]), beyond[~near])
        np.testing.assert_allclose(
            there[~beyond & ~near], truth.forward(name, c, points)[~beyond & ~near], rtol=1e-13
        )
        if name not in truth.TANGENTIAL:
            back = backward(there[~beyond & ~near], values, reach)
            np.testing.assert_allclose(back, points[~beyond & ~near], atol=1e-9)


def test_fits_that_are_the_same_in_other_words_have_the_same_curve() -> None:
    """Told by the models, checked by the independent truth: one curve, whatever the scale."""
    r, told = np.linspace(0.05, 1.3, 40), 0
    for name, model in MODELS.items():
        for n in range(1, len(model.coefficients) + 1):
            free = model.coefficients[:n]
            for other in model.in_other_words(free):
                theirs, _, names = other.partition(" ")
                theirs_free = tuple(names.split(", ")) if names else tuple(truth.powers(theirs))
                assert len(theirs_free) == len(free)
                values = np.linspace(-0.04, 0.03, n)
                mine = dict.fromkeys(model.coefficients, 0.0) | dict(zip(free, values, strict=True))
                zero = dict.fromkeys(truth.powers(theirs), 0.0)
                same = zero | dict(zip(theirs_free, values, strict=True))
                scales = truth.scale(name, mine, r), truth.scale(theirs, same, r)
                np.testing.assert_allclose(scales[0], scales[1], rtol=1e-14)
                told += 1
    assert told >= 6


def test_only_panorama_tools_and_its_special_case_have_a_b_c() -> None:
    told = {
        name: model.ptlens_values(dict.fromkeys(model.coefficients, 0.02))
        for name, model in MODELS.items()
    }
    assert told.pop("ptlens") == {"a": 0.02, "b": 0.02, "c": 0.02}
    assert told.pop("poly3") == {"a": 0.0, "b": 0.02, "c": 0.0}
    assert set(told.values()) == {None}


def test_every_model_with_tangential_terms_is_decentred_by_them() -> None:
    for name, model in MODELS.items():
        terms = truth.TANGENTIAL.get(name, ())
        assert not model.decentred(model.radial)
        assert all(model.decentred((*model.radial, term)) for term in terms)
        assert model.decentred(model.coefficients) == bool(terms)

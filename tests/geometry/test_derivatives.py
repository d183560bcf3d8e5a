"""Derivatives of ideal points against the independent truth, moved numerically."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from plumbline.frame import Frame
from plumbline.geometry.derivatives import by_coefficients, by_powers, undistorted
from plumbline.geometry.lens import Lens
from plumbline.models import CENTRE, get_model
from tests.models.test_models import NAMES, some_coefficients
from tests.truth import Array, TrueLens, backward, forward

SIZE, FOCAL_PX = (900, 600), 520.0
KERNEL = np.array([1.0, -8.0, 8.0, -1.0]) / 12
"""Fourth-order central differences at −2, −1, 1 and 2 steps."""

every_model = pytest.mark.parametrize("name", NAMES)
every_shape = pytest.mark.parametrize(
    ("aspect", "centre"), [(1.0, (0.0, 0.0)), (1.2, (13.5, -8.25))], ids=["square", "video"]
)


def true_lens(name: str, aspect: float, centre: tuple[float, float]) -> TrueLens:
    moved = dict(zip(CENTRE, centre, strict=True))
    c = {key: 0.6 * value for key, value in some_coefficients(name, 3).items()}
    return TrueLens(name, c | moved, SIZE, FOCAL_PX, aspect)


def lens_of(true: TrueLens) -> Lens:
    frame = Frame(*true.size, true.aspect)
    return Lens(get_model(true.name), frame, true.all_coefficients, true.focal_px)


def points() -> Array:
    return np.random.default_rng(8).uniform((0, 0), np.array(SIZE) - 1.0, (40, 2))


def differentiated(moved: Callable[[float], Array], step: float) -> Array:
    return np.tensordot(KERNEL / step, [moved(n * step) for n in (-2, -1, 1, 2)], axes=1)


@every_model
@every_shape
def test_points_and_their_stretch(name: str, aspect: float, centre: tuple[float, float]) -> None:
    true, observed = true_lens(name, aspect, centre), points()
    square = np.array([aspect, 1.0])
    found = undistorted(lens_of(true), observed)
    want = (true.undistort(observed) - (np.array(SIZE) - 1) / 2) * square
    np.testing.assert_allclose(found.uv, want, atol=1e-8)
    for axis in (0, 1):
        step = np.eye(2)[axis] / square
        slope = differentiated(lambda h, s=step: true.undistort(observed + h * s), 0.2) * square
        np.testing.assert_allclose(found.stretch[:, :, axis], slope, atol=1e-8)


@every_model
@every_shape
def test_motions_with_coefficients(name: str, aspect: float, centre: tuple[float, float]) -> None:
    true, observed = true_lens(name, aspect, centre), points()
    lens, square = lens_of(true), np.array([aspect, 1.0])
    names = (*lens.model.coefficients, *CENTRE)
    found = by_coefficients(lens, names, observed, undistorted(lens, observed))
    assert found.shape == (len(observed), 2, len(names))
    for column, key in enumerate(names):
        value = true.all_coefficients[key]

        def moved(h: float, key: str = key, value: float = value) -> Array:
            other = replace(true, coefficients={**true.all_coefficients, key: value + h})
            # The corrected photo stays on the distortion centre.
            return other.undistort(observed)

        slope = differentiated(moved, 0.2 if key in CENTRE else 1e-5) * square
        scale = np.max(np.abs(slope))
        np.testing.assert_allclose(found[:, :, column], slope, atol=1e-7 * scale, err_msg=key)


@pytest.mark.parametrize("name", ["ptlens", "poly3", "poly5", "opencv", "acm", "radial", "brown"])
def test_motions_with_powers_of_a_richer_model(name: str) -> None:
    """A term h r^n is added to the independent polynomial, for the powers that it has as well."""
    true, observed = true_lens(name, 1.0, (0.0, 0.0)), points()
    lens, unit = lens_of(true), true.unit_px
    ideal = undistorted(lens, observed)
    middle = (np.array(SIZE) - 1) / 2

    def moved(h: float, power: int) -> Array:
        c, p = true.all_coefficients, (observed - middle) / unit
        own_way = lens.model.direction == "observed to ideal"
        if own_way:
            return (forward(name, c, p) + h * p * np.hypot(*p.T)[:, None] ** power) * unit
        # To first order the term is taken from the observed point before it is undistorted.
        q = backward(name, c, p)
        return backward(name, c, p - h * q * np.hypot(*q.T)[:, None] ** power) * unit

    for column, power in enumerate((1, 4, 7)):
        slope = differentiated(lambda h, power=power: moved(h, power), 1e-5)
        found = by_powers(lens, (1, 4, 7), observed, ideal)[:, :, column]
        np.testing.assert_allclose(found, slope, atol=1e-7 * np.max(np.abs(slope)))


@pytest.mark.parametrize(
    ("name", "c"),
    [("ptlens", {"a": 0.0, "b": -0.35, "c": 0.0}), ("radial:2,4", {"a2": -0.4, "a4": 0.0})],
)
def test_points_beyond_the_fold_are_nan_and_the_others_are_not(
    name: str, c: dict[str, float]
) -> None:
    lens = lens_of(TrueLens(name, c, SIZE))
    middle = (np.array(SIZE) - 1) / 2
    observed = np.array([middle, middle + np.array([100.0, 50.0]), [0.0, 0.0]])
    ideal = undistorted(lens, observed)
    assert np.isfinite(ideal.uv[:2]).all()
    assert np.isnan(ideal.uv[2]).all()
    moved = by_coefficients(lens, lens.model.coefficients, observed, ideal)
    assert np.isfinite(moved[:2]).all()


@every_model
def test_the_centre_itself_is_a_point_like_others(name: str) -> None:
    lens = lens_of(true_lens(name, 1.0, (0.0, 0.0)))
    middle = (np.array([SIZE]) - 1) / 2
    ideal = undistorted(lens, middle)
    scale = float(lens.model.factor(np.float64(0.0), lens.vector))
    scale = scale if lens.model.direction == "observed to ideal" else 1 / scale
    np.testing.assert_allclose(ideal.uv, 0.0, atol=1e-12)
    np.testing.assert_allclose(ideal.stretch[0], scale * np.eye(2), atol=1e-12)
    moved = by_coefficients(lens, lens.model.coefficients, middle, ideal)
    np.testing.assert_allclose(moved, 0.0, atol=1e-9)
    assert np.isfinite(by_powers(lens, (1, 2, 8), middle, ideal)).all()

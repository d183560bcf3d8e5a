"""Residuals, derivatives and leverage of a fit against numerical ones and against refits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from plumbline import calibrate
from plumbline.frame import Frame
from plumbline.geometry.lens import Lens
from plumbline.models import CENTRE, get_model
from plumbline.observations import Line, Observations, Photo
from plumbline.result.calibration import Calibration
from plumbline.trust.assessment import ResidualKind
from plumbline.trust.linearised import Linearised, in_frame, linearise
from tests import truth
from tests.fit.test_calibrate import LENSES, MILD, picked
from tests.many import all_calibrated
from tests.truth import Array, TrueLens

BARREL = {"a": 0.02, "b": -0.09, "c": -0.02}


def at(true: TrueLens, lines: list[Array], free: tuple[str, ...], *, image: bool) -> Linearised:
    frame = Frame(*true.size, true.aspect)
    lens = Lens(get_model(true.name), frame, true.all_coefficients, true.focal_px)
    kept = np.ones(sum(map(len, lines)), dtype=np.bool_)
    return linearise(lens, lines, free, kept, image=image)


def without_pick(made: Calibration, line: int, pick: int) -> Calibration:
    lines = list(made.observations.lines)
    points = np.delete(lines[line].points_px, pick, axis=0)
    lines[line] = replace(lines[line], points_px=points)
    return calibrate(replace(made.observations, lines=tuple(lines)), made.model, free=made.free)


def away_px(lens: TrueLens, point: Array, others: Array) -> float:
    """How far a pick lies from the line through others, in the photograph, without sign."""
    ideal = lens.undistort(others)
    middle = ideal.mean(axis=0)
    normal = np.linalg.svd(ideal - middle)[2][1]

    def distance(by: tuple[float, float]) -> float:
        return float((lens.undistort(point + np.array(by)) - middle) @ normal)

    h = 0.05
    dx = (distance((h, 0.0)) - distance((-h, 0.0))) / (2 * h)
    dy = (distance((0.0, h)) - distance((0.0, -h))) / (2 * h)
    return abs(distance((0.0, 0.0))) / float(np.hypot(dx, dy))


@pytest.mark.parametrize("aspect", [1.0, 1.2])
@pytest.mark.parametrize("image", [True, False], ids=["image", "corrected"])
def test_residuals_are_the_independent_ones(image: bool, aspect: float) -> None:
    true = TrueLens("ptlens", {**BARREL, "d": 12.0, "e": -7.0}, aspect=aspect)
    lines = true.lines(noise_px=0.5)
    found = at(true, lines, ("a",), image=image)
    want = np.concatenate(truth.distances_px(true, lines, in_photo=image))
    np.testing.assert_allclose(np.abs(found.residual_px), np.abs(want), atol=1e-6)
    apart = np.concatenate(truth.distances_px(true, lines, in_photo=True))
    np.testing.assert_allclose(np.abs(found.image_px), np.abs(apart), atol=1e-6)


@pytest.mark.parametrize("kind", ["image", "corrected"])
def test_residuals_are_the_fits_own(kind: ResidualKind) -> None:
    made = calibrate(picked(TrueLens("ptlens", BARREL), noise_px=0.5), residual=kind)
    np.testing.assert_allclose(
        made.linearised.residual_px, np.concatenate(made.residuals_px), rtol=0, atol=1e-6
    )


@pytest.mark.parametrize(
    ("name", "c"), [(name, c) for name, c in LENSES[3:] if name not in truth.IN_FOCAL_LENGTHS]
)
def test_the_jacobian_is_the_numerical_one(name: str, c: dict[str, float]) -> None:
    """At picks without noise: residuals of 0 have no further derivatives.

    Models in focal lengths differ by their unit alone, see tests/test_ideal.py.
    """
    centre = {"d": 9.0, "e": -14.0}
    true = TrueLens(name, {**c, **centre}, aspect=1.1)
    lines = true.lines(8, 6)
    free = (*get_model(name).coefficients, *CENTRE)
    image = name != "brown"
    found = at(true, lines, free, image=image)

    def residual(values: dict[str, float]) -> Array:
        lens = replace(true, coefficients=values)
        return np.concatenate(truth.distances_px(lens, lines, in_photo=image))

    for column, key in enumerate(free):
        h = 0.5 if key in CENTRE else 1e-5
        value = true.all_coefficients[key]
        up, down = (residual({**true.all_coefficients, key: value + s}) for s in (h, -h))
        slope = (up - down) / (2 * h)
        # The sign of a normal is nobody's choice.
        same = np.sign(np.bincount(found.line, slope * found.jacobian[:, column]))[found.line]
        tolerance = 2e-4 * np.max(np.abs(slope))
        np.testing.assert_allclose(found.jacobian[:, column], same * slope, atol=tolerance)


def test_all_leverage_is_what_the_fit_uses_up() -> None:
    made = calibrate(picked(TrueLens("ptlens", MILD), noise_px=0.5), free="abcde")
    assert np.sum(1 - made.linearised.leverage) == pytest.approx(made.dof, rel=1e-9)


@pytest.mark.parametrize(("line", "pick"), [(0, 0), (0, 6), (7, 11), (15, 0), (3, 4)])
def test_leverage_tells_the_residual_without_a_pick(line: int, pick: int) -> None:
    """Left out, a pick lies r / (1 − h) from the line through the others under their lens."""
    true = TrueLens("ptlens", BARREL)
    made = calibrate(picked(true, noise_px=0.3, seed=3))
    linear, number = made.linearised, 12 * line + pick
    expected = abs(linear.residual_px[number]) / (1 - linear.leverage[number])
    refit = without_pick(made, line, pick)
    point, others = made.observations.lines[line].points_px[pick], refit.observations.lines[line]
    found = away_px(replace(true, coefficients=refit.coefficients), point, others.points_px)
    assert found == pytest.approx(expected, rel=0.02, abs=2e-3)
    # The same pick, linearised where it is left out, is studentised by √(1 + h) instead.
    kept = np.arange(192) != number
    apart = linearise(
        refit.lens,
        [each.points_px for each in made.observations.lines],
        made.free,
        kept,
        image=True,
    )
    assert abs(apart.residual_px[number]) == pytest.approx(found, rel=1e-5)
    h = linear.leverage[number]
    assert 1 + apart.leverage[number] == pytest.approx(1 / (1 - h), rel=0.03)
    inside, outside = linear.studentised(1.0)[number], apart.studentised(1.0)[number]
    assert abs(outside) == pytest.approx(abs(inside), rel=0.03, abs=2e-3)


def test_one_step_without_each_line_is_nearly_the_refit() -> None:
    made = calibrate(picked(TrueLens("ptlens", BARREL), noise_px=0.5, seed=2))
    shifts = made.linearised.without_each_line()
    assert shifts is not None
    lines = made.observations.lines
    refits = all_calibrated(
        [replace(made.observations, lines=(*lines[:i], *lines[i + 1 :])) for i in range(len(lines))]
    )
    real = np.array(
        [[each.coefficients[n] - made.coefficients[n] for n in "abc"] for each in refits]
    )
    np.testing.assert_allclose(shifts, real, atol=0.03 * np.max(np.abs(real)))
    # The picks of the line left out, from the line through them under the others' lens.
    missed = made.linearised.left_out_px(shifts)
    for number, refit in enumerate(refits):
        lens = TrueLens("ptlens", refit.coefficients)
        (want,) = truth.distances_px(lens, [lines[number].points_px], in_photo=True)
        found = np.abs(missed[12 * number : 12 * number + 12])
        np.testing.assert_allclose(found, np.abs(want), atol=0.02)


def test_there_is_no_step_without_a_line_that_is_needed() -> None:
    true = TrueLens("ptlens", MILD)
    every = true.lines(noise_px=0.3)
    assert at(true, every[:1], ("b",), image=True).without_each_line() is None
    middle = [1499.5, 1124.5] + np.linspace(-900, 900, 12)[:, None] * (0.6, 0.8)
    assert at(true, [every[0], middle], ("b",), image=True).without_each_line() is None
    assert at(true, every[:3], ("a", "b", "c"), image=True).without_each_line() is not None


FOLDING = Lens(
    get_model("ptlens"), Frame(3000, 2250), {"a": 0.0, "b": -0.2, "c": 0.0, "d": 0.0, "e": 0.0}
)
"""Folds 1,273 px from the centre: the corners, 1,875 px away, lie beyond."""


def test_picks_beyond_the_fold_are_infinitely_far_and_spoil_no_others() -> None:
    true = TrueLens("ptlens", {"a": 0.0, "b": -0.2, "c": 0.0})
    fold = FOLDING.fold_radius_px()
    assert fold == pytest.approx(1125 * np.sqrt(2) * 0.8, rel=1e-4)
    ideal = np.stack((np.linspace(300, 2700, 9), np.full(9, 500.0)), axis=1)
    good = [true.distort(ideal), true.distort(ideal[:, ::-1] + (0, -200))]
    lines = [np.concatenate((good[0], [[5.0, 5.0]])), good[1]]
    kept = np.ones(19, dtype=np.bool_)
    linear = linearise(FOLDING, lines, ("b",), kept, image=True)
    alone = linearise(FOLDING, good, ("b",), kept[:18], image=True)
    rest = np.arange(19) != 9
    assert np.isinf(linear.residual_px[9])
    assert np.isinf(linear.image_px[9])
    assert not linear.kept[9]
    for name in ("residual_px", "jacobian", "along_px", "stretch", "leverage"):
        np.testing.assert_allclose(getattr(linear, name)[rest], getattr(alone, name), atol=1e-9)
    assert np.isinf(linear.studentised(0.5)[9])


def test_a_line_left_out_as_a_whole_is_measured_by_itself() -> None:
    true = TrueLens("ptlens", BARREL)
    lines = true.lines(noise_px=0.5)
    kept = np.ones(192, dtype=np.bool_)
    kept[24:36] = False
    lens = Lens(get_model("ptlens"), Frame(*true.size), true.all_coefficients)
    linear = linearise(lens, lines, ("a", "b", "c"), kept, image=True)
    want = truth.distances_px(true, lines, in_photo=True)
    np.testing.assert_allclose(np.abs(linear.residual_px), np.abs(np.concatenate(want)), atol=1e-6)
    others = linearise(lens, [*lines[:2], *lines[3:]], ("a", "b", "c"), kept[kept], image=True)
    np.testing.assert_allclose(linear.normal, others.normal, rtol=1e-12)


def test_photos_turned_otherwise_share_the_centre() -> None:
    lying, standing = (
        np.array([[0.0, 0.0], [100.0, 40.0], [399.0, 299.0]]),
        np.array([[0.0, 0.0], [149.5, 199.5], [299.0, 399.0]]),
    )
    obs = Observations((Photo((400, 300)), Photo((300, 400))), (Line(lying, 0), Line(standing, 1)))
    first, second = in_frame(obs, obs.photos[0].frame)
    np.testing.assert_array_equal(first, lying)
    np.testing.assert_allclose(second, [[50.0, -50.0], [199.5, 149.5], [349.0, 349.0]])

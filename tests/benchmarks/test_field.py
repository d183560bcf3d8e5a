"""Field errors and the Cramér-Rao bound of the simulations, against closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.benchmarks.field import (
    GRID,
    bound,
    coefficients,
    field_px,
    leaves_perspective,
    names_of,
    undistorted,
)
from tests.benchmarks.groups import ALIKE, GRID as GRID_OF_LINES, lens
from tests.benchmarks.simulated import Group
from tests.truth import Array, TrueLens, distances_px, grid_px, unlike_px

OF_EACH_FAMILY = list({group.model: group for group in ALIKE[::-1]}.values())


@pytest.mark.parametrize("group", OF_EACH_FAMILY, ids=lambda group: group.model)
def test_many_lenses_undistort_as_each_does_alone(group: Group) -> None:
    first = group.lens.all_coefficients
    other = {name: 1.01 * value for name, value in first.items()} | {"d": 5.0, "e": -7.0}
    points = grid_px(group.lens.size, GRID)
    found = undistorted(group.lens, coefficients([first, other]), group.model, points)
    for each, ideal in zip((first, other), found, strict=True):
        alone = TrueLens(group.lens.name, each, group.lens.size).undistort(points)
        assert np.max(np.abs(ideal - alone)) < 1e-7


def test_a_lens_that_does_not_reach_a_point_says_so() -> None:
    true = lens("Mavic Pro")
    folds = {"a": 0.0, "b": -0.3, "c": 0.0, "d": 0.0, "e": 0.0}
    found = undistorted(true, coefficients([folds]), "ptlens", grid_px(true.size, GRID))[0]
    middle = GRID**2 // 2
    assert np.all(np.isnan(found[[0, GRID - 1, -1]]))
    assert np.all(np.isfinite(found[[middle, middle + 1]]))


@pytest.mark.parametrize("group", OF_EACH_FAMILY, ids=lambda group: group.model)
def test_the_field_is_what_straight_lines_can_tell_apart(group: Group) -> None:
    true, perspective = group.lens, leaves_perspective(group)
    other = replace(
        true, coefficients={name: 1.003 * v for name, v in true.all_coefficients.items()}
    )
    points = grid_px(true.size, GRID)
    want = unlike_px(true.undistort(points), other.undistort(points), perspective=perspective)
    found = field_px(
        true, coefficients([other.all_coefficients]), true.name, perspective=perspective
    )
    assert want > 0.05
    assert float(np.max(np.hypot(*found[0].T))) == pytest.approx(want, rel=2e-3)


def test_a_displaced_centre_alone_is_seen_and_a_mere_scale_is_not() -> None:
    plain = TrueLens("poly5", {"k1": 0.0, "k2": 0.0})
    moved = plain.all_coefficients | {"d": 40.0, "e": -30.0}
    assert np.max(np.abs(field_px(plain, coefficients([moved]), "poly5"))) < 1e-9
    # f(0) = 1 written as f(1) = 1: one lens but for a scale, of k r² with the radius unscaled.
    k = -0.05
    five = TrueLens("poly5", {"k1": k, "k2": 0.0})
    scale = scale_to_one(k)
    three = {"k1": k * scale**2 / (1 + k * scale**2), "d": 0.0, "e": 0.0}
    assert np.max(np.abs(field_px(five, coefficients([three]), "poly3"))) < 1e-8


def scale_to_one(k: float) -> float:
    """The s with s (1 + k s²) = 1, by bisection."""
    low, high = 0.0, 2.0
    for _ in range(200):
        s = (low + high) / 2
        low, high = (s, high) if s * (1 + k * s * s) < 1 else (low, s)
    return low


def test_the_bound_is_the_closed_form_of_one_small_coefficient() -> None:
    """Without distortion, k1 bends a line at distance h by k1 h x²: a parabola, less its line."""
    group = Group("none", TrueLens("poly3", {"k1": 0.0}), GRID_OF_LINES, 0.3, "poly3")
    radius, middle = group.lens.unit_px, (np.array(group.lens.size) - 1) / 2
    information = 0.0
    for line in group.lines:
        normal = line.along[::-1] * np.array([-1.0, 1.0])
        x = (line.ideal_px - middle) @ line.along / radius
        h = float((line.origin_px - middle) @ normal) / radius
        rest = x**2 - np.polyval(np.polyfit(x, x**2, 1), x)
        information += float(np.sum((h * rest * radius) ** 2)) / group.noise_px**2
    assert float(bound(group).covariance[0, 0]) == pytest.approx(1 / information, rel=1e-8)


@pytest.mark.parametrize("name", ["Sigma 14 mm, uneven", "E 10-18 off centre", "even powers"])
def test_the_bound_is_reached_by_the_residuals_of_straightened_lines(name: str) -> None:
    """By the other way round: points undistorted, a line fitted to them, distances in the photo."""
    group = next(g for g in ALIKE if g.name.startswith(name))
    lens, lines = group.lens, group.by_line(group.true_px)
    columns: list[Array] = []
    for coefficient in names_of(group):
        step = 0.1 if coefficient in ("d", "e") else 1e-4
        ends = [
            np.concatenate(
                distances_px(
                    replace(
                        lens,
                        coefficients=lens.all_coefficients
                        | {coefficient: lens.all_coefficients[coefficient] + sign * step},
                    ),
                    lines,
                    in_photo=True,
                )
            )
            for sign in (1, -1)
        ]
        columns.append((ends[0] - ends[1]) / (2 * step))
    jacobian = np.stack(columns, axis=-1)
    covariance = group.noise_px**2 * np.linalg.inv(jacobian.T @ jacobian)
    least = bound(group).covariance
    assert np.allclose(np.diag(covariance), np.diag(least), rtol=0.008)

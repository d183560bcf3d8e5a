"""Orthogonal least-squares lines against singular value decomposition."""

from __future__ import annotations

import numpy as np
import pytest

from plumbline.geometry.lines import fit_lines, line_numbers
from plumbline.observations import Observations
from plumbline.trust.straightness import straightness_before
from tests.truth import Array


def scattered(seed: int, n: int = 9) -> Array:
    rng = np.random.default_rng(seed)
    angle = rng.uniform(0, np.pi)
    along = rng.uniform(-300, 300, n)[:, None] * (np.cos(angle), np.sin(angle))
    return along + rng.normal(0, 5, (n, 2)) + (700, 400)


def test_lines_are_those_of_the_singular_value_decomposition() -> None:
    groups = [scattered(seed, 4 + seed % 5) for seed in range(30)]
    groups += [
        np.stack((np.arange(5.0), np.zeros(5)), 1),
        np.stack((np.ones(4), np.arange(4.0)), 1),
    ]
    points = np.concatenate(groups)
    line = line_numbers(np.array([len(group) for group in groups]))
    lines = fit_lines(points, np.bincount(line), np.ones(len(points)))
    along, across = lines.place(points, line)
    for number, group in enumerate(groups):
        centred = group - group.mean(axis=0)
        _, sizes, (direction, normal) = np.linalg.svd(centred)
        mine = line == number
        assert abs(direction @ lines.along[number]) == pytest.approx(1, abs=1e-12)
        assert lines.spread[number] == pytest.approx(sizes[0] ** 2, rel=1e-12)
        np.testing.assert_allclose(np.abs(along[mine]), np.abs(centred @ direction), atol=1e-9)
        np.testing.assert_allclose(np.abs(across[mine]), np.abs(centred @ normal), atol=1e-9)


def test_points_of_no_weight_are_measured_and_do_not_pull() -> None:
    good = scattered(1)
    points = np.concatenate((good, [[0.0, 900.0], [np.nan, np.nan]]))
    line, weight = np.zeros(11, dtype=np.int64), np.array([1.0] * 9 + [0.0, 0.0])
    lines = fit_lines(points, np.array([len(points)]), weight)
    alone = fit_lines(good, np.array([9]), np.ones(9))
    np.testing.assert_array_equal(lines.along, alone.along)
    np.testing.assert_array_equal(lines.centre, alone.centre)
    assert lines.count == 9
    centred = good - good.mean(axis=0)
    normal = np.linalg.svd(centred)[2][1]
    expected = abs((points[9] - good.mean(axis=0)) @ normal)
    _, across = lines.place(points, line)
    assert abs(across[9]) == pytest.approx(expected, rel=1e-9)
    assert np.isnan(across[10])


def test_lines_without_points_are_no_trouble() -> None:
    lines = fit_lines(scattered(2), np.array([3, 3, 3]), np.zeros(9))
    assert lines.count.tolist() == [0, 0, 0]
    assert np.isfinite(lines.along).all()
    assert lines.spread.tolist() == [0, 0, 0]


def test_straightness_before_counts_the_photographs_own_pixels() -> None:
    picks = [scattered(3), scattered(4)]
    obs = Observations.from_arrays(picks, (1400, 800), pixel_aspect=1.3)
    for found, points in zip(straightness_before(obs), picks, strict=True):
        square = points * (1.3, 1.0)
        centred = square - square.mean(axis=0)
        normal = np.linalg.svd(centred)[2][1]
        # Along its normal a pixel is hypot(1.3 nx, ny) high.
        expected = centred @ normal / np.hypot(*(normal * (1.3, 1.0)))
        np.testing.assert_allclose(np.abs(found), np.abs(expected), atol=1e-9)


def test_a_line_left_out_as_a_whole_is_measured_by_itself() -> None:
    picks = [scattered(5), scattered(6)]
    obs = Observations.from_arrays(picks, (1400, 800))
    kept = [np.ones(9, dtype=np.bool_), np.zeros(9, dtype=np.bool_)]
    for found, every in zip(straightness_before(obs, kept), straightness_before(obs), strict=True):
        np.testing.assert_array_equal(found, every)

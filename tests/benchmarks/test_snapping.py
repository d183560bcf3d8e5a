"""The benchmark of snapping runs, and its own measures are right."""

from __future__ import annotations

import numpy as np
import pytest

from tests.benchmarks.snapping import across, bend, row, shown, summed_up


def test_distances_are_those_from_the_true_edge() -> None:
    x = np.arange(0.0, 900, 2)
    points = np.stack((x, 50 + 1e-4 * (x - 450) ** 2), axis=-1)
    tangent = np.stack((np.ones_like(x), 2e-4 * (x - 450)), axis=-1)
    normal = np.stack((-tangent[:, 1], tangent[:, 0]), axis=-1)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    along, gap = across(points, (points + 0.25 * normal)[20:-20:7])
    np.testing.assert_allclose(gap, 0.25, atol=2e-3)
    assert np.all(np.diff(along) > 0)


def test_a_bend_is_told_from_a_shift_and_a_tilt() -> None:
    along = np.linspace(0, 1, 101)
    bent, shift, _ = bend(along, 3 + 2 * along + 0.4 * 4 * along * (1 - along))
    assert bent == pytest.approx(0.4 * 2 / 3, rel=0.03)  # from the best straight line
    assert shift == pytest.approx(4.3, abs=0.3)


def test_one_small_photograph() -> None:
    one = row(1, 1.5, (900, 600))
    assert one.refused <= 2
    assert one.bent == 0
    assert one.corner_px < 0.15 < one.corner_before_px
    assert str(one.lines) in shown(one)
    assert len(summed_up([one])) == 3

"""Quantiles of Student's t against SciPy's."""

from __future__ import annotations

import pytest
from scipy import stats

from plumbline.trust.student import quantile


@pytest.mark.parametrize("dof", [1, 2, 3, 4, 5, 9, 30, 63])
@pytest.mark.parametrize("probability", [0.6, 0.8413, 0.975, 0.9995, 1 - 1e-6])
def test_few_degrees_of_freedom_are_exact(probability: float, dof: int) -> None:
    assert quantile(probability, dof) == pytest.approx(stats.t.ppf(probability, dof), rel=1e-9)


@pytest.mark.parametrize("dof", [64, 65, 100, 1_000, 1_000_000])
@pytest.mark.parametrize("probability", [0.6, 0.975, 0.9995, 1 - 1e-6])
def test_many_degrees_of_freedom_are_good_to_a_millionth(probability: float, dof: int) -> None:
    assert quantile(probability, dof) == pytest.approx(stats.t.ppf(probability, dof), rel=1e-6)

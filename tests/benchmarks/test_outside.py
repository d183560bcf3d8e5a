"""A small run of the benchmark outside the family, and whether it notices too small a quote."""

from __future__ import annotations

import numpy as np
import pytest

from tests.benchmarks.groups import FACADE, GRID
from tests.benchmarks.outside import LENSES, Row, Stereographic, Trial, row


def test_the_stereographic_truth_maps_both_ways_by_its_equation() -> None:
    lens = Stereographic("ptlens", {"a": 0.0, "b": 0.0, "c": 0.0}, (3000, 2000))
    points = np.random.default_rng(1).uniform(0, 2000, (50, 2))
    np.testing.assert_allclose(lens.distort(lens.undistort(points)), points, atol=1e-9)
    middle = np.array([1499.5, 999.5])
    theta = 0.4
    ideal = middle + np.array([2000.0 * np.tan(theta), 0.0])
    observed = middle + np.array([4000.0 * np.tan(theta / 2), 0.0])
    np.testing.assert_allclose(lens.distort(ideal), observed, atol=1e-9)


@pytest.mark.parametrize("name", ["centre off by 1.5 %", "division", "stereographic"])
def test_the_quoted_error_holds_outside_the_family(name: str) -> None:
    """Of picks so good that what they do to the lens is small beside what the model misses."""
    found = row(name, GRID, 0.05, 3)
    assert not found.failures
    assert found.within == 1.0
    # The error that independent picks make would be too small a quote in the middle of the trials.
    assert np.median([trial.true_px / trial.own_px for trial in found.trials]) > 2.5


def test_in_the_family_little_is_added_but_what_the_centre_may_do() -> None:
    assert "in the family, mild" in LENSES
    found = row("in the family, mild", FACADE, 0.6, 3)
    assert not any(trial.told for trial in found.trials)
    assert found.within == 1.0


def test_a_failure_and_too_small_a_quote_count_against_a_group() -> None:
    good, bad = Trial(1.0, 1.0, 1.0, told=False), Trial(3.0, 1.0, 1.0, told=False)
    assert Row("", (good, bad), ("failed",)).within == pytest.approx(1 / 3)

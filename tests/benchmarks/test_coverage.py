"""A small run of the coverage benchmark, and whether it would notice wrong error bars."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import t as student

from tests.benchmarks.coverage import limit, row, summed_up, targets
from tests.benchmarks.groups import ALIKE, UNLIKE
from tests.benchmarks.simulated import Group
from tests.benchmarks.trials import fit_trials

TRIALS = 100
SMALL = [next(g for g in ALIKE if g.name.startswith(name)) for name in ("Sigma 14", "division")]


def test_the_limit_is_student_s_where_the_error_has_one_direction() -> None:
    for dof in (5, 40, 900):
        assert limit(1.0, dof) == pytest.approx(student.ppf(0.975, dof), rel=2e-3)


def test_the_limit_of_a_round_error_is_that_of_f() -> None:
    for dof in (5, 40, 900):  # P(F(2, dof) > 2 L²/2) = (1 + 2 L²/dof)^(-dof/2)
        length = np.sqrt((0.05 ** (-2 / dof) - 1) * dof / 2)
        assert limit(0.5, dof) == pytest.approx(length, rel=1e-9)


def test_the_limit_of_a_long_error_is_what_drawing_says() -> None:
    rng, dof, share, n = np.random.default_rng(4), 12, 0.8, 400_000
    z = rng.standard_normal((n, 2)) ** 2 @ np.array([share, 1 - share])
    length = np.sqrt(z / (rng.chisquare(dof, n) / dof))
    assert float(np.mean(length <= limit(share, dof))) == pytest.approx(0.95, abs=0.0015)


@pytest.mark.parametrize("group", SMALL, ids=lambda group: group.name)
def test_error_bars_are_true_within_the_chances_of_a_hundred_trials(group: Group) -> None:
    one = row(group, TRIALS)
    dof = group.n_points - 2 * len(group.lines) - 3
    chance = 4 * np.sqrt(0.95 * 0.05 / TRIALS)
    assert not one.failures
    assert one.coverage is not None
    assert one.field is not None
    assert abs(one.coverage - 0.95) < chance
    assert abs(one.band - 0.95) < chance
    assert abs(one.variance - 1) < 4 * np.sqrt(2 / dof / TRIALS)
    assert abs(one.field - 1) < 4 * np.sqrt(2 / TRIALS)


def test_error_bars_half_as_long_are_noticed() -> None:
    fitted = fit_trials(SMALL[0], SMALL[0].picks_px(TRIALS))
    short = [replace(fit, covariance=fit.covariance / 4) for fit in fitted.good]
    one = summed_up(SMALL[0], replace(fitted, good=tuple(short)))
    assert one.coverage is not None
    assert one.coverage < 0.8
    assert one.band < 0.8
    assert [met for what, _, met in targets([one]) if "coverage" in what] == [False] * 4


def test_a_failing_trial_is_kept_in_view_and_counts_as_a_miss() -> None:
    group = SMALL[0]
    picks = group.picks_px(20)
    wild = np.random.default_rng(1).uniform(0, 1, picks[3].shape)
    picks[3] = wild * (np.array(group.lens.size) - 1)
    fitted = fit_trials(group, picks)
    assert [number for number, _ in fitted.failures] == [3]
    assert fitted.numbers == (*range(3), *range(4, 20))
    one = summed_up(group, fitted)
    assert one.coverage is not None
    assert one.coverage <= 0.95
    assert one.band <= 0.95
    assert one.failures[0].startswith("trial 3: ")


def test_another_family_has_no_true_coefficients() -> None:
    one = row(UNLIKE[0], 10)
    assert one.coverage is None
    assert one.field is None
    assert one.field_px > 3 * one.claimed_px

"""The straightness alarm against what it is promised: rare by chance, loud where edges bend."""

from __future__ import annotations

import numpy as np

from plumbline import Observations, calibrate
from plumbline.trust.student import widening
from tests.benchmarks.groups import FACADE, GRID, lens
from tests.benchmarks.simulated import Group
from tests.benchmarks.spoiling import bent
from tests.many import all_calibrated

TRIALS = 40


def alarms(group: Group, picks_px: np.ndarray) -> float:
    some = [Observations.from_arrays(group.by_line(p), group.lens.size) for p in picks_px]
    every = [made.trust.steadiness for made in all_calibrated(some)]
    return float(np.mean([each.alarmed for each in every if each is not None]))


def test_straight_edges_hardly_ever_raise_the_alarm() -> None:
    """At most 5 %; four of forty would have a chance of 14 % at that rate."""
    for layout in (GRID, FACADE):
        group = Group("S120 5.2 mm", lens("S120 5.2 mm"), layout, 0.3)
        assert alarms(group, group.picks_px(TRIALS)) <= 4 / TRIALS


def test_bent_edges_raise_it() -> None:
    group = Group("S120 5.2 mm", lens("S120 5.2 mm"), GRID, 0.1)
    assert alarms(group, bent(group, group.picks_px(TRIALS))) > 0.3


def test_the_widening_is_the_ratio_of_student_s_to_the_normal_point() -> None:
    from scipy.stats import norm, t

    for dof in (1, 2, 5, 30):
        assert np.isclose(widening(dof), t.ppf(0.975, dof) / norm.ppf(0.975), rtol=1e-4)


def test_too_simple_a_model_blames_no_picks() -> None:
    """b alone on a strong lens: its corners are off, and no pick is wrong."""
    group = Group("S120 5.2 mm", lens("S120 5.2 mm", d=0.0), GRID, 0.2)
    (picks,) = group.picks_px(1)
    obs = Observations.from_arrays(group.by_line(picks), group.lens.size)
    made = calibrate(obs, free=("b",))
    assert not [each for each in made.suspects if each.left_out]
    assert all(check.passed for check in made.checks if check.name == "suspects")
    robust = calibrate(obs, free=("b",), robust=True)
    assert all(np.all(each) for each in robust.kept)

"""A small run of the benchmark of `compare`, and whether it would notice a bad choice."""

from __future__ import annotations

import numpy as np

import plumbline
from tests.benchmarks.choosing import (
    FAMILIES,
    LAYOUTS,
    Trial,
    cases,
    error_px,
    families_differ,
    own_px,
    range_px,
    share_right,
    share_right_alone,
    shown,
    trials,
)
from tests.benchmarks.groups import FACADE, NOISE_PX
from tests.benchmarks.simulated import Group
from tests.benchmarks.trials import observations

BARREL = Group("barrel", FAMILIES["ptlens a, b, c"][0], FACADE, 0.3)
WEAK = Group("weak", FAMILIES["ptlens b"][3], FACADE, 0.3)


def test_every_family_has_every_layout_and_noise() -> None:
    listed = [(family, group.name) for family, group in cases()]
    lenses = sum(len(each) for each in FAMILIES.values())
    assert len(listed) == len(set(listed)) == lenses * len(LAYOUTS) * len(NOISE_PX)


def test_a_good_choice_is_right_and_a_bad_one_is_noticed() -> None:
    (good,) = trials("ptlens a, b, c", BARREL, 1)
    assert good.right
    assert good.row == "ptlens a, b, c"
    made = plumbline.calibrate(observations(BARREL, BARREL.picks_px(1)[0]), free=("b",))
    assert error_px(BARREL, made) > 10
    made = plumbline.calibrate(observations(BARREL, BARREL.true_px))
    assert error_px(BARREL, made) < 1e-6
    assert own_px(BARREL, made) < 1e-6


def test_the_range_ends_where_the_picks_do() -> None:
    middle = (np.array(BARREL.lens.size) - 1) / 2
    reached = np.max(np.hypot(*(BARREL.true_px - middle).T))
    radii = np.hypot(*(range_px(BARREL) - middle).T)
    assert 0.9 * reached < np.max(radii) <= reached


def test_cases_where_models_do_not_differ_do_not_count() -> None:
    assert families_differ(BARREL)
    assert not families_differ(WEAK)
    assert trials("ptlens b", WEAK, 1) == []


def test_right_is_within_a_tenth_or_twice_what_is_stated() -> None:
    made = [
        Trial("f", "c", "ptlens b", 1, 0.09, 0.01),
        Trial("f", "c", "poly5", 2, 0.5, 0.26),
        Trial("f", "c", "poly5", 2, 0.5, 0.24, 0.26),
        Trial("f", "c", failure="no model can be fitted"),
    ]
    assert [each.right for each in made] == [True, True, False, False]
    assert share_right(made) == 0.5
    assert [each.right_alone for each in made] == [True, False, True, False]
    assert share_right_alone(made) == 0.5
    assert "50.0" in shown("f", made)
    assert "poly5 2, ptlens b 1, raised 1" in shown("f", made)

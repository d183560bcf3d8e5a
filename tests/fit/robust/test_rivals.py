"""Five picks a line and two in five of them strays: a fit that may be wrong says so everywhere."""

from __future__ import annotations

from functools import cache as remembered

import numpy as np
import pytest

from plumbline import Calibration, calibrate
from plumbline.result.files import consistent_results
from plumbline.result.sentence import finding_sentence
from plumbline.result.writing import to_json
from tests.benchmarks.groups import lens
from tests.benchmarks.simulated import Group, Layout
from tests.benchmarks.spoiling import moved
from tests.benchmarks.trials import observations
from tests.truth import unlike_px

GROUP = Group("Mavic Pro", lens("Mavic Pro"), Layout("five a line", 12, 5, 5), 0.5)
TRIALS = 10


@remembered
def spoiled(share: float, *, robust: bool) -> tuple[Calibration, ...]:
    drawn = [
        moved(GROUP, points, share, GROUP.rng("strays", trial)).points_px
        for trial, points in enumerate(GROUP.picks_px(TRIALS))
    ]
    return tuple(calibrate(observations(GROUP, points), robust=robust) for points in drawn)


def error_px(made: Calibration) -> float:
    points = made.trust.range_px
    return unlike_px(made.lens.undistort(points), GROUP.lens.undistort(points))


def test_no_wrong_lens_is_trusted_in_silence() -> None:
    wrong = 0
    for made in spoiled(0.4, robust=True):
        assert made.quoted is not None
        if error_px(made) > 2 * made.quoted.worst_px:
            wrong += 1
            assert made.doubt
            assert any(check.name == "agreement" for check in made.checks)
    assert wrong >= 2  # else these picks are not spoiled enough to test anything


def test_where_enough_agrees_nothing_is_doubted() -> None:
    for made in spoiled(0.1, robust=True):
        assert made.rival_px is None
        assert "cannot be told" not in made.doubt


@pytest.mark.parametrize("robust", [True, False])
def test_the_doubt_is_one_in_every_place_and_is_kept(robust: bool) -> None:
    doubted = [made for made in spoiled(0.4, robust=robust) if made.rival_px is not None]
    assert doubted
    made = doubted[0]
    assert "cannot be told" in made.doubt
    assert made.doubt in finding_sentence(made)
    assert any("cannot be told" in note for note in made.notes)
    (again,) = consistent_results(to_json([made]), "x.json")
    assert again.rival_px == made.rival_px
    assert again.doubt == made.doubt
    assert np.all(again.covariance == made.covariance)

"""A small run of the benchmark of clean picks, and whether it notices accusations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from plumbline import Observations, calibrate
from tests.benchmarks.clean_picks import CASES, Case, Row, row
from tests.benchmarks.trials import observations

ROW = Row("", 100, (), 2, (1.0,), 1.0)


def test_the_cases_span_what_is_asked_for() -> None:
    assert {case.a_line for case in CASES} >= {5, 12, 60, 300}
    assert {case.aspect for case in CASES} >= {0.5, 1.0, 2.0}
    assert max(case.share for case in CASES) == 1 / 200
    assert min(case.size for case in CASES) == (320, 240)
    assert any(case.whole for case in CASES)


@pytest.mark.parametrize("aspect", [0.5, 2.0])
def test_clean_picks_of_pixels_that_are_not_square_are_not_accused(aspect: float) -> None:
    case = Case(12, (640, 480), 1 / 600, aspect)
    assert row(case, 4).met
    # Taken for square, the same picks scatter twice as much along one axis as along the other.
    points = case.group.picks_px(1)[0] * np.array([aspect, 1.0])
    size = round(640 * aspect), 480
    square = calibrate(Observations.from_arrays(case.group.by_line(points), size))
    own = calibrate(observations(case.group, case.group.picks_px(1)[0]))
    assert own.sigma_px == pytest.approx(case.noise_px, rel=0.15)
    assert square.sigma_px != pytest.approx(case.noise_px, rel=0.15)


def test_an_accusation_a_failure_and_a_sigma_too_small_count() -> None:
    assert ROW.met
    assert not replace(ROW, accused=3).met
    assert not replace(ROW, failures=("no",)).met
    assert not replace(ROW, pooled=0.96).met

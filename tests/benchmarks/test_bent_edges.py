"""The jackknife over lines notices that edges bend, and finds nothing where they do not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import plumbline
from tests.benchmarks.bent_edges import leave_one_out, own
from tests.benchmarks.groups import ALIKE
from tests.benchmarks.simulated import Layout
from tests.benchmarks.spoiling import bent
from tests.benchmarks.trials import observations

MANY = Layout("many picks", 10, 19, 19)
"""More picks a line than anyone picks by hand, yet too few for a fit that knows bends."""
DENSE_GROUP = replace(
    next(group for group in ALIKE if group.layout.name == "dense" and group.noise_px == 0.1),
    layout=MANY,
)


def _ratio(points: np.ndarray) -> float:
    made = plumbline.calibrate(observations(DENSE_GROUP, points))
    covariance, dof = leave_one_out(made)
    assert dof == len(DENSE_GROUP.lines) - 1
    return float(np.median(np.sqrt(np.diag(covariance) / np.diag(made.covariance))))


def test_the_jackknife_s_errors_are_larger_where_edges_bend() -> None:
    picks = DENSE_GROUP.picks_px(5)
    straight = np.median([_ratio(points) for points in picks])
    crooked = np.median([_ratio(points) for points in bent(DENSE_GROUP, picks)])
    assert 0.5 < straight < 1.5
    assert crooked > 1.5 * straight


def test_one_step_a_line_says_what_refits_without_each_line_say() -> None:
    for points in bent(DENSE_GROUP, DENSE_GROUP.picks_px(3)):
        made = plumbline.calibrate(observations(DENSE_GROUP, points))
        step, refits = own(made), leave_one_out(made)
        assert step.dof == refits.dof
        np.testing.assert_allclose(step.covariance, refits.covariance, rtol=0.05)

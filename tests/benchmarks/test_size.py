"""The projects of the size benchmark are what it says."""

from __future__ import annotations

import numpy as np

import plumbline
from tests.benchmarks.size import SIZE, B, lines


def test_its_picks_are_of_the_lens_it_names() -> None:
    made = plumbline.calibrate(plumbline.Observations.from_arrays(lines(40, 9), SIZE), free=("b",))
    error = made.standard_errors["b"]
    assert abs(made.coefficients["b"] - B) < 4 * error
    assert np.isclose(made.sigma_px, 0.3, rtol=0.25)

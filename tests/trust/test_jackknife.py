"""The jackknife and the model's error against real refits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import plumbline
from plumbline import Observations, calibrate
from plumbline.trust.displacement import grid_px
from plumbline.trust.jackknife import jackknife
from plumbline.trust.model_error import model_error
from tests import truth
from tests.benchmarks.bent_edges import leave_one_out
from tests.benchmarks.groups import lens
from tests.benchmarks.simulated import Group, Layout
from tests.benchmarks.spoiling import bent
from tests.fit.test_calibrate import MILD, picked
from tests.many import all_calibrated
from tests.truth import Array, TrueLens

BARREL = {"a": 0.02, "b": -0.09, "c": -0.02}


def test_the_jackknife_is_that_of_refits() -> None:
    made = calibrate(picked(TrueLens("ptlens", BARREL), noise_px=0.5, seed=2))
    found, want = made.jackknife, leave_one_out(made)
    assert found is not None
    assert found.dof == want.dof == 15
    np.testing.assert_array_equal(found.lines, np.arange(16))
    ratio = np.sqrt(np.diag(found.covariance) / np.diag(want.covariance))
    np.testing.assert_allclose(ratio, 1.0, atol=0.03)


def test_edges_that_bend_show_in_the_jackknife_alone() -> None:
    group = Group("S120", lens("S120 5.2 mm"), Layout("by hand", 10, 19, 19), 0.1)
    points = bent(group, group.picks_px(1))[0]
    made = calibrate(Observations.from_arrays(group.by_line(points), group.lens.size))
    wide, sure = made.jackknife_displacement, made.displacement
    assert wide is not None
    assert sure is not None
    assert wide.worst_px > 1.5 * sure.worst_px
    assert made.quotes_jackknife
    assert made.quoted is not None
    assert made.trust.steadiness is not None
    assert made.quoted.worst_px > made.trust.steadiness.own_px
    assert any("leaving out one line" in note for note in made.notes)


def test_lines_left_out_as_a_whole_are_none_of_the_jackknifes() -> None:
    made = calibrate(picked(TrueLens("ptlens", BARREL), noise_px=0.5))
    kept = list(made.kept)
    kept[3] = np.zeros(12, dtype=np.bool_)
    fewer = replace(made, kept=tuple(kept))
    found = fewer.jackknife
    assert found is not None
    assert found.lines.tolist() == [0, 1, 2, *range(4, 16)]
    assert found.dof == 14
    assert jackknife(replace(made.linearised, kept=made.linearised.line == 0)) is None


def richer_px(made: plumbline.Calibration, other: plumbline.Calibration) -> float:
    """Largest difference over the grid after the best common scale and translation."""
    points = grid_px(made.lens)
    return truth.unlike_px(made.lens.undistort(points), other.lens.undistort(points))


@pytest.mark.parametrize(
    ("model", "free", "richer", "names"),
    [
        ("poly3", ("k1",), "ptlens", "r and r³"),
        ("ptlens", ("b",), "ptlens", "r³ and r"),
        ("radial:2,4", ("a2", "a4"), "radial:2,4,6", "r⁶"),
        ("radial:1,2,3", ("a1", "a2"), "radial:1,2,3", "r³"),
        ("brown", ("k1", "k2"), "radial:2,4,6", "r⁶"),
    ],
)
def test_the_models_error_is_that_of_a_richer_fit(
    model: str, free: tuple[str, ...], richer: str, names: str
) -> None:
    """Of a lens that none of these follows quite, picked so well that one step is exact enough."""
    true = TrueLens("ptlens", {"a": 0.012, "b": -0.05, "c": 0.02})
    made = calibrate(picked(true, noise_px=0.05, seed=4), model, free=free)
    found = made.model_error
    assert found is not None
    assert found.names == names
    want = richer_px(made, calibrate(made.observations, richer))
    assert found.largest_px == pytest.approx(want, rel=0.05, abs=0.02)
    assert want > 0.15


def test_the_error_of_the_models_error_is_its_scatter() -> None:
    """Fits of b alone, which is right, and of a, b, c, 128 times over."""
    true = TrueLens("ptlens", {"a": 0.0, "b": -0.05, "c": 0.0})
    every = [picked(true, noise_px=0.5, seed=seed) for seed in range(128)]
    pairs = list(zip(all_calibrated(every, free=("b",)), all_calibrated(every), strict=True))
    points = grid_px(pairs[0][0].lens)
    told = [made.model_error for made, _ in pairs]
    assert all(each is not None for each in told)

    def gaps(made: plumbline.Calibration, other: plumbline.Calibration) -> Array:
        here, there = made.lens.undistort(points), other.lens.undistort(points)
        there = there - there.mean(axis=0)
        here = here - here.mean(axis=0)
        return there * (np.sum(here * there) / np.sum(there**2)) - here

    scatter = np.sqrt(np.mean([np.sum(gaps(*pair) ** 2, axis=1) for pair in pairs], axis=0))
    error = float(np.mean([each.error_px for each in told if each is not None]))
    # 128 repeats tell a standard deviation to 6 %.
    assert error == pytest.approx(float(np.max(scatter)), rel=0.2)
    larger = [each.largest_px > 2.5 * each.error_px for each in told if each is not None]
    assert np.mean(larger) < 0.04


def test_there_is_no_model_error_where_the_picks_cannot_tell() -> None:
    true = TrueLens("ptlens", MILD)
    few = [points[::3] for points in true.lines(2, noise_px=0.2)]  # 8 picks, 2 lines
    made = calibrate(Observations.from_arrays(few, true.size), free=("b",))
    assert made.dof == 3
    narrow = replace(made.linearised, kept=np.arange(8) < 3)
    assert model_error(made.lens, made.free, narrow, made.sigma_px) is None
    folding = replace(made.lens, coefficients=made.coefficients | {"a": 0.0, "b": -0.35})
    assert model_error(folding, made.free, made.linearised, made.sigma_px) is None

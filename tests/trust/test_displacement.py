"""The standard error of the correction in pixels, against repeated fits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import plumbline
from plumbline import calibrate
from plumbline.frame import Array, Frame
from plumbline.geometry.lens import Lens
from plumbline.models import get_model
from plumbline.trust.displacement import Displacement, difference_px, displacement_errors, grid_px
from tests import truth
from tests.benchmarks.lensfun_recovery import Entry, ideal_corner, lines_of
from tests.fit.test_calibrate import picked
from tests.many import all_calibrated
from tests.truth import TrueLens

ENTRY = Entry("a wide zoom", (0.0244, -0.0649, 0.0015), 1.5)
NOISE_PX = 0.4
REPEATS = 256


def _aligned(found: Array, want: Array, place: Array) -> Array:
    """`found` less `want` after the best common scale and translation."""
    one, none = np.ones(len(place)), np.zeros(len(place))
    motions = ((one, none), (none, one), (place[:, 0], place[:, 1]))
    design = np.stack([np.stack(m, axis=-1).ravel() for m in motions], axis=-1)
    gap = (found - want).ravel()
    return (gap - design @ np.linalg.lstsq(design, gap, rcond=None)[0]).reshape(-1, 2)


@pytest.mark.parametrize("free", [("a", "b", "c"), ("a", "b", "c", "d", "e")], ids=len)
def test_errors_are_the_scatter_of_repeated_fits(free: tuple[str, ...]) -> None:
    corner = ideal_corner(ENTRY)
    assert corner
    rng = np.random.default_rng(11)
    clean = [np.clip(line, 3, np.array(ENTRY.size) - 4) for line in lines_of(ENTRY, corner)]
    made = all_calibrated(
        [
            plumbline.Observations.from_arrays(
                [line + rng.normal(0, NOISE_PX, line.shape) for line in clean], ENTRY.size
            )
            for _ in range(REPEATS)
        ],
        free=free,
    )
    points = grid_px(made[0].lens)
    truth = Lens(
        get_model("ptlens"),
        Frame(*ENTRY.size),
        dict(zip("abcde", (*ENTRY.abc, 0.0, 0.0), strict=True)),
    )
    want = truth.undistort(points)
    place = truth.frame.normalise(want)
    gaps = np.stack([_aligned(each.lens.undistort(points), want, place) for each in made])
    scatter = np.sqrt(np.mean(np.sum(gaps**2, axis=2), axis=0))
    claimed = [displacement_errors(m.lens, m.free, m.covariance, points) for m in made[:16]]
    mean = np.mean(np.stack([errors for errors in claimed if errors is not None]), axis=0)
    # 256 repeats tell a standard deviation to 4.4 %; σ̂ itself scatters within one fit.
    assert np.all(np.abs(mean - scatter) < 0.15 * scatter + 1e-3)
    assert np.max(scatter) > 0.3
    told = [each.displacement for each in made]
    worst = np.mean([each.worst_px for each in told if each is not None])
    assert worst == pytest.approx(np.max(scatter), rel=0.2)


def test_no_error_is_told_where_the_model_folds() -> None:
    made = plumbline.calibrate(
        plumbline.Observations.from_arrays(
            [
                np.clip(p, 0, np.array(ENTRY.size) - 1)
                for p in lines_of(ENTRY, ideal_corner(ENTRY) or 0)
            ],
            ENTRY.size,
        )
    )
    folding = replace(
        made, lens=replace(made.lens, coefficients=made.coefficients | {"a": 0.0, "b": -0.35})
    )
    assert made.displacement is not None
    assert folding.displacement is None
    assert folding.quoted_displacement is None
    assert folding.model_error is None
    assert folding.finding.folds_at_px is not None
    (told,) = [check for check in folding.checks if check.name == "correction"]
    assert not told.passed
    assert "folds inside the photo" in told.sentence


def test_a_common_scale_is_no_error() -> None:
    """poly3 and poly5 with k1 alone are one curve in two gauges, 1 − k1 apart in scale."""
    obs = picked(TrueLens("poly3", {"k1": -0.06}), noise_px=0.5)
    three, five = (calibrate(obs, name, free=("k1",)) for name in ("poly3", "poly5"))
    k1 = three.coefficients["k1"]
    assert five.coefficients["k1"] == pytest.approx(k1 / (1 - k1) ** 3, rel=1e-6)
    assert three.displacement is not None
    assert five.displacement is not None
    ratio = five.displacement.errors_px / three.displacement.errors_px
    np.testing.assert_allclose(np.delete(ratio, 40), 1 - k1, rtol=1e-5)  # the centre's is 0
    for made in (three, five):
        at_px = made.displacement.worst_at_px if made.displacement else None
        # Radial terms about the image centre err alike in all four corners.
        np.testing.assert_array_equal(at_px, [[0, 0], [2999, 0], [0, 2249], [2999, 2249]])


@pytest.mark.parametrize(
    ("worst", "words"),
    [
        ([0, 2, 6, 8], "at the corners"),
        ([0], "at (0, 0)"),
        ([3, 5], "at (0, 50), (200, 50)"),
        ([0, 2, 3, 8], "at (0, 0), (200, 0), (0, 50), (200, 100)"),
        (list(range(9)), "at 9 places"),
    ],
)
def test_places_that_are_as_bad_are_all_told(worst: list[int], words: str) -> None:
    x, y = np.meshgrid([0.0, 100.0, 200.0], [0.0, 50.0, 100.0])
    errors_px = np.full(9, 1.9)
    errors_px[worst] = 2.0 - 0.001 * np.arange(len(worst))
    sure = Displacement(np.stack((x.ravel(), y.ravel()), axis=1), errors_px)
    assert sure.worst_place == words
    assert sure.worst_px == 2.0


def test_a_perspective_is_no_error_where_lines_cannot_see_it() -> None:
    """With p1 and p2 free, the scatter of 96 fits after the best homography."""
    true = TrueLens("brown", {"k1": -0.05, "k2": 0.01, "p1": 0.002, "p2": -0.001})
    free = ("k1", "k2", "p1", "p2")
    clean, rng = true.lines(), np.random.default_rng(6)
    made = [
        calibrate(
            plumbline.Observations.from_arrays(
                [line + rng.normal(0, 0.5, line.shape) for line in clean], true.size
            ),
            "brown",
            free=free,
        )
        for _ in range(96)
    ]
    points = grid_px(made[0].lens)
    want = true.undistort(points)
    place = (want - want.mean(axis=0)) / 1000
    x, y = place.T
    one, none = np.ones_like(x), np.zeros_like(x)
    motions = [(one, none), (none, one), (x, none), (none, x), (y, none), (none, y)]
    motions += [(x * x, x * y), (x * y, y * y)]
    design = np.stack([np.stack(m, axis=-1).ravel() for m in motions], axis=-1)
    gaps = np.stack([(each.lens.undistort(points) - want).ravel() for each in made], axis=-1)
    gaps -= design @ np.linalg.lstsq(design, gaps, rcond=None)[0]
    scatter = np.sqrt(np.mean(np.sum(gaps.reshape(-1, 2, 96) ** 2, axis=1), axis=1))
    told = [each.displacement.errors_px for each in made if each.displacement is not None]
    assert len(told) == 96
    # 96 repeats tell a standard deviation to 7 %.
    np.testing.assert_allclose(np.mean(told, axis=0), scatter, rtol=0.25)


def test_two_lenses_differ_by_what_lines_can_tell() -> None:
    zero = dict.fromkeys("abcde", 0.0)
    frame = Frame(3000, 2250)
    one = Lens(get_model("ptlens"), frame, zero | {"b": -0.05})
    moved = Lens(get_model("ptlens"), frame, zero | {"b": -0.05, "d": 4.0, "a": 0.01})
    grid = grid_px(one)
    want = truth.unlike_px(one.undistort(grid), moved.undistort(grid))
    found = difference_px(moved, one, grid, perspective=False)
    assert found == pytest.approx(want, rel=0.02)
    assert want > 2
    assert difference_px(moved, one, grid, perspective=True) < found
    tilted = truth.unlike_px(one.undistort(grid), moved.undistort(grid), perspective=True)
    assert difference_px(moved, one, grid, perspective=True) == pytest.approx(tilted, rel=0.1)
    folding = Lens(get_model("ptlens"), frame, zero | {"b": -0.35})
    assert difference_px(one, folding, grid, perspective=False) == float("inf")

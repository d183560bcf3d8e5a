"""Fits without single lines that carry the result, against real fits without them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from plumbline import Calibration, Observations, calibrate
from plumbline.trust.displacement import errors_of, motions
from plumbline.trust.jackknife import Jackknife, jackknife
from tests.benchmarks.bent_edges import leave_one_out
from tests.truth import Array, TrueLens

LENS = TrueLens("ptlens", {"a": 0.02, "b": -0.09, "c": -0.02}, (3000, 2000))
Ends = tuple[tuple[float, float], tuple[float, float]]
LONG: Ends = ((60.0, 220.0), (2940.0, 240.0))


def edge(ends: Ends, n: int) -> Array:
    first, last = LENS.undistort(np.array(ends))
    return LENS.distort(first + np.linspace(0, 1, n)[:, None] * (last - first))


def one_long(rng: np.random.Generator) -> list[Array]:
    """A long line and five short ones, of 8 picks over 250 to 450 px."""
    lines = [edge(LONG, 10)]
    for _ in range(5):
        x, y, turn = rng.uniform(300, 2700), rng.uniform(300, 1700), rng.uniform(0, np.pi)
        half = rng.uniform(125, 225) * np.array((np.cos(turn), np.sin(turn)))
        lines.append(edge(((x - half[0], y - half[1]), (x + half[0], y + half[1])), 8))
    return lines


def one_dense(_: np.random.Generator) -> list[Array]:
    """A line of 400 picks and six of five."""
    down = [((60.0, y), (2940.0, y + 30)) for y in (400.0, 800.0, 1300.0, 1700.0)]
    across = [((x, 60.0), (x + 20, 1940.0)) for x in (200.0, 2700.0)]
    return [edge(LONG, 400), *(edge(ends, 5) for ends in (*down, *across))]


def fitted(name: str, seed: int) -> Calibration:
    rng = np.random.default_rng(seed)
    lines = LAYOUTS[name](rng)
    noisy = [line + rng.normal(0, 0.5, line.shape) for line in lines]
    return calibrate(Observations.from_arrays(noisy, LENS.size))


LAYOUTS = {"one long": one_long, "one dense": one_dense}


def worst_px(made: Calibration, found: Array) -> float:
    points = made.trust.range_px
    moved = motions(made.lens, made.free, points, gauge_px=points)
    assert moved is not None
    return float(np.max(errors_of(moved, found)))


@pytest.mark.parametrize(("name", "seed"), [("one long", 1), ("one long", 3), ("one dense", 1)])
def test_the_jackknife_is_that_of_fits_without_each_line(name: str, seed: int) -> None:
    made = fitted(name, seed)
    found, one_step = made.jackknife, jackknife(made.linearised)
    assert isinstance(found, Jackknife)
    assert one_step is not None
    want_px = worst_px(made, leave_one_out(made).covariance)
    assert worst_px(made, found.covariance) == pytest.approx(want_px, rel=0.01)
    assert worst_px(made, one_step.covariance) != pytest.approx(want_px, rel=0.05)


def test_residuals_of_the_corrected_photo_and_a_model_that_cannot_follow() -> None:
    made = fitted("one long", 1)
    for how in ({"residual": "corrected"}, {"model": "radial:2,4", "free": ("a2",)}):
        other = calibrate(made.observations, **how)  # pyright: ignore[reportArgumentType]
        lines = other.observations.lines[1:]
        fewer = replace(other.observations, lines=lines)
        want = calibrate(fewer, **how)  # pyright: ignore[reportArgumentType]
        found = other.jackknife
        assert found is not None
        moved = [want.coefficients[n] - other.coefficients[n] for n in other.free]
        np.testing.assert_allclose(found.shifts[0], moved, rtol=0.02)

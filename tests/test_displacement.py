"""The standard error of the correction in pixels, against repeated fits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import plumbline
from plumbline.displacement import displacement_errors, grid_px
from plumbline.frame import Array, Frame
from plumbline.lens import Lens
from plumbline.models import get_model
from tests.benchmarks.lensfun_recovery import Entry, ideal_corner, lines_of

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
    made = plumbline.calibrate_many(
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
    corners = [0, 8, 72, 80]
    worst = np.mean([each.corner_error_px or 0.0 for each in made])
    assert worst == pytest.approx(np.max(scatter[corners]), rel=0.2)


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
    assert made.corner_error_px is not None
    assert folding.corner_error_px is None
    assert folding.finding.folds_at_px is not None

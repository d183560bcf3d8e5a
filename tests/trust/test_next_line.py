"""The line to pick next, against fits with that line picked."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from plumbline import Observations, calibrate
from plumbline.trust.assessment import ResidualKind
from plumbline.trust.next_line import candidates, next_line
from tests.truth import Array, TrueLens

LENS = TrueLens("ptlens", {"a": 0.01, "b": -0.05, "c": 0.0})
SIGMA_PX = 0.1


def seen(ends: Array, n: int = 9) -> Array:
    """Picks along the straight line between two observed points."""
    first, last = LENS.undistort(ends)
    return LENS.distort(first + np.linspace(0, 1, n)[:, None] * (last - first))


def noisy(lines: list[Array], seed: int, sigma_px: float = SIGMA_PX) -> Observations:
    rng = np.random.default_rng(seed)
    return Observations.from_arrays(
        [line + rng.normal(0, sigma_px, line.shape) for line in lines], LENS.size
    )


INNER = [seen(np.array([[900.0, y], [2100.0, y]])) for y in (500.0, 800.0, 1500.0)] + [
    seen(np.array([[x, 500.0], [x, 1750.0]])) for x in (900.0, 1900.0)
]


@pytest.mark.parametrize("residual", ["image", "corrected"])
def test_what_the_next_line_promises_it_keeps(residual: ResidualKind) -> None:
    """The promise is for the best of all candidates, and is kept when it is picked."""
    made = calibrate(noisy(INNER, 1), free=("b", "c"), residual=residual)
    told = next_line(made.trust)
    assert told is not None
    assert made.displacement is not None
    assert told.from_px == made.displacement.worst_px
    found: dict[tuple[str, str], float] = {}
    for place, points in candidates(LENS.size).items():
        line = seen(points[[0, -1]])
        more = calibrate(noisy([*INNER, line], 1), free=("b", "c"))
        assert more.displacement is not None
        found[place] = more.displacement.worst_px * made.sigma_px / more.sigma_px
    best = min(found, key=lambda place: found[place])
    assert told.place == "near the top, bottom, left or right edge"
    sides = [side for side in ("top", "bottom", "left", "right") if side in told.place]
    for side in sides:
        there = found["near the {} edge", side]
        assert there == pytest.approx(found[best], rel=0.15)
        assert told.to_px == pytest.approx(there, rel=0.25)
    assert told.to_px < 0.1 * told.from_px


def test_an_off_centre_lens_tells_one_edge_from_the_other() -> None:
    held = noisy(INNER, 1)
    start = {"d": 300.0, "e": 0.0}
    told = next_line(calibrate(held, free=("b",), start=start).trust)
    assert told is not None
    assert told.place in ("near the left edge", "near the right edge")


def test_candidates_lie_where_they_say() -> None:
    every = candidates((3000, 2000))
    assert len(every) == 8
    for points in every.values():
        assert points.shape == (9, 2)
        assert np.all((points > 0) & (points < (2999, 1999)))
    assert np.all(every["near the {} edge", "top"][:, 1] == pytest.approx(0.04 * 1999))
    assert np.all(every["near the {} edge", "right"][:, 0] == pytest.approx(0.96 * 2999))
    inside = "a third of the way from the centre to the {}"
    third = every[inside, "top"]
    assert np.all(third[:, 1] == pytest.approx(1999 / 2 * (1 - 1 / 3)))
    third = every[inside, "right"]
    assert np.all(third[:, 0] == pytest.approx(2999 / 2 * (1 + 1 / 3)))


def test_there_is_no_next_line_where_the_model_folds() -> None:
    made = calibrate(noisy(INNER, 1))
    folding = replace(
        made, lens=replace(made.lens, coefficients=made.coefficients | {"a": 0.0, "b": -0.35})
    )
    assert next_line(folding.trust) is None

"""Lateral colour, on rendered photographs whose colours are magnified by known amounts."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

import plumbline
from plumbline.edges.colours import LateralColour, lateral_colour
from tests.benchmarks.snapping import picked
from tests.render.plane import take
from tests.render.shots import clean, long_edges, shot

SIZE = (1000, 667)
RED, BLUE = 7e-4, -4e-4


@lru_cache(maxsize=2)
def measured(quality: int) -> LateralColour:
    camera, wall = shot(1, size=SIZE)
    camera = replace(
        clean(camera), noise=1.0, red_shift=RED, blue_shift=BLUE, quality=quality, sampling_420=True
    )
    picture = np.ascontiguousarray(take(camera, wall)[..., ::-1])
    edges = long_edges(camera.view, wall)
    rough = picked(edges, 1.0, camera.view, 1)
    made = plumbline.snap(plumbline.Observations.from_arrays(rough, SIZE), picture)
    assert made.colour is not None
    assert made.colour.note in made.notes
    return lateral_colour(picture, made.lines, halved_colours=quality > 0)


def test_the_magnifications_are_found() -> None:
    made = measured(0)
    corner = np.hypot(*(np.array(SIZE) - 1)) / 2
    for shift, truth in ((made.red, RED), (made.blue, BLUE)):
        assert shift.corner_px == pytest.approx(truth * corner, abs=0.03)
        assert shift.corner_error_px < 0.02
        assert shift.k == pytest.approx(1 + truth, abs=2e-5)
        # Its two coefficients share the magnification; at the corner they agree with it.
        radius = float(np.hypot(*SIZE)) / min(SIZE)
        assert shift.v - 1 + shift.b * radius**2 == pytest.approx(truth, abs=5e-5)


def test_halved_colours_are_warned_of() -> None:
    assert "4:2:0" in measured(92).note
    assert "4:2:0" not in measured(0).note


def test_a_grey_photo_has_none() -> None:
    with pytest.raises(plumbline.DegenerateLinesError, match="grey"):
        lateral_colour(np.zeros((50, 50), np.uint8), ())


def test_too_few_edges() -> None:
    with pytest.raises(plumbline.DegenerateLinesError, match="only 0 edges"):
        lateral_colour(np.zeros((50, 50, 3), np.uint8), ())

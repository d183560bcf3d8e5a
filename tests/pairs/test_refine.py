"""Matches move to where the pictures agree, whatever their contrast; others are dropped."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from plumbline.frame import Frame
from plumbline.geometry.lens import Lens
from plumbline.models import get_model
from plumbline.pairs.matching import Matches
from plumbline.pairs.refine import refined
from plumbline.photos.brightness import brightness
from plumbline.trust.matched import Setting
from tests.render import board, pair

TRUTH = pair.Pair(lens=board.COMPACT, size=(640, 480))


@pytest.fixture(scope="module")
def pictures() -> tuple[np.ndarray, np.ndarray]:
    return pair.take(TRUTH)


def nearly() -> Setting:
    """The truth, its lens off by some tenths of a pixel."""
    coefficients = TRUTH.lens.coefficients | {"d": 0.0, "e": 0.0}
    coefficients["b"] += 0.002
    lens = Lens(get_model("ptlens"), Frame(*TRUTH.size), coefficients, None)
    centre = TRUTH.corrected(TRUTH.view.centre[None])[0]
    return Setting(lens, TRUTH.scale, (float(centre[0]), float(centre[1])))


def rough() -> Matches:
    """A grid of places, matched to half a pixel."""
    x, y = np.meshgrid(np.arange(20.0, 620, 16), np.arange(20.0, 460, 16))
    seen = np.stack((x.ravel(), y.ravel()), axis=1)
    error = np.random.default_rng(1).normal(0, 0.5, seen.shape)
    return Matches(seen, TRUTH.corrected(TRUTH.view.undistort(seen)) + error)


@pytest.mark.parametrize(("gain", "offset"), [(1.0, 0.0), (0.6, 40.0)])
def test_matches_come_out_where_the_scene_is(
    pictures: tuple[np.ndarray, np.ndarray], gain: float, offset: float
) -> None:
    original, corrected = (brightness(each) for each in pictures)
    found = refined(original, (gain * corrected + offset).astype(np.float32), nearly(), rough())
    error = found.corrected_px - TRUTH.corrected(TRUTH.view.undistort(found.observed_px))
    assert len(found) > 0.6 * len(rough())
    assert np.median(np.abs(error)) < 0.05
    assert np.abs(error.mean(axis=0)).max() < 0.01


def test_windows_that_show_something_else_are_dropped(
    pictures: tuple[np.ndarray, np.ndarray],
) -> None:
    original, corrected = (brightness(each) for each in pictures)
    other = brightness(pair.take(replace(TRUTH, seed=9))[1])
    half = corrected.shape[1] // 2
    corrected[:, half:] = other[:, half:]
    found = refined(original, corrected, nearly(), rough())
    assert len(found) > 100
    assert np.count_nonzero(found.corrected_px[:, 0] > half + 10) < 0.02 * len(found)

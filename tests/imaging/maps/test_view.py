"""Scaling, turning and reversing."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from plumbline.errors import OptionError
from plumbline.imaging.correct import correct_array
from plumbline.imaging.maps.view import SCALES, Scale, view_of
from plumbline.lenses.correction import Correction
from tests.imaging.painted import barrel, centroids, dots, grid_inside, texture
from tests.truth import TrueLens, grid_px

SIZE = (603, 402)
PINCUSHION = {"a": 0.0, "b": 0.06, "c": 0.0}
WAVY = {"a": 0.06, "b": -0.13, "c": 0.03}


def _correction(**c: float) -> Correction:
    lens = barrel(SIZE, **c)
    return Correction(lens.distort, lens.undistort, SIZE, "a lens")


@pytest.mark.parametrize("c", [{}, PINCUSHION, WAVY, {"d": 12.0, "e": -7.0}])
def test_fit_shows_all_of_the_photo_and_touches_the_frame(c: dict[str, float]) -> None:
    made = _correction(**c)
    view = view_of(made, scale="fit")
    border = grid_px(SIZE, 101)
    middle = (np.array(SIZE) - 1) / 2
    placed = (made.undistort(border) - middle) / view.stretch + middle
    outermost = np.max(np.abs(placed - middle) / middle)
    assert outermost <= 1 + 1e-4
    assert outermost > 1 - 1e-3


@pytest.mark.parametrize("c", [{}, PINCUSHION, WAVY, {"d": 12.0, "e": -7.0}])
def test_fill_leaves_no_empty_border_and_wastes_nothing(c: dict[str, float]) -> None:
    view = view_of(_correction(**c), scale="fill")
    edge = grid_px(SIZE, 401)
    edge = edge[np.any((edge == 0) | (edge == np.array(SIZE) - 1.0), axis=1)]
    seen = view.observed(edge)
    last = np.array(SIZE) - 1.0
    assert np.all((seen > -1e-3) & (seen < last + 1e-3))
    assert np.min(np.abs(np.concatenate((seen, last - seen)))) < 0.05


def test_keep_leaves_the_circle_at_half_the_shorter_side() -> None:
    view = view_of(_correction())
    angles = np.linspace(0, 6, 20)
    middle = (np.array(SIZE) - 1) / 2
    circle = middle + 201.0 * np.stack((np.cos(angles), np.sin(angles)), axis=-1)
    assert np.max(np.abs(view.observed(circle) - circle)) < 1e-9


def test_fill_of_a_lens_that_folds_does_not_take_the_far_side_for_cover() -> None:
    view = view_of(_correction(a=0.0, b=-0.15, c=0.0), scale="fill")
    assert 0.9 < view.stretch < 1.1


def test_inverse_puts_the_distortion_in() -> None:
    lens = TrueLens("ptlens", {"a": 0.0, "b": -0.03, "c": 0.0}, SIZE)
    made = Correction(lens.distort, lens.undistort, SIZE, "a lens")
    ideal = grid_inside(SIZE, 7, 5, 70)
    painted = np.rint(dots(SIZE, ideal) * 60000).astype(np.uint16)
    distorted = correct_array(painted, made, inverse=True)
    found = centroids(distorted, lens.distort(ideal))
    assert np.max(np.hypot(*(found - lens.distort(ideal)).T)) < 0.05


# How each EXIF orientation is stored, from the picture as displayed.
STORED: dict[int, Callable[[NDArray[Any]], NDArray[Any]]] = {
    1: lambda p: p,
    2: lambda p: p[:, ::-1],
    3: lambda p: p[::-1, ::-1],
    4: lambda p: p[::-1],
    5: lambda p: p.swapaxes(0, 1),
    6: lambda p: np.rot90(p, 1),
    7: lambda p: p[::-1, ::-1].swapaxes(0, 1),
    8: lambda p: np.rot90(p, -1),
}


@pytest.mark.parametrize("orientation", STORED)
@pytest.mark.parametrize("scale", SCALES)
def test_a_turned_photo_is_corrected_as_it_is_displayed(orientation: int, scale: Scale) -> None:
    from plumbline.imaging.maps.sampling_map import SamplingMap
    from plumbline.imaging.resample import resample

    made = _correction(d=15.0, e=-9.0)
    upright = texture(SIZE)
    view = view_of(made, scale=scale)
    expected = resample(upright, SamplingMap(view.stored_size, view.observed), "linear", (0, 0, 0))
    turned = view_of(made, orientation=orientation, scale=scale)
    stored = np.ascontiguousarray(STORED[orientation](upright))
    assert turned.stored_size == stored.shape[1::-1]
    sampling = SamplingMap(turned.stored_size, turned.observed)
    found = resample(stored, sampling, "linear", (0, 0, 0))
    gap = np.abs(found.astype(int) - STORED[orientation](expected).astype(int))
    # Positions round to 1/32 px, halves of it not the same way in every orientation.
    assert np.mean(gap) < 0.2


def test_a_lens_that_folds_inside_the_photo_cannot_show_all_of_it() -> None:
    import plumbline

    lens = plumbline.Lens(
        plumbline.get_model("poly3"), plumbline.Frame(*SIZE), {"k1": -0.4, "d": 0.0, "e": 0.0}
    )
    with pytest.raises(OptionError, match="fold"):
        correct_array(texture(SIZE), lens, scale="fit")

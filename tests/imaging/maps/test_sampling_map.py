"""The interpolated map against an independent truth, for every model."""

from __future__ import annotations

import numpy as np
import pytest

from plumbline.frame import Frame
from plumbline.geometry.lens import Lens
from plumbline.imaging.maps.horizon import find_horizon
from plumbline.imaging.maps.sampling_map import NOWHERE, SamplingMap
from plumbline.models import get_model
from tests.truth import Array, TrueLens

LENSES = {
    "ptlens": {"a": 0.032, "b": -0.098, "c": 0.042},
    "poly3": {"k1": -0.05},
    "poly5": {"k1": -0.06, "k2": 0.01},
    "radial:1,2,3": {"a1": 0.03, "a2": 0.05, "a3": 0.01},
    "radial:2,4,6": {"a2": 0.06, "a4": -0.01, "a6": 0.002},
    "brown": {"k1": 0.06, "k2": -0.01, "k3": 0.001, "p1": 0.002, "p2": -0.003},
    "division": {"l1": -0.08, "l2": 0.01},
    "opencv": {"k1": -0.15, "k2": 0.03, "p1": 0.001, "p2": -0.001, "k3": 0.0},
    "acm": {"k1": -0.15, "k2": 0.03, "k3": 0.0, "k4": 0.001, "k5": -0.001},
}
SIZE = (1203, 802)
FOCAL_PX = 900.0


def _lens(name: str, c: dict[str, float], size: tuple[int, int] = SIZE) -> Lens:
    model = get_model(name)
    focal = FOCAL_PX if model.unit == "focal length" else None
    return Lens(model, Frame(*size), {"d": 3.0, "e": -2.0} | c, focal)


def _whole(sampling: SamplingMap) -> Array:
    width, height = sampling.size
    found = np.empty((height, width, 2))
    for tile in sampling.tiles():
        found[tile] = np.stack(sampling.coordinates(tile), axis=-1)
    return found


@pytest.mark.parametrize("name", LENSES)
def test_every_pixel_is_taken_from_its_place_to_a_hundredth(name: str) -> None:
    c = {"d": 3.0, "e": -2.0} | LENSES[name]
    truth = TrueLens(name, c, SIZE, FOCAL_PX)
    found = _whole(SamplingMap(SIZE, _lens(name, LENSES[name]).distort))
    x, y = np.meshgrid(np.arange(SIZE[0]), np.arange(SIZE[1]))
    places = np.stack((x, y), axis=-1)[::7, ::7].reshape(-1, 2).astype(float)
    expected = truth.distort(places)
    assert np.max(np.hypot(*(expected - places).T)) > 5
    gap = found[::7, ::7].reshape(-1, 2) - expected
    assert np.max(np.hypot(*gap.T)) < 0.01


def test_interpolation_stands_in_for_the_exact_map_only_where_it_is_good() -> None:
    rough = SamplingMap((900, 700), lambda p: p + 0.5 * np.sin(p[..., ::-1] * 0.157))
    x, y = np.meshgrid(np.arange(900.0), np.arange(700.0))
    p = np.stack((x, y), axis=-1)
    expected = p + 0.5 * np.sin(p[..., ::-1] * 0.157)
    assert np.max(np.abs(_whole(rough) - expected)) < 1e-3


@pytest.mark.parametrize("size", [(1, 1), (1, 300), (40, 1), (2, 2), (33, 65), (513, 512)])
def test_pictures_of_any_size(size: tuple[int, int]) -> None:
    found = _whole(SamplingMap(size, lambda p: p * 0.9 + 3))
    x, y = np.meshgrid(np.arange(size[0]), np.arange(size[1]))
    assert np.max(np.abs(found - (np.stack((x, y), axis=-1) * 0.9 + 3))) < 1e-3


def test_beyond_a_fold_nothing_is_shown() -> None:
    # r (1.4 − 0.4 r²) turns back at r = 1.0801; the corner is at 1.8.
    lens = _lens("poly3", {"k1": -0.4, "d": 0.0, "e": 0.0})
    found = _whole(SamplingMap(SIZE, lens.distort))
    x, y = np.meshgrid(np.arange(SIZE[0]), np.arange(SIZE[1]))
    radius = np.hypot(x - (SIZE[0] - 1) / 2, y - (SIZE[1] - 1) / 2) / (SIZE[1] / 2)
    fold = np.sqrt(1.4 / 1.2)
    hidden = found[..., 0] == NOWHERE
    assert np.all(hidden[radius > fold + 0.01])
    assert not np.any(hidden[radius < fold - 0.01])


def test_a_lens_that_reaches_no_corner_leaves_it_empty() -> None:
    # Its ideal radius never exceeds 2/3 · 1 / √(3 · 0.25) = 0.77; points beyond raise an error.
    lens = _lens("radial:2", {"a2": -0.25, "d": 0.0, "e": 0.0})
    furthest = 2 / 3 / np.sqrt(0.75)
    horizon = find_horizon(lens.distort, SIZE)
    assert np.allclose(horizon.radii_px / (SIZE[1] / 2), furthest, atol=0.01)
    found = _whole(SamplingMap(SIZE, lens.distort))
    assert found[0, 0, 0] == NOWHERE
    assert np.allclose(found[400, 601], [601, 400], atol=1.5)

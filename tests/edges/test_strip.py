"""Strips: pixels along a curve, interpolated across it with exact weights."""

from __future__ import annotations

import numpy as np
import pytest

from plumbline.edges.guide import Guide, GuideError, through_nodes, through_picks
from plumbline.edges.strip import cut
from plumbline.frame import Frame
from plumbline.geometry.lens import Lens
from plumbline.models import get_model


def ramp(steep: bool) -> np.ndarray:
    """A quadratic across the guide, which a cubic interpolates without error."""
    at = np.arange(80, dtype=np.float64)
    image = np.repeat((0.01 * at**2)[:, None], 120, axis=1)
    return (image.T if steep else image).astype(np.float32)


@pytest.mark.parametrize("steep", [False, True])
@pytest.mark.parametrize("per_px", [1, 2, 4])
def test_values_stand_where_the_offsets_say(steep: bool, per_px: int) -> None:
    guide = Guide(steep, 10, 40.37 + 0.013 * np.arange(90.0))
    strip = cut(ramp(steep), guide, 6, 90, per_px)
    middle = guide.at(strip.along)
    expected = 0.01 * (middle[:, None] + strip.offset) ** 2
    np.testing.assert_allclose(strip.values, expected, atol=2e-4)


def test_rows_are_means_over_stretches_of_the_curve() -> None:
    guide = Guide(False, 0, np.full(100, 40.0))
    image = np.tile(np.arange(120, dtype=np.float32), (80, 1))
    strip = cut(image, guide, 3, 7)
    np.testing.assert_allclose(strip.values, np.repeat(strip.along[:, None], 7, axis=1), rtol=1e-6)
    assert strip.length.sum() == 100


def test_outside_the_photo_nothing_is_known() -> None:
    strip = cut(ramp(False), Guide(False, 0, np.full(50, 2.0)), 6, 5)
    assert np.isnan(strip.values[:, strip.offset < -2]).all()
    assert np.isfinite(strip.values[:, strip.offset >= 0]).all()


def test_a_lens_bends_the_guide_as_it_bends_lines() -> None:
    zero = {"a": 0.0, "b": -0.05, "c": 0.0, "d": 0.0, "e": 0.0}
    lens = Lens(get_model("ptlens"), Frame(600, 400), zero)
    share = np.linspace(0, 1, 50)[:, None]
    seen = lens.distort(np.array([30.0, 40.0]) * (1 - share) + np.array([560.0, 55.0]) * share)
    guide = through_picks(seen[[3, 20, 44]], lens, (600, 400))
    along, offset = guide.offsets(seen[4:44])
    assert np.ptp(seen[:, 1] - 40 - 15 * share[:, 0]) > 3  # it does bend
    assert np.abs(offset).max() < 0.01
    assert along[0] == seen[4, 0]


@pytest.mark.parametrize(
    ("nodes", "reason"),
    [
        ([[10, 10], [60, 12], [40, 13]], "back"),
        ([[10, 10], [15, 12]], "less than"),
        ([[-900, 10], [-10, 12]], "less than"),
    ],
)
def test_curves_along_which_nothing_can_be_read(nodes: list[list[float]], reason: str) -> None:
    with pytest.raises(GuideError, match=reason):
        through_nodes(np.array(nodes, dtype=float), (600, 400))

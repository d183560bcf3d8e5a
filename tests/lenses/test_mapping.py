"""A model laid over a photo of any size and orientation."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from plumbline.errors import FoldedError
from plumbline.frame import Array, Frame
from plumbline.geometry.lens import Lens
from plumbline.lenses.mapping import TURNS, PhotoLens
from plumbline.models import get_model

STORED = Frame(400, 300)
VALUES = {"k1": 0.04, "k2": -0.01, "k3": 0.0, "p1": 0.006, "p2": -0.004, "d": 21.0, "e": -13.0}


def upright(points: Array, orientation: int) -> Array:
    """Pixels of the stored picture in the upright one, from EXIF's words."""
    x, y = points[..., 0], points[..., 1]
    right, bottom = 399 - x, 299 - y
    return np.stack(
        {
            1: (x, y),
            2: (right, y),
            3: (right, bottom),
            4: (x, bottom),
            5: (y, x),
            6: (bottom, x),
            7: (bottom, right),
            8: (y, right),
        }[orientation],
        axis=-1,
    )


@pytest.mark.parametrize("orientation", TURNS)
def test_a_turned_photo_is_bent_as_its_sensor_was(orientation: int) -> None:
    lens = Lens(get_model("brown"), STORED, VALUES)
    names = lens.model.coefficients
    shown = Frame(300, 400) if orientation >= 5 else STORED
    mapped = PhotoLens(
        shown,
        lens.model,
        tuple(VALUES[name] for name in names),
        lens.unit_px,
        (VALUES["d"] / lens.unit_px, VALUES["e"] / lens.unit_px),
        turn=TURNS[orientation],
    )
    points = np.random.default_rng(orientation).uniform((0, 0), (399, 299), (50, 2))
    np.testing.assert_allclose(
        mapped.undistort(upright(points, orientation)),
        upright(lens.undistort(points), orientation),
        atol=1e-9,
    )
    np.testing.assert_allclose(
        mapped.distort(mapped.undistort(upright(points, orientation))),
        upright(points, orientation),
        atol=1e-9,
    )


def test_it_travels_to_other_processes() -> None:
    lens = PhotoLens(STORED, get_model("ptlens"), (0.0, -0.02, 0.0), 150.0)
    distort = pickle.loads(pickle.dumps(lens.distort))
    points = np.array([[0.0, 0.0], [199.5, 149.5], [349.5, 149.5]])
    expected = [199.5 - 199.5 * (1.02 - 0.02 * (199.5**2 + 149.5**2) / 150**2), 199.5, 349.5]
    np.testing.assert_allclose(distort(points)[:, 0], expected, rtol=1e-12)


def test_a_folding_lens_is_refused_with_a_sentence() -> None:
    lens = PhotoLens(STORED, get_model("ptlens"), (0.0, -0.4, 0.0), 150.0)
    with pytest.raises(FoldedError, match="folds before it reaches 1 of the points"):
        lens.undistort(np.array([[0.0, 0.0]]))

"""A lens with a shifted centre laid over photos that stand the other way."""

from __future__ import annotations

import re

import numpy as np
import pytest

from plumbline.frame import Array, Frame
from plumbline.imaging.correct import correction_for
from plumbline.lenses.correction import Correction
from plumbline.lenses.request import LensRequest
from plumbline.observations.facts import LensFacts
from plumbline.photos.exif import PhotoFacts
from tests.lenses.made import calibration
from tests.truth import TrueLens

WIDE, TALL = (600, 400), (400, 600)
B, D, E = -0.03, 24.0, -9.0


def _shot(size: tuple[int, int], orientation: int = 1, name: str = "new.jpg") -> PhotoFacts:
    turned = orientation in (5, 6, 7, 8)
    return PhotoFacts(size, LensFacts(), turned, name=name, orientation=orientation)


def _correction(size: tuple[int, int], shot: PhotoFacts) -> Correction:
    return correction_for(shot, calibration(size=size, b=B, d=D, e=E))


def _grid(size: tuple[int, int]) -> Array:
    columns, rows = (np.linspace(0, side - 1, 40) for side in size)
    return np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)


def _truth(size: tuple[int, int], d: float, e: float) -> TrueLens:
    return TrueLens("ptlens", {"a": 0.0, "b": B, "c": 0.0, "d": d, "e": e}, size)


def _is_told(found: Correction, apart: Array) -> None:
    """Whether the one note names how far apart two corrected pictures are, but for a shift."""
    (note,) = found.notes
    number = re.search(r"up to (\d+\.\d) px off", note)
    assert number, note
    expected = np.max(np.hypot(*(apart - np.mean(apart, axis=0)).T))
    assert expected > 1
    assert float(number[1]) == pytest.approx(expected, rel=0.05)  # the grids differ


@pytest.mark.parametrize(
    ("orientation", "centre"), [(6, (-E, D)), (8, (E, -D))]
)  # which way x and y of the stored picture point in the displayed one
def test_exif_tells_to_which_side_the_camera_was_turned(
    orientation: int, centre: tuple[float, float]
) -> None:
    found = _correction(WIDE, _shot(TALL, orientation))
    truth = _truth(TALL, *centre)
    assert np.max(np.abs(found.distort(_grid(TALL)) - truth.distort(_grid(TALL)))) < 1e-9
    assert not found.notes


@pytest.mark.parametrize(
    ("calibrated", "shown", "taken", "otherwise"),
    [
        (WIDE, TALL, (-E, D), (E, -D)),
        (TALL, WIDE, (-E, D), (E, -D)),
        (TALL, TALL, (D, E), (-D, -E)),
    ],
)
def test_where_nobody_tells_the_note_says_how_much_it_matters(
    calibrated: tuple[int, int],
    shown: tuple[int, int],
    taken: tuple[float, float],
    otherwise: tuple[float, float],
) -> None:
    found = _correction(calibrated, _shot(shown))
    points = _grid(shown)
    assert np.max(np.abs(found.distort(points) - _truth(shown, *taken).distort(points))) < 1e-9
    # The other side's corrected picture, but for the shift that straight lines do not see.
    ideal = [_truth(shown, *centre).undistort(points) for centre in (taken, otherwise)]
    _is_told(found, ideal[0] - ideal[1])


def test_tangential_terms_turn_with_the_camera() -> None:
    made = calibration("brown", size=WIDE, k1=0.05, p1=0.02, p2=-0.01)
    found = correction_for(_shot(TALL), made)
    points = _grid(TALL)
    upright = Frame(*TALL).centre_px

    def ideal(p1: float, p2: float) -> Array:
        x, y = ((points - np.array(upright)) / 200).T
        r2 = x**2 + y**2
        radial = 1 + 0.05 * r2
        moved = (
            x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x**2),
            y * radial + p1 * (r2 + 2 * y**2) + 2 * p2 * x * y,
        )
        return np.stack(moved, axis=-1) * 200 + np.array(upright)

    # A turn by 90° carries the vector (p2, p1) with it.
    clockwise, other = ideal(-0.01, -0.02), ideal(0.01, 0.02)
    assert np.max(np.abs(found.undistort(points) - clockwise)) < 1e-9
    _is_told(found, clockwise - other)


def test_the_photo_that_was_calibrated_is_not_doubted() -> None:
    made = calibration("brown", size=TALL, k1=0.05, p1=0.02, p2=-0.01)
    assert correction_for(_shot(TALL), made).notes
    assert not correction_for(_shot(TALL, name="FACADE.jpg"), made).notes


@pytest.mark.parametrize(
    ("size", "orientation", "centre"),
    [(WIDE, 1, (D, E)), (TALL, 1, (D, E)), (WIDE, 3, (-D, -E)), (TALL, 6, (-E, D))],
)
def test_coefficients_typed_in_are_those_of_the_photo_as_stored(
    size: tuple[int, int], orientation: int, centre: tuple[float, float]
) -> None:
    request = LensRequest(ptlens={"b": B, "d": D, "e": E})
    found = correction_for(_shot(size, orientation), request)
    points = _grid(size)
    assert np.max(np.abs(found.distort(points) - _truth(size, *centre).distort(points))) < 1e-9
    assert not found.notes

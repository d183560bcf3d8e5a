"""Pixels: places, values, borders and alpha."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from plumbline.errors import OptionError
from plumbline.imaging.correct import correct_array
from plumbline.imaging.resample import INTERPOLATIONS, Interpolation
from plumbline.lenses.correction import Correction
from tests.imaging.painted import barrel, centroids, dots, grid_inside, texture

SIZE = (901, 600)


def _correction(size: tuple[int, int] = SIZE, **c: float) -> Correction:
    lens = barrel(size, **c)
    return Correction(lens.distort, lens.undistort, size, "a lens")


def _shift(x: float, y: float, size: tuple[int, int]) -> Correction:
    """Ideal pixels lie to the left of observed ones by x, above them by y."""
    move = np.array([x, y])
    return Correction(lambda p: p + move, lambda p: p - move, size, "a shift")


@pytest.mark.parametrize("interpolation", ["linear", "cubic", "lanczos"])
@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_dots_move_to_their_ideal_places(interpolation: Interpolation, kind: Any) -> None:
    lens = barrel(SIZE)
    ideal = grid_inside(SIZE)
    observed = lens.distort(ideal)
    assert np.max(np.hypot(*(observed - ideal).T)) > 8
    full = np.iinfo(kind).max
    painted = np.rint(dots(SIZE, observed) * 0.9 * full).astype(kind)
    corrected = correct_array(painted, _correction(), interpolation=interpolation)
    assert corrected.dtype == kind
    found = centroids(corrected, ideal)
    assert np.max(np.hypot(*(found - ideal).T)) < 0.05
    # A 1/32-px table of positions leaves no bias: the mean error is far smaller.
    assert np.hypot(*np.mean(found - ideal, axis=0)) < 0.01


@pytest.mark.parametrize("interpolation", INTERPOLATIONS)
@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
@pytest.mark.parametrize("channels", [1, 2, 3, 4])
def test_without_distortion_every_value_stays(
    interpolation: Interpolation, kind: Any, channels: int
) -> None:
    rng = np.random.default_rng(channels)
    pixels = rng.integers(0, np.iinfo(kind).max, (530, 600, channels), dtype=kind, endpoint=True)
    if channels in (2, 4):
        pixels[..., -1] = np.iinfo(kind).max
    same = correct_array(pixels, _shift(0, 0, (600, 530)), interpolation=interpolation)
    assert np.array_equal(same, pixels)


def test_nearest_takes_16_bit_values_as_they_are() -> None:
    rng = np.random.default_rng(0)
    pixels = rng.integers(0, 65536, (SIZE[1], SIZE[0], 3), dtype=np.uint16)
    corrected = correct_array(pixels, _correction(), interpolation="nearest", border="edge")
    x, y = np.meshgrid(np.arange(SIZE[0]), np.arange(SIZE[1]))
    observed = barrel(SIZE).distort(np.stack((x, y), axis=-1).astype(float))
    # Where the place is close to the middle between two pixels either may be taken.
    sure = np.all(np.abs(observed - np.floor(observed) - 0.5) > 0.02, axis=-1)
    at = np.clip(np.rint(observed).astype(int), 0, np.array(SIZE) - 1)
    assert np.mean(sure) > 0.9
    assert np.array_equal(corrected[sure], pixels[at[..., 1], at[..., 0]][sure])


@pytest.mark.parametrize(
    ("border", "value"), [("black", 0), ("white", 255), ("edge", 90), ("transparent", 0)]
)
def test_borders(border: str, value: int) -> None:
    pixels = np.full((100, 200, 3), 90, np.uint8)
    moved = correct_array(pixels, _shift(-30, 0, (200, 100)), border=border)
    assert np.all(moved[:, :30, :3] == value)
    assert np.all(moved[:, 30:, :3] == 90)  # no dark fringe from the interpolation
    if border == "transparent":
        assert moved.shape[2] == 4
        assert np.all(moved[:, :30, 3] == 0)
        assert np.all(moved[:, 30:, 3] == 255)


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_grey_becomes_transparent_too(kind: Any) -> None:
    full = np.iinfo(kind).max
    moved = correct_array(
        np.full((50, 60), full // 3, kind), _shift(-20, 0, (60, 50)), border="transparent"
    )
    assert np.all(moved[:, 20:, 0] == full // 3)
    assert np.all(moved[:, 20:, -1] == full)
    assert np.all(moved[:, :20] == 0)


@pytest.mark.parametrize("interpolation", ["linear", "cubic", "lanczos"])
@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_hidden_colours_do_not_bleed(interpolation: Interpolation, kind: Any) -> None:
    full = np.iinfo(kind).max
    pixels = np.zeros((64, 64, 4), kind)
    pixels[..., 2] = full  # hidden red on the left, opaque green on the right
    pixels[:, 32:] = (0, full, 0, full)
    moved: NDArray[Any] = correct_array(
        pixels, _shift(0.37, 0.21, (64, 64)), interpolation=interpolation, border="edge"
    )
    seen = moved[..., 3] > full * 0.02
    assert np.all(moved[seen][:, 2] <= full * 0.01)
    assert np.all(moved[seen][:, 1] >= full * 0.99)


def test_large_pictures_pass_the_limits_of_opencv() -> None:
    pixels = np.arange(40000, dtype=np.uint16)[None, :].repeat(8, axis=0)
    moved = correct_array(pixels, _shift(100, 0, (40000, 8)), border="edge")
    assert np.array_equal(moved[:, :-100], pixels[:, 100:])


@pytest.mark.parametrize("size", [(1, 1), (1, 50), (3, 2)])
def test_tiny_pictures(size: tuple[int, int]) -> None:
    pixels = np.full((size[1], size[0], 3), 7, np.uint8)
    assert np.all(correct_array(pixels, _correction(size), border="edge") == 7)


def test_a_calibration_is_scaled_to_the_array() -> None:
    import plumbline

    lens = plumbline.Lens(
        plumbline.get_model("ptlens"), plumbline.Frame(1802, 1200), barrel(SIZE).all_coefficients
    )
    ideal = grid_inside(SIZE)
    painted = np.rint(dots(SIZE, barrel(SIZE).distort(ideal)) * 60000).astype(np.uint16)
    found = centroids(correct_array(painted, lens), ideal)
    assert np.max(np.hypot(*(found - ideal).T)) < 0.05


def test_one_channel_stays_one_channel_and_gets_alpha() -> None:
    grey = texture(SIZE)[..., :1]
    plain = correct_array(grey, _correction())
    assert plain.shape == grey.shape
    clear = correct_array(grey, _correction(), border="transparent")
    assert clear.shape == (*grey.shape[:2], 2)


def test_what_is_no_picture_is_refused() -> None:
    made = _correction()
    byte = np.uint8
    for wrong in (np.zeros((5, 5)), *(np.zeros(n, byte) for n in (5, (0, 5), (5, 5, 5)))):
        with pytest.raises(OptionError, match="not hold a picture"):
            correct_array(wrong, made)
    with pytest.raises(OptionError, match="another size"):
        correct_array(texture((300, 200)), made)
    for setting in ("interpolation", "border", "scale"):
        with pytest.raises(OptionError, match=setting):
            correct_array(texture(SIZE), made, **{setting: "best"})

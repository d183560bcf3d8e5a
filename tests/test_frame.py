"""Where pixels are."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, strategies as st

from plumbline.frame import Frame


def test_pixels_count_from_the_centre_of_the_top_left_one() -> None:
    assert Frame(4, 3).centre_px == (1.5, 1.0)
    assert Frame(1, 1).centre_px == (0.0, 0.0)
    assert Frame(5, 7).corners_px().tolist() == [[0, 0], [4, 0], [4, 6], [0, 6]]


@pytest.mark.parametrize("size", [(3000, 2000), (2000, 3000), (2000, 2000)])
def test_radius_is_half_the_shorter_side_whichever_way_up(size: tuple[int, int]) -> None:
    assert Frame(*size).radius_px == 1000.0


def test_corner_radius_reaches_the_corner_of_the_area() -> None:
    assert Frame(4000, 3000).corner_radius == pytest.approx(5 / 3, rel=1e-15)
    assert Frame(3000, 4000).corner_radius == pytest.approx(5 / 3, rel=1e-15)
    assert Frame(700, 700).corner_radius == pytest.approx(np.sqrt(2), rel=1e-15)


def test_normalised_coordinates_by_hand() -> None:
    points = Frame(400, 200).normalise([[199.5, 99.5], [299.5, 99.5], [199.5, 49.5], [0.0, 0.0]])
    np.testing.assert_allclose(
        points, [[0, 0], [1, 0], [0, -0.5], [-1.995, -0.995]], rtol=0, atol=1e-15
    )
    np.testing.assert_allclose(
        Frame(400, 200).normalise([449.5, 99.5], 500.0), [0.5, 0.0], rtol=0, atol=1e-15
    )


def test_wide_pixels_are_stretched_to_square_ones() -> None:
    frame = Frame(720, 576, 1.5)
    assert frame.size == (720, 576)
    assert frame.square_size == (1080.0, 576.0)
    assert frame.radius_px == 288.0
    assert frame.centre_px == (359.5, 287.5)
    assert frame.corner_radius == pytest.approx(np.hypot(1080, 576) / 576, rel=1e-15)
    np.testing.assert_allclose(
        frame.normalise([359.5 + 192.0, 287.5 + 288.0]), [1.0, 1.0], rtol=0, atol=1e-15
    )
    # Narrow pixels can make the row the shorter side.
    assert Frame(720, 576, 0.5).radius_px == 180.0


@given(
    width=st.integers(1, 20_000),
    height=st.integers(1, 20_000),
    aspect=st.floats(0.3, 3.0),
    unit=st.none() | st.floats(1.0, 1e5),
    place=st.tuples(st.floats(-0.5, 1.5), st.floats(-0.5, 1.5)),
)
def test_to_pixels_undoes_normalise(
    width: int, height: int, aspect: float, unit: float | None, place: tuple[float, float]
) -> None:
    frame = Frame(width, height, aspect)
    point = np.array(place) * (width, height)
    back = frame.to_pixels(frame.normalise(point, unit), unit)
    np.testing.assert_allclose(back, point, rtol=0, atol=1e-11)


@pytest.mark.parametrize("shape", [(2,), (5, 2), (3, 4, 2), (0, 2)])
def test_shapes_are_kept(shape: tuple[int, ...]) -> None:
    points = np.ones(shape)
    frame = Frame(30, 20)
    assert frame.normalise(points).shape == shape
    assert frame.to_pixels(points).shape == shape
    assert frame.contains(points).shape == shape[:-1]


def test_points_on_the_edge_of_the_outermost_pixels_count() -> None:
    frame = Frame(30, 20)
    edge = [[-0.5, -0.5], [29.5, 19.5], [-0.5, 19.5], [12.0, 3.0]]
    outside = [[-0.51, 0.0], [29.51, 0.0], [0.0, -0.51], [0.0, 19.51]]
    nowhere = [[np.nan, 1.0], [1.0, np.nan], [np.inf, 1.0], [1.0, -np.inf]]
    assert frame.contains(edge).tolist() == [True] * 4
    assert frame.contains(outside).tolist() == [False] * 4
    assert frame.contains(nowhere).tolist() == [False] * 4

"""Stored values to linear light."""

from __future__ import annotations

import numpy as np
import pytest

from plumbline.edges.light import linear_channel, linear_light
from tests.edges.drawn import stored


@pytest.mark.parametrize("most", [255, 65535])
def test_known_values_of_the_srgb_curve(most: int) -> None:
    values = np.array([[0, most // 2, most]], dtype=np.uint8 if most == 255 else np.uint16)
    # IEC 61966-2-1: 0.5 is 0.2140 in linear light, and 127/255 is 0.2122.
    expected = {255: 0.2122, 65535: 0.2140}[most]
    np.testing.assert_allclose(linear_light(values), [[0, expected, 1]], atol=1e-4)


def test_luminance_weighs_the_colours_as_bt_709_does() -> None:
    for place, weight in enumerate((0.0722, 0.7152, 0.2126)):  # blue, green, red
        pixels = np.zeros((2, 3, 3), np.uint8)
        pixels[..., place] = 255
        np.testing.assert_allclose(linear_light(pixels), weight, rtol=1e-5)


def test_it_undoes_what_a_camera_stores() -> None:
    light = np.linspace(0, 1, 500, dtype=np.float32)[None]
    np.testing.assert_allclose(linear_light(stored(light)), light, atol=0.005)


def test_channels_by_name_and_alpha_does_not_count() -> None:
    pixels = np.dstack([np.full((2, 2), value, np.uint8) for value in (0, 255, 128, 7)])
    assert linear_channel(pixels, "green").max() == 1
    assert linear_channel(pixels, "blue").max() == 0
    np.testing.assert_array_equal(linear_light(pixels), linear_light(pixels[..., :3]))

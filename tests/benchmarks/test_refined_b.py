"""The benchmark of a refined b runs, in small, and the errors stay below those asked for."""

from __future__ import annotations

import pytest

from tests.benchmarks.refined_b import SCENES, measured


@pytest.mark.parametrize(
    ("height", "points", "most"),
    [
        ("1.6 m", 5, 0.0028),
        ("1.6 m", 6, 0.0019),
        ("1.6 m", 12, 0.0011),
        ("5 m", 5, 0.0040),
        ("5 m", 6, 0.0027),
        ("5 m", 12, 0.0009),
    ],
)
def test_points_spread_over_the_photo_tell_b(height: str, points: int, most: float) -> None:
    row = measured(SCENES[height], points, 5)
    assert row.stated <= most
    assert row.rms < 3 * row.stated

"""The benchmark of coverage runs, and a tiny one already finds ellipses that hold."""

from __future__ import annotations

from tests.benchmarks.ground_coverage import measure
from tests.benchmarks.road_scenes import groups


def test_a_tiny_run() -> None:
    group = next(each for each in groups() if each.name == "5 m, small, 6, lane edges")
    row = measure(group, 30, control=True)
    assert row.fails == 0
    assert row.ellipse > 85
    assert 0.6 < row.over_bound < 1.5
    assert row.unweighted < 80, "without unevenness in the weights the ellipses are too small"

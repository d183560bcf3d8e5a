"""The benchmark of the page runs: one line, on the sample at its own size."""

from __future__ import annotations

from tests.benchmarks.pick_latency import measure


def test_it_measures_what_it_says() -> None:
    times = measure(2.0, lines=2)
    assert times.opened > 0
    assert len(times.clicks) >= 1
    assert min(times.clicks) > 1
    assert len(times.tiles) == 40

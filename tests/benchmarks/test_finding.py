"""The benchmark of finding runs."""

from __future__ import annotations

from tests.benchmarks.finding import row, shown, summed_up


def test_one_small_photograph() -> None:
    one = row(1, (1000, 667))
    assert one.vouched
    assert one.error_px < 0.2
    assert str(one.edges) in shown(one)
    assert "1 of 1 vouched for" in summed_up([one])[0]

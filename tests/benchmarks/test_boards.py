"""The benchmark of boards runs, in small."""

from __future__ import annotations

from tests.benchmarks.boards import rendered


def test_one_photograph() -> None:
    (row,) = rendered((800, 600), ["kit0"], peers=False)
    assert row.labels_true
    assert row.share == 1.0

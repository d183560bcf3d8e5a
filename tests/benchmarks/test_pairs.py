"""The benchmark of pairs runs, in small."""

from __future__ import annotations

from tests.benchmarks.pairs import covered


def test_a_few_fits() -> None:
    assert covered("kit", 4) > 0.5

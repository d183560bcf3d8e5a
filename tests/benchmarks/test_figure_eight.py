"""Errors outside of the quadrilateral shrink as theory predicts when the lens is corrected."""

from __future__ import annotations

import pytest

from tests.benchmarks.figure_eight import Row, rows


@pytest.mark.parametrize("row", rows(), ids=lambda row: row.height)
def test_the_factor_is_that_of_theory(row: Row) -> None:
    assert row.uncorrected == pytest.approx(row.predicted, rel=1e-2)
    assert row.uncorrected > 0.8
    # b is off by a twentieth of itself, and so is what it does
    assert row.predicted / row.nearly == pytest.approx(20, rel=0.15)
    assert row.corrected < 1e-3

"""Both programs recover a lens from the same simulated picks."""

from __future__ import annotations

import numpy as np
import pytest

from tests.benchmarks.against_hugin import GROUPS, Row, pooled, rms, row
from tests.peers.tools import program


def test_hugin_and_plumbline_find_the_lens() -> None:
    program("autooptimiser")
    one = row(GROUPS[0], 3)
    for errors in (one.ours_px, one.theirs_px):
        assert len(errors) == 3
        assert 0 < rms(errors) < 4 * one.bound_px
    assert one.ours_px != one.theirs_px
    assert all(one.sane)


def test_the_pooled_ratio_weighs_groups_alike_and_leaves_wrong_minima_out() -> None:
    rows = [
        Row("large", 5.0, 10.0, (10.0, 10.0), (20.0, 20.0)),
        Row("small", 5.0, 1.0, (1.0, 1.0), (2.0, np.inf)),
    ]
    assert pooled(rows) == pytest.approx(0.5)
    assert rows[1].sane == [True, False]

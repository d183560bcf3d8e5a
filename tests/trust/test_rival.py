"""When too little agrees to tell a lens."""

from __future__ import annotations

import pytest

from plumbline.trust.rival import agreement_check
from plumbline.trust.suspect import Suspect


def accused(n: int, *, left_out: bool = True) -> Suspect:
    return Suspect(0, tuple(range(n)), "stray", 9.0, 9.0, left_out, "")


@pytest.mark.parametrize(("n", "fails"), [(0, False), (5, False), (6, True)])
def test_fewer_than_half_of_the_picks_tell_no_lens(n: int, fails: bool) -> None:
    found = agreement_check(None, (accused(n),) if n else (), 10, 1.0, 500.0)
    assert (found is not None) == fails
    assert found is None or "only 4 of 10 picks" in found.finding


def test_picks_that_are_only_odd_count_as_agreeing() -> None:
    assert agreement_check(None, (accused(9, left_out=False),), 10, 1.0, 500.0) is None


def test_a_rival_is_told_with_its_distance() -> None:
    found = agreement_check(12.3, (), 10, 1.0, 500.0)
    assert found is not None
    assert not found.passed
    assert "another lens, up to 12 px from this one" in found.finding


@pytest.mark.parametrize(("sigma_px", "fails"), [(5.0, False), (7.0, False), (9.0, True)])
def test_more_scatter_than_careless_picks_have_is_told(sigma_px: float, fails: bool) -> None:
    """5 px is 1/200 of the shorter side, which is still taken for clean."""
    assert (agreement_check(None, (), 10, sigma_px, 500.0) is not None) == fails

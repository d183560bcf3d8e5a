"""Which picks of a line agree: seen on made lines under a lens that does nothing."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, strategies as st

from plumbline.fit.robust.agreement import Agreed, agree, alike, credit, evidence
from plumbline.fit.robust.rivals import contested, excuses
from plumbline.fit.robust.screening import Picks
from plumbline.geometry.derivatives import Ideal
from plumbline.geometry.lines import line_numbers
from tests.truth import Array

SIGMA_PX, WRONG_PX, REACH = 0.5, 100.0, 4.0


def seen(lines: list[Array]) -> Picks:
    """Picks under a lens that does nothing."""
    points = np.concatenate(lines)
    sizes = np.array([len(line) for line in lines])
    still = np.broadcast_to(np.eye(2), (len(points), 2, 2))
    one = np.zeros(len(points), dtype=np.int64)
    return Picks(Ideal(points, still), sizes, line_numbers(sizes), one, np.array([1]), np.zeros(1))


def judged(lines: list[Array], excuse: Array | float = 0.0) -> Agreed:
    return agree(seen(lines), SIGMA_PX, WRONG_PX, REACH, excuse)


def edge(n: int = 8, height_px: float = 0.0, seed: int = 0) -> Array:
    """Picks along a horizontal edge."""
    wobble = 0.3 * np.random.default_rng(seed).standard_normal(n)
    return np.stack((np.linspace(-300.0, 300.0, n), height_px + wobble), axis=1)


def test_good_picks_are_all_believed() -> None:
    made = judged([edge(), edge(12, 80.0, 1)])
    assert made.kept.all()
    assert not made.wrong.any()


@given(
    st.integers(0, 7),
    st.floats(8.0, 100.0),
    st.booleans(),
    st.floats(0.0, np.pi),
    st.tuples(st.floats(-2000, 2000), st.floats(-2000, 2000)),
)
def test_a_stray_is_found_however_the_photo_is_turned(
    which: int, far_px: float, down: bool, turn: float, shift: tuple[float, float]
) -> None:
    line = edge()
    line[which, 1] += far_px if down else -far_px
    cosine, sine = np.cos(turn), np.sin(turn)
    turned = line @ np.array([[cosine, sine], [-sine, cosine]]) + np.array(shift)
    for points in (line, turned):
        made = judged([points])
        assert np.flatnonzero(made.wrong).tolist() == [which]
        assert np.flatnonzero(~made.kept).tolist() == [which]
    assert abs(abs(made.distance_px[which]) - far_px) < 2


def test_where_picks_may_mean_either_of_two_lines_nobody_is_accused() -> None:
    crossing = np.array([[-300.0, -60], [-150, -30], [150, -30], [300, -60], [0, 0]])
    made = judged([crossing])
    assert not made.wrong.any()
    assert not made.kept[[0, 1, 2, 3]].any()


def test_picks_beyond_the_fold_agree_with_nothing() -> None:
    line = edge()
    line[3] = np.nan
    made = judged([line])
    assert not made.kept[3]
    assert np.count_nonzero(made.kept) == 7


def test_credit_is_the_ratio_of_the_two_densities() -> None:
    """A quarter of the picks is reckoned wrong: uniform over the band against a Gaussian's peak."""
    peak = 1 / (np.sqrt(2 * np.pi) * SIGMA_PX)
    assert credit(SIGMA_PX, WRONG_PX) == pytest.approx(np.log(3 * peak * WRONG_PX))


def test_straight_lines_are_likelier_than_bent_ones() -> None:
    straight = edge(9)
    bent = straight + np.stack((np.zeros(9), (straight[:, 0] / 60) ** 2), axis=1)
    both = np.stack((straight, bent))
    found = evidence(both, np.ones((2, 9)), list(alike(np.array([9]))), SIGMA_PX, WRONG_PX)
    assert found[0] > found[1] + 5


def test_a_pick_on_a_better_line_is_excused() -> None:
    short, long = edge(6), edge(12, 40.0, 1)
    short[2, 1] = 40.0
    picks = seen([short, long])
    made = agree(picks, SIGMA_PX, WRONG_PX, REACH)
    told = excuses(picks, made, np.zeros(2, dtype=np.int64), SIGMA_PX, WRONG_PX)
    assert np.argmax(told) == 2
    assert told[2] > 1
    assert np.max(np.delete(told, 2)) < 1e-6
    apart = excuses(picks, made, np.array([0, 1]), SIGMA_PX, WRONG_PX)
    assert np.max(apart) < 1e-6, "lines of other photos are no rivals"


def test_of_one_edge_picked_twice_both_lines_are_contested() -> None:
    first, again, other = edge(8), edge(8, 0.0, 1), edge(8, 90.0, 2)
    first[7, 1] += 30.0
    picks = seen([first, again, other])
    made = agree(picks, SIGMA_PX, WRONG_PX, REACH)
    photos = np.zeros(3, dtype=np.int64)
    assert contested(picks, made, photos, REACH * SIGMA_PX).tolist() == [True, True, False]
    assert not contested(picks, made, np.arange(3), REACH * SIGMA_PX).any()


def test_a_line_of_very_many_picks_is_judged_in_little_memory() -> None:
    """Pairs of some of its picks propose lines; a hundred million pairs would not fit."""
    line = edge(20_000)
    line[7_000, 1] += 40.0
    made = judged([line])
    assert np.flatnonzero(made.wrong).tolist() == [7_000]
    assert np.count_nonzero(made.kept) > 19_900

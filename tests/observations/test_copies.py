"""Copies count once: what is left is what there is without them."""

from __future__ import annotations

import random
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st

import plumbline
from plumbline.observations import Line, Observations, Photo
from plumbline.observations.facts import LensFacts

SIZE = (800, 600)
RNG = np.random.default_rng(5)
LINES = [
    np.column_stack([np.linspace(20, 780, 9), np.linspace(y, y + 8, 9) + RNG.normal(0, 0.3, 9)])
    for y in (20.0, 180.0, 400.0, 560.0)
]


def points(observations: Observations) -> list[list[list[float]]]:
    return sorted(sorted(line.points_px.tolist()) for line in observations.lines)


def of(*lines: np.ndarray) -> Observations:
    return Observations.from_arrays(lines, SIZE)


ONCE = points(of(*LINES))


def test_no_copy_no_word() -> None:
    observations = of(*LINES)
    assert observations.notes == ()
    assert observations.counted_once() is observations


@given(
    st.lists(st.sampled_from(range(4)), max_size=12),
    st.randoms(use_true_random=False),
)
def test_whole_copies_are_named_and_left_out(again: list[int], rng: random.Random) -> None:
    every = [*range(4), *again]
    rng.shuffle(every)
    shuffled = [LINES[i][rng.sample(range(9), 9)] for i in every]
    observations = of(*shuffled)
    assert points(observations) == ONCE
    assert len(observations.notes) == min(len(again), 1)
    told = " ".join(observations.notes)
    firsts = {every.index(i) for i in range(4)}
    for place in set(range(len(every))) - firsts:
        assert str(place + 1) in re.findall(r"\d+", told)


@pytest.mark.parametrize("part_first", [True, False])
@pytest.mark.parametrize("taken", [slice(0, 4), slice(3, 9), slice(1, 9, 2), slice(0, 9, 4)])
def test_a_part_of_a_longer_line_is_a_copy(taken: slice, part_first: bool) -> None:
    part = LINES[1][taken]
    observations = of(*([part, *LINES] if part_first else [*LINES, part]))
    assert points(observations) == ONCE
    assert len(observations.notes) == 1


def test_lines_that_overlap_share_their_picks_once() -> None:
    observations = of(LINES[0][:6], LINES[0][4:], *LINES[1:])
    assert observations.n_points == 9 * 4
    assert observations.notes == (
        "line 2 repeats 2 picks of line 1: what two lines share counts once",
    )
    observations = of(LINES[0][:6], LINES[0][2:8], *LINES[1:])
    assert "line 2 repeats line 1" in observations.notes[0]
    assert observations.n_points == 9 * 3 + 6


def test_a_grid_is_no_copy() -> None:
    y, x = np.mgrid[50:550:6j, 60:740:8j]
    grid = np.stack([x, y], axis=-1)
    rows, columns = list(grid), list(grid.transpose(1, 0, 2))
    diagonals = [grid[range(6), range(k, k + 6)] for k in range(3)]
    observations = of(*rows, *columns, *diagonals)
    assert observations.notes == ()
    assert len(observations.lines) == 6 + 8 + 3
    twice = of(*rows, *columns, *diagonals, *rows, *columns)
    assert points(twice) == points(observations)


def test_a_copy_in_another_photo_of_the_lens() -> None:
    lines = tuple(Line(xy, 0, f"l{i}") for i, xy in enumerate(LINES))
    moved = Line(LINES[0] + 3, 1, "own")
    partly = Line(np.concatenate([LINES[1][:2], LINES[2][:2] + 0.25]), 1, "partly")
    copied = Line(LINES[3][::-1], 1, "copied")
    photos = (Photo(SIZE, "a.jpg"), Photo(SIZE, "b.jpg"))
    both = Observations(photos, (*lines, moved, partly, copied)).counted_once()
    assert [line.label for line in both.lines] == ["l0", "l1", "l2", "l3", "own", "partly"]
    assert both.notes == ("line copied of b.jpg repeats line l3 of a.jpg: the copy counts once",)
    other_lens = replace(
        both, photos=(photos[0], replace(photos[1], lens=1)), lenses=(LensFacts(), LensFacts())
    )
    other_lens = replace(other_lens, lines=(*lines, copied), notes=())
    assert other_lens.counted_once() is other_lens
    other_size = replace(other_lens, photos=(photos[0], Photo((900, 700), "b.jpg")))
    assert other_size.counted_once() is other_size


def test_rows_go_with_their_points() -> None:
    rows = np.arange(9)
    first = Line(LINES[0][:6], 0, "a", rows[:6])
    second = Line(LINES[0][4:], 0, "b", rows[4:])
    left = Observations((Photo(SIZE),), (first, second)).counted_once().lines[1]
    assert left.rows is not None
    assert left.rows.tolist() == [6, 7, 8]
    assert np.array_equal(left.points_px, LINES[0][6:])


def test_many_lines_through_one_point_end_soon() -> None:
    ends = RNG.uniform(0, 599, (5000, 2))
    pencil = [np.stack([[400.0, 300.0], end, end / 2 + 150.1]) for end in ends]
    assert len(of(*pencil).lines) == 5000


def test_the_fit_does_not_see_copies() -> None:
    bent = [xy + np.column_stack([0 * xy[:, 0], ((xy[:, 0] - 400) / 400) ** 2 * 3]) for xy in LINES]
    once = plumbline.calibrate(of(*bent), model="poly3")
    copied = [*bent, *(xy[::-1] for xy in bent), bent[2][2:8], *bent]
    again = plumbline.calibrate(of(*copied), model="poly3")
    assert again.standard_errors["k1"] == pytest.approx(once.standard_errors["k1"], rel=1e-9)
    assert again.dof == once.dof
    assert again.quoted_displacement is not None
    assert once.quoted_displacement is not None
    assert again.quoted_displacement.worst_px == pytest.approx(
        once.quoted_displacement.worst_px, rel=1e-6
    )

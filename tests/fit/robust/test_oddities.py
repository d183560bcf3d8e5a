"""Lines that bend by themselves and places picked twice, among many that are neither."""

from __future__ import annotations

import numpy as np
import pytest

from plumbline.fit.robust.oddities import bends, twins

SIGMA_PX = 0.5


def lines(n_lines: int, n: int, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    line = np.repeat(np.arange(n_lines), n)
    along = np.sort(rng.uniform(-900, 900, (n_lines, n)), axis=1).ravel()
    return line, along, rng.normal(0, SIGMA_PX, n_lines * n)


def test_a_parabola_is_found_with_its_size_and_straight_lines_are_not() -> None:
    line, along, away = lines(400, 10, 1)
    true = np.where(line % 4 == 0, 8.0 * (along / 900) ** 2, 0.0)
    found = bends(line, along, away + true, np.full(400, SIGMA_PX))
    curved = np.arange(400) % 4 == 0
    assert np.mean(found.bent[curved]) > 0.9
    assert np.mean(found.bent[~curved]) < 0.005
    # From the chord to the middle: what 8 px (t / 900)² is over half the line's length.
    first, last = along.reshape(400, 10)[:, 0], along.reshape(400, 10)[:, -1]
    want = 8.0 * ((last - first) / 2 / 900) ** 2
    assert np.median(found.bend_px[curved] / want[curved]) == pytest.approx(1, abs=0.05)


def test_a_stray_is_no_bend_and_infinite_distances_do_not_count() -> None:
    line, along, away = lines(4, 12, 2)
    away[5] += 30
    away[12 + 3] = np.inf
    away += np.where(line == 1, 5.0 * (along / 900) ** 2, 0.0)
    found = bends(line, along, away, np.full(4, SIGMA_PX))
    assert found.bent.tolist() == [False, True, False, False]


def test_few_picks_never_bend() -> None:
    line, along, away = lines(50, 4, 3)
    assert not bends(line, along, away + 9 * (along / 900) ** 2, np.full(50, SIGMA_PX)).bent.any()


def test_twins_are_close_for_their_line() -> None:
    line = np.repeat([0, 1, 2], 5)
    twice = [0, 100, 200, 200.6, 300]
    dense = [0.0, 0.8, 1.6, 2.4, 3.2]
    apart = [50, 200.5, 0, 90, 51.5]  # 1.5 px apart, and not in order
    along = np.array([*twice, *dense, *apart])
    across = np.zeros(15)
    assert twins(line, along, across).tolist() == [[2, 3]]
    across[3] = 0.9  # 1.08 px apart by both
    assert twins(line, along, across).tolist() == []
    across[2:4] = np.inf
    assert twins(line, along, across).tolist() == []

"""Lines along one edge: found, told, and left out together."""

from __future__ import annotations

import numpy as np

from plumbline import Observations, calibrate
from tests.benchmarks.groups import FRAMES, GRID, lens
from tests.benchmarks.simulated import Group


def lines_of(group: Group, purpose: str = "noise") -> list[np.ndarray]:
    return group.by_line(group.picks_px(1, purpose)[0])


def test_an_edge_picked_again_is_one_edge_and_is_told() -> None:
    group = Group("S120", lens("S120 5.2 mm"), GRID, 0.3)
    once, again = lines_of(group), lines_of(group, "again")
    obs = Observations.from_arrays([*once, again[3], again[5][:8]], group.lens.size)
    made = calibrate(obs)
    assert made.trust.edges.tolist() == [*range(16), 3, 5]
    assert made.jackknife is not None
    assert made.jackknife.dof == 15
    (told,) = [check for check in made.checks if check.name == "edges"]
    assert "lines 4 and 17, 6 and 18;" in told.finding
    assert told.doubtful


def test_every_edge_picked_twice_is_left_out_twice() -> None:
    """The jackknife of twice the edges is that of pairs, refitted: not √2 smaller."""
    group = Group("S120", lens("S120 5.2 mm"), GRID, 0.3)
    obs = Observations.from_arrays([*lines_of(group), *lines_of(group, "again")], group.lens.size)
    made = calibrate(obs)
    assert made.jackknife is not None
    keep = [n for n in range(32) if n % 16 != 2]
    fewer = calibrate(
        Observations.from_arrays([obs.lines[n].points_px for n in keep], group.lens.size)
    )
    shift = made.jackknife.shifts[2]
    change = [fewer.coefficients[n] - made.coefficients[n] for n in made.free]
    np.testing.assert_allclose(shift, change, atol=0.25 * np.max(np.abs(change)))


def test_both_edges_of_a_window_frame_are_two() -> None:
    group = Group("S120", lens("S120 5.2 mm"), FRAMES, 0.5)
    made = calibrate(Observations.from_arrays(lines_of(group), group.lens.size))
    assert made.trust.edges.tolist() == list(range(16))
    assert not [check for check in made.checks if check.name == "edges"]

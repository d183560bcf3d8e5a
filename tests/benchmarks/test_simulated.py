"""The simulated photos: straight lines, in the photo, the same every time."""

from __future__ import annotations

import numpy as np
import pytest

from tests.benchmarks.groups import ALIKE, FRAMES, GOPRO, PTLENS, UNEVEN, UNLIKE, lens
from tests.benchmarks.lensfun_recovery import database, read_database
from tests.benchmarks.simulated import Group
from tests.benchmarks.spoiling import neighbour

GROUPS = (*ALIKE, *UNLIKE)


def test_there_are_enough_groups_and_no_two_are_alike() -> None:
    assert len(ALIKE) >= 50
    assert len({group.name for group in GROUPS}) == len(GROUPS)
    assert all(group.true_family for group in ALIKE)
    assert not any(group.true_family for group in UNLIKE)


def test_the_lenses_are_those_of_the_database() -> None:
    folder = database()
    if folder is None:
        pytest.skip("LensFun's database is not installed (Debian: liblensfun-data-v1)")
    stored = {entry.abc for entry in read_database(folder)}
    assert {abc for abc, _ in PTLENS.values()} <= stored
    assert tuple(GOPRO.all_coefficients[name] for name in "abc") in stored


@pytest.mark.parametrize("group", GROUPS, ids=lambda group: group.name)
def test_true_lines_are_straight_under_the_truth_and_bent_in_the_photo(group: Group) -> None:
    def bend(points: np.ndarray) -> float:
        return float(np.max(np.abs((points - points.mean(axis=0)) @ _normal(points))))

    ideal = group.by_line(group.lens.undistort(group.true_px))
    assert max(bend(line) for line in ideal) < 1e-7
    assert max(bend(line) for line in group.by_line(group.true_px)) > 2
    picks = group.picks_px(100)
    assert np.all((picks >= -0.5) & (picks <= np.array(group.lens.size) - 0.5))


def _normal(points: np.ndarray) -> np.ndarray:
    return np.linalg.svd(points - points.mean(axis=0))[2][1]


@pytest.mark.parametrize("group", ALIKE[:3], ids=lambda group: group.name)
def test_a_trial_is_the_same_however_many_are_drawn(group: Group) -> None:
    many, few = group.picks_px(20), group.picks_px(7)
    assert np.array_equal(many[:7], few)
    assert not np.array_equal(many[0], many[1])
    again = Group(group.lens_name, group.lens, group.layout, group.noise_px)
    assert np.array_equal(again.picks_px(7), few)


def test_the_noise_is_what_it_says() -> None:
    group = ALIKE[0]
    noise = (group.picks_px(500) - group.true_px) / group.noise_px
    n = noise.size
    assert abs(float(noise.mean())) < 5 / np.sqrt(n)
    assert abs(float(noise.var()) - 1) < 5 * np.sqrt(2 / n)
    assert abs(float(np.mean(noise[..., 0] * noise[..., 1]))) < 5 / np.sqrt(n / 2)


def test_uneven_lines_have_few_and_many_picks() -> None:
    sizes = [len(line.places_px) for g in ALIKE if g.layout == UNEVEN for line in g.lines]
    assert min(sizes) == 3
    assert max(sizes) == 20


def test_the_neighbour_of_a_frame_s_edge_is_its_other_edge() -> None:
    group = Group("Sigma 14 mm", lens("Sigma 14 mm"), FRAMES, 0.5)
    beside = [neighbour(group, line) for line in range(16)]
    assert beside == [line + 2 if line % 4 < 2 else line - 2 for line in range(16)]


def test_normals_are_across_the_curves() -> None:
    for group in (ALIKE[0], ALIKE[30]):
        for line, normals in zip(group.lines, group.by_line(group.across), strict=True):
            near = line._replace(places_px=line.places_px + 1e-3).ideal_px
            moved = group.lens.distort(near) - group.lens.distort(line.ideal_px)
            assert np.max(np.abs(np.sum(moved * normals, axis=1))) < 1e-6
            assert np.allclose(np.hypot(*normals.T), 1)

"""The spoilers spoil what they say, and the driver tells a good robust fit from a bad one."""

from __future__ import annotations

import numpy as np
import pytest

import plumbline
from plumbline.errors import DegenerateLinesError
from tests.benchmarks.groups import ALIKE
from tests.benchmarks.simulated import Group
from tests.benchmarks.spoiled import GROUPS, Row, compare, plain, pooled
from tests.benchmarks.spoiling import SPOILERS, across_px, bent, misplaced, moved, neighbour

GROUP = GROUPS[0]
every_group = pytest.mark.parametrize("group", GROUPS, ids=lambda group: group.name)


@every_group
@pytest.mark.parametrize("share", [0.1, 0.25])
@pytest.mark.parametrize("spoiler", SPOILERS)
def test_exactly_the_share_is_spoiled(group: Group, spoiler: str, share: float) -> None:
    picks = group.picks_px(1)[0]
    points, bad = SPOILERS[spoiler](group, picks, share, group.rng("test", 0))
    assert np.count_nonzero(bad) == round(share * group.n_points)
    assert np.array_equal(points[~bad], picks[~bad])
    assert np.all(points[bad] != picks[bad])
    assert np.all((points >= 0) & (points <= np.array(group.lens.size) - 1.0))


@every_group
def test_strays_are_moved_by_8_to_100_px(group: Group) -> None:
    picks = group.picks_px(1)[0]
    points, bad = moved(group, picks, 0.25, group.rng("test", 1))
    far = np.hypot(*(points - picks)[bad].T)
    assert np.all((far >= 8) & (far <= 100))
    assert np.ptp(far) > 40
    directions = np.sign((points - picks)[bad])
    assert len(np.unique(directions, axis=0)) == 4


@every_group
def test_misplaced_picks_lie_on_the_line_beside(group: Group) -> None:
    picks = group.picks_px(1)[0]
    points, bad = misplaced(group, picks, 0.25, group.rng("test", 2))
    beside = np.array([neighbour(group, int(line)) for line in group.line_of])
    other = np.array([group.lines[line].origin_px for line in beside])
    along = np.array([group.lines[line].along for line in beside])
    off = group.lens.undistort(points) - other
    distance = np.abs(off[:, 0] * along[:, 1] - off[:, 1] * along[:, 0])
    assert np.max(distance[bad]) < 8 * group.noise_px
    assert np.median(distance[~bad]) > 10 * group.noise_px


def test_distances_across_are_those_of_the_photo() -> None:
    for group in (GROUP, ALIKE[30]):
        assert np.max(across_px(group, group.true_px)) < 1e-6
        shifted = group.true_px + 2.0 * group.across
        assert across_px(group, shifted) == pytest.approx(np.full(group.n_points, 2.0), rel=0.02)
    many = across_px(GROUP, np.stack((GROUP.true_px, GROUP.true_px + 2.0 * GROUP.across)))
    assert many.shape == (2, GROUP.n_points)


def test_every_edge_is_bent_by_half_a_pixel_and_smoothly() -> None:
    group = next(g for g in ALIKE if g.layout.name == "dense")
    clean = np.repeat(group.true_px[None], 8, axis=0)
    bends = bent(group, clean) - clean
    assert np.max(np.abs(np.sum(bends * group.across[:, ::-1] * [1, -1], axis=-1))) < 1e-12
    across = np.sum(bends * group.across, axis=-1)
    for trial in across:
        for line in group.by_line(trial):
            assert np.max(np.abs(line)) == pytest.approx(0.5, abs=0.01)
            assert np.max(np.abs(np.diff(line))) < 0.1
    assert not np.allclose(across[0], across[1])


@pytest.mark.parametrize("spoiler", SPOILERS)
def test_one_that_knows_the_truth_does_as_well_as_the_informed_fit(spoiler: str) -> None:
    def knowing(
        picked: plumbline.Observations,
    ) -> tuple[plumbline.Calibration, set[tuple[int, int]]]:
        points = np.concatenate([line.points_px for line in picked.lines])
        far = np.split(np.hypot(*(points - GROUP.true_px).T) > 5, GROUP.ends)
        kept = [line.points_px[~bad] for line, bad in zip(picked.lines, far, strict=True)]
        kept = [points for points in kept if len(points) >= 3]
        fit = plumbline.calibrate(plumbline.Observations.from_arrays(kept, GROUP.lens.size))
        return fit, {(i, int(j)) for i, bad in enumerate(far) for j in np.flatnonzero(bad)}

    one = compare(GROUP, spoiler, 0.1, 6, knowing)
    assert one.met
    assert one.ratio == pytest.approx(1, rel=1e-9)
    assert one.named == 1
    assert one.good_named == 0


def test_the_plain_fit_does_not_meet_the_targets() -> None:
    one = compare(GROUPS[1], "moved", 0.1, 4, plain)
    assert not one.met
    assert one.ratio > 3
    assert one.named == 0


def test_a_fit_that_raises_is_kept_in_view() -> None:
    def hopeless(
        picked: plumbline.Observations,
    ) -> tuple[plumbline.Calibration, set[tuple[int, int]]]:
        raise DegenerateLinesError("no")

    one = compare(GROUP, "moved", 0.1, 2, hopeless)
    assert one.failures == ("trial 0: no", "trial 1: no")
    assert one.ratio == np.inf
    assert not one.met


def test_groups_are_pooled_by_their_picks_and_none_of_their_failures_is_lost() -> None:
    one = Row("one", "moved", 0.1, ("trial 3: no",), 1, 1.0, 1.0, 2.0, 10, 100, 0.9, 0.0)
    two = Row("two", "moved", 0.1, (), 2, 7.0, 3.0, 5.0, 30, 300, 1.0, 0.02)
    both = pooled([one, two])
    assert (both.failures, both.folded, both.worst) == (("trial 3: no",), 3, 5.0)
    assert both.ratio == pytest.approx(5.0)
    assert both.named == pytest.approx(39 / 40)
    assert both.good_named == pytest.approx(6 / 400)

"""The adjustment: exact where the observations are, and as sure as the bound allows."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from plumbline.errors import DegenerateLinesError
from plumbline.frame import Frame
from plumbline.ground.adjusting.adjustment import adjust, chi_square_limit
from plumbline.ground.adjusting.network import Focal, GroundLine, Network, RightAngle, Tape
from plumbline.ground.judging.advice import advise
from plumbline.ground.judging.degeneracy import refuse_too_few, refuse_undetermined
from plumbline.ground.judging.implied import implied_camera
from plumbline.ground.judging.suspects import find_suspects
from plumbline.ground.optics import Optics
from plumbline.ground.outcome import rectification_of
from plumbline.ground.rectification import Rectification
from plumbline.lenses.mapping import PhotoLens
from plumbline.models import get_model
from tests.benchmarks import road_scenes
from tests.benchmarks.road_scenes import EDGES, EYE, HIGH, Group, groups, optics
from tests.ground.scenes import Scene
from tests.ground.test_camera import camera_of
from tests.truth import Array

GROUPS = {group.name: group for group in groups()}
CHECKS = np.array([[0.0, 8.0], [1.0, 9.0], [0.0, 25.0]])


def exact(group: Group) -> Network:
    """What is observed without any error."""
    scene, ground = group.scene, group.ground
    tapes = tuple(Tape(i, j, float(np.hypot(*(ground[i] - ground[j])))) for i, j in group.tapes)
    edges = tuple(
        GroundLine(
            str(x), scene.photo(np.column_stack((np.full(12, x), np.geomspace(*ends, 12)))), 0
        )
        for x, ends in EDGES
    )
    return Network(
        tuple(f"P{index}" for index in range(len(ground))),
        scene.photo(ground),
        np.full_like(ground, np.nan) if group.taped else ground,
        np.full(len(ground), road_scenes.GROUND_M),
        tapes=tapes if group.taped else (),
        lines=edges if group.lines else (),
        focal=None if group.focal is None else Focal(scene.focal, group.focal),
        sigma_centre_px=road_scenes.CENTRE_PX,
    )


def found(group: Group) -> Rectification:
    return rectification_of(adjust(exact(group), optics(group.scene)))


@pytest.mark.parametrize("group", GROUPS.values(), ids=GROUPS.keys())
def test_exact_observations_are_met_exactly(group: Group) -> None:
    checks = np.array(group.checks)
    places = found(group).to_ground(group.scene.photo(checks))
    truth = road_scenes.in_datum(checks, group.ground) if group.taped else checks
    assert np.max(np.abs(places - truth)) < 1e-4


@pytest.mark.parametrize("group", GROUPS.values(), ids=GROUPS.keys())
def test_the_covariance_is_the_cramer_rao_bound(group: Group) -> None:
    """The bound comes from numerical derivatives of the independent camera."""
    checks = np.array(group.checks)
    bound = np.trace(road_scenes.bound(group), axis1=1, axis2=2)
    stated = np.trace(found(group).covariances(group.scene.photo(checks)), axis1=1, axis2=2)
    assert np.max(np.abs(stated / bound - 1)) < 2e-3


@pytest.mark.parametrize("group", GROUPS.values(), ids=GROUPS.keys())
def test_the_budget_sums_up_to_the_covariance(group: Group) -> None:
    result = found(group)
    pick = group.scene.photo(np.array(group.checks))[-1]
    parts = result.budget(pick)
    assert np.allclose(sum(parts.values()), result.covariances(pick[None])[0], rtol=1e-6)


def test_ground_to_photo_agrees_with_opencv() -> None:
    """A homography of undistorted points, then the lens, against the adjusted camera."""
    scene = Scene(height=1.6, pitch=9, heading=3, roll=1)
    ground = GROUPS["1.6 m, wide, 12"].ground
    group = replace(GROUPS["1.6 m, wide, 12"], scene=scene)
    result = found(group)
    matrix, _ = cv2.findHomography(ground, scene.lens.undistort(scene.photo(ground)))
    wanted = CHECKS
    homogeneous = np.column_stack((wanted, np.ones(len(wanted)))) @ np.asarray(matrix).T
    theirs = scene.lens.distort(homogeneous[:, :2] / homogeneous[:, 2:])
    assert np.max(np.abs(result.to_ground(theirs) - wanted)) < 1e-3


@pytest.mark.parametrize("scene", [EYE, HIGH], ids=["1.6 m", "5 m"])
def test_tapes_have_the_handedness_of_the_photo(scene: Scene) -> None:
    """Four points with six tapes and no coordinates; a mirrored network has the same tapes."""
    name = "1.6 m, small, 6, tapes" if scene is EYE else "5 m, small, 6, tapes"
    group = replace(GROUPS[name], points=4)
    places = found(group).places_m
    truth = road_scenes.in_datum(group.ground, group.ground)
    assert np.max(np.abs(places - truth)) < 1e-5


def test_two_lane_edges_cut_the_error_ahead_threefold() -> None:
    ahead = EYE.photo(np.array([[0.0, 25.0]]))
    plain, lined = (found(GROUPS[f"1.6 m, small, 6{name}"]) for name in ("", ", lane edges"))
    with_pick = [float(np.sqrt(np.trace(each.covariances(ahead)[0]))) for each in (plain, lined)]
    assert with_pick[0] > 3 * with_pick[1]


def test_the_advice_is_what_the_lines_then_do() -> None:
    group = GROUPS["1.6 m, small, 6"]
    best = advise(adjust(exact(group), optics(group.scene)))[0]
    assert "lane edges" in best.what
    assert best.then_m < best.now_m / 3


@pytest.mark.parametrize("name", ["1.6 m, wide, 4", "5 m, small, 6", "5 m, wide, 6, tapes"])
def test_the_ground_implies_the_camera(name: str) -> None:
    group = GROUPS[name]
    implied = implied_camera(exact(group), optics(group.scene))
    assert implied is not None
    assert implied.focal_px == pytest.approx(group.scene.focal, rel=1e-4)
    assert implied.height_m == pytest.approx(group.scene.height, rel=1e-4)
    assert implied.pitch_deg == pytest.approx(-group.scene.pitch, abs=1e-2)
    assert implied.agrees


def test_a_blunder_of_four_points_shows_by_the_focal_length() -> None:
    group = GROUPS["1.6 m, wide, 4"]
    network = exact(group)
    wrong = network.places_m.copy()
    wrong[2] += [0.8, 0.0]
    implied = implied_camera(replace(network, places_m=wrong), optics(group.scene))
    assert implied is not None
    assert not implied.agrees
    assert "contradicts" in implied.verdict


def test_without_lines_or_focal_length_the_lens_centre_is_its_prior() -> None:
    result = found(GROUPS["1.6 m, small, 4"])
    assert result.camera.optics.shift_px == pytest.approx((0.0, 0.0), abs=1e-3)


def taped(ground: Array, pairs: list[tuple[int, int]], scene: Scene = EYE) -> Network:
    tapes = tuple(Tape(i, j, float(np.hypot(*(ground[i] - ground[j])))) for i, j in pairs)
    return Network(
        tuple("ABCDEF"[: len(ground)]),
        scene.photo(ground),
        np.full_like(ground, np.nan),
        np.full(len(ground), 0.01),
        tapes=tapes,
        sigma_centre_px=11.5,
    )


def test_a_missing_tape_is_named() -> None:
    """Four points, three tapes, no focal length: what is loose is named, with what would fix it."""
    ground = np.array(road_scenes.SMALL)
    network = taped(ground, [(0, 1), (1, 2), (2, 3)])
    with pytest.raises(DegenerateLinesError) as error:
        refuse_undetermined(adjust(network, optics(EYE)))
    assert "undetermined" in error.value.message or "hardly" in error.value.message
    assert "a tape from" in error.value.hint or "--focal-px" in error.value.hint


def test_a_rectangle_of_unknown_ratio_needs_the_focal_length() -> None:
    ground = np.array(road_scenes.SMALL)
    corners = tuple(RightAngle((i - 1) % 4, i, (i + 1) % 4) for i in range(3))
    network = replace(taped(ground, [(0, 1)]), right_angles=corners)
    with pytest.raises(DegenerateLinesError, match="needs the focal"):
        refuse_too_few(network)
    told = replace(network, focal=Focal(EYE.focal, 0.02))
    refuse_too_few(told)
    result = rectification_of(adjust(told, optics(EYE)))
    side = result.measure("distance", ["B", "C"])
    assert side.values[0] == pytest.approx(4.0, abs=1e-3)
    assert side.errors[0] > 0.02


def test_two_points_square_on_give_scale_and_rotation() -> None:
    """A door seen square-on: f/h is the scale; the pinhole looks straight at the plane."""
    scale = 400.0  # pixels a metre
    picks = np.array([[700.0, 900.0], [700.0 + scale, 900.0 - 0.5 * scale]])
    network = Network(
        ("A", "B"),
        picks,
        np.full((2, 2), np.nan),
        np.full(2, 0.01),
        tapes=(Tape(0, 1, float(np.hypot(1.0, 0.5)), 0.001),),
        focal=Focal(2000.0, 0.02),
        sigma_square_rad=0.02,
        flatness_m=0.002,
    )
    lens = Optics(PhotoLens(Frame(2048, 1536), get_model("ptlens"), (0.0, 0.0, 0.0), 768.0))
    result = rectification_of(adjust(network, lens))
    assert result.camera.height_m == pytest.approx(2000 / scale, rel=1e-3)
    place = result.to_ground(picks[:1] + np.array([0.0, -scale]))[0]
    turn = np.arctan2(0.5, 1.0)
    assert place == pytest.approx([np.sin(turn), np.cos(turn)], abs=2e-3)


def noisy(network: Network, rng: np.random.Generator) -> Network:
    return replace(network, picks_px=network.picks_px + rng.normal(0, 0.3, network.picks_px.shape))


def test_a_wrong_tape_is_named_with_its_unit() -> None:
    group = GROUPS["1.6 m, wide, 6, tapes"]
    network = noisy(exact(group), np.random.default_rng(0))
    feet = replace(network.tapes[3], metres=network.tapes[3].metres / 0.3048)
    tapes = (*network.tapes[:3], feet, *network.tapes[4:])
    doubts = find_suspects(adjust(replace(network, tapes=tapes), optics(group.scene)))
    names = f"P{feet.first}-P{feet.second}"
    assert [doubt.what for doubt in doubts] == [f"tape {names}"]
    assert "feet" in doubts[0].off


def test_a_wrong_point_is_named_with_how_far_it_is_off() -> None:
    group = GROUPS["1.6 m, wide, 12"]
    network = noisy(exact(group), np.random.default_rng(0))
    wrong = network.places_m.copy()
    wrong[5] += [0.5, 0.0]
    doubts = find_suspects(adjust(replace(network, places_m=wrong), optics(group.scene)))
    assert doubts[0].what == "point P5"
    assert "0.5" in doubts[0].off or "0.49" in doubts[0].off


def test_nothing_is_suspected_where_nothing_is_wrong() -> None:
    group = GROUPS["1.6 m, wide, 12"]
    network = noisy(exact(group), np.random.default_rng(0))
    assert not find_suspects(adjust(network, optics(group.scene)))


@pytest.mark.parametrize("dof", [1, 2, 5, 20, 100])
def test_the_limit_of_chi_square(dof: int) -> None:
    from scipy.stats import chi2

    assert chi_square_limit(dof, 0.01) == pytest.approx(chi2.isf(0.01, dof), rel=0.03)


SPREADS = {
    5: [(0.02, 0.98), (0.98, 0.98), (0.98, 0.05), (0.02, 0.05), (0.5, 0.25)],
    6: [(0.02, 0.98), (0.98, 0.98), (0.98, 0.05), (0.02, 0.05), (0.5, 0.5), (0.5, 0.05)],
    12: [(x, y) for y in (0.05, 0.35, 0.65, 0.98) for x in (0.02, 0.5, 0.98)],
}
"""Points over the photo, in shares of its sides."""

MOST = {5: (0.0028, 0.0040), 6: (0.0019, 0.0027), 12: (0.0011, 0.0009)}


@pytest.mark.parametrize("points", sorted(SPREADS))
@pytest.mark.parametrize("height", [1.6, 5.0])
def test_b_is_as_sure_as_it_can_be(height: float, points: int) -> None:
    """Half a pixel and a centimetre, a flat road that fills the photo, no focal length told."""
    scene = Scene(height=height, pitch=22, roll=0)
    picks = np.array(SPREADS[points]) * (np.array(scene.size) - 1)
    network = Network(
        tuple(map(str, range(points))),
        picks,
        camera_of(scene).ground(picks),
        np.full(points, 0.01),
        flatness_m=1e-6,
        refined=("b",),
    )
    result = adjust(network, optics(scene))
    assert result.state.camera.optics.lens.coefficients[1] == pytest.approx(-0.02, abs=1e-6)
    assert np.sqrt(result.cofactor[9, 9]) <= MOST[points][0 if height == 1.6 else 1]

"""The camera against the independent one, its derivatives against differences, and back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from plumbline.frame import Frame
from plumbline.ground.camera import N_STEPS, Camera, looking
from plumbline.ground.optics import Optics
from plumbline.lenses.mapping import TURNS, PhotoLens
from plumbline.models import MODELS, get_model
from tests.ground.scenes import Scene
from tests.truth import Array, TrueLens

PLACES = np.array([[-1.0, 5.0], [3.0, 6.0], [0.0, 20.0], [-2.0, 11.0], [4.0, 40.0]])
SCENES = {
    "level": Scene(pitch=9, heading=7, roll=2, shift=(3.0, -2.0)),
    "high": Scene(height=5, pitch=25, heading=-12, roll=-4),
    "rolled": Scene(height=3, pitch=15, roll=15, b=0.02),
}
VALUES = {
    "ptlens": {"a": 0.01, "b": -0.03, "c": 0.005},
    "poly3": {"k1": -0.02},
    "poly5": {"k1": -0.03, "k2": 0.004},
    "radial": {"a2": 0.03, "a4": -0.002, "a6": 0.0005},
    "brown": {"k1": 0.03, "k2": -0.004, "k3": 0.0005, "p1": 0.001, "p2": -0.0007},
    "division": {"l1": -0.03, "l2": 0.001},
    "opencv": {"k1": -0.1, "k2": 0.03, "p1": 0.001, "p2": -0.0007, "k3": 0.001},
    "acm": {"k1": -0.1, "k2": 0.03, "k3": 0.001, "k4": 0.001, "k5": -0.0007},
}


def camera_of(scene: Scene) -> Camera:
    lens = PhotoLens(Frame(*scene.size), get_model("ptlens"), (0.0, scene.b, 0.0), 768.0)
    optics = Optics(lens, scene.shift)
    above = np.array([0.0, 0.0, scene.height])
    return looking(above, -scene.pitch, scene.roll, scene.focal, optics, scene.heading)


def optics_of(name: str, shift: tuple[float, float] = (0.0, 0.0)) -> Optics:
    model = get_model(name)
    c = tuple(VALUES[name][key] for key in model.coefficients)
    unit = 2300.0 if model.unit == "focal length" else 768.0
    return Optics(PhotoLens(Frame(2048, 1536), model, c, unit), shift)


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES.keys())
@pytest.mark.parametrize("lift", [0.0, 0.3])
def test_places_are_seen_where_the_independent_camera_sees_them(scene: Scene, lift: float) -> None:
    places = np.column_stack((PLACES, np.full(len(PLACES), lift)))
    found = camera_of(scene).project(places)
    assert np.max(np.abs(found - scene.photo(PLACES, lift))) < 1e-8


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES.keys())
def test_the_angles_are_those_it_was_made_with(scene: Scene) -> None:
    camera = camera_of(scene)
    assert camera.heading_deg == pytest.approx(scene.heading)
    assert camera.pitch_deg == pytest.approx(-scene.pitch)
    assert camera.roll_deg == pytest.approx(scene.roll)


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES.keys())
def test_the_ground_of_what_is_seen_is_the_place(scene: Scene) -> None:
    camera = camera_of(scene)
    assert np.max(np.abs(camera.ground(scene.photo(PLACES)) - PLACES)) < 1e-8


def test_the_ground_above_the_horizon_is_nowhere() -> None:
    camera = camera_of(SCENES["level"])
    assert np.isnan(camera.ground(np.array([[1000.0, 100.0]]))).all()
    assert np.isnan(camera.project(np.array([[0.0, -5.0, 0.0]]))).all(), "behind the camera"


def differences(function: Callable[[Array], Array], count: int, step: float) -> Array:
    columns: list[Array] = []
    for index in range(count):
        move = np.zeros(count)
        move[index] = step
        columns.append((function(move) - function(-move)) / (2 * step))
    return np.stack(columns, axis=-1)


@pytest.mark.parametrize("name", sorted(VALUES))
@pytest.mark.parametrize("w", [1.0, 0.0])
def test_the_derivatives_are_those_of_differences(name: str, w: float) -> None:
    optics = optics_of(name, (3.0, -2.0))
    camera = looking(np.array([1.0, -2.0, 1.6]), -9.0, 2.0, 2300.0, optics, 5.0)
    places = np.column_stack((PLACES + np.array([1.0, -2.0]), np.linspace(-0.1, 0.2, len(PLACES))))
    if w == 0:
        places = np.column_stack((np.linspace(-0.3, 0.3, 5), np.ones(5), np.zeros(5)))
    seen = camera.see(places, w)
    assert np.max(np.abs(seen.px - camera.project(places, w))) < 1e-9
    steps = differences(lambda m: camera.stepped(m).project(places, w), N_STEPS, 1e-6)
    assert np.allclose(seen.by_camera, steps, rtol=1e-6, atol=2e-4)
    lifts = differences(lambda m: camera.project(places + m, w), 3, 1e-6)
    assert np.allclose(seen.by_place, lifts, rtol=1e-6, atol=2e-4)
    values = np.array(optics.lens.coefficients)

    def bent(move: Array) -> Array:
        other = optics.with_coefficients(values + move)
        return replace(camera, optics=other).project(places, w)

    assert np.allclose(seen.by_lens, differences(bent, len(values), 1e-6), rtol=1e-5, atol=2e-4)


def test_every_model_has_values_here() -> None:
    assert set(MODELS) <= set(VALUES)


@pytest.mark.parametrize("name", sorted(VALUES))
def test_the_lens_bends_as_the_truth_does(name: str) -> None:
    truth = TrueLens(name, VALUES[name], (2048, 1536), focal_px=2300.0)
    points = np.array([[30.0, 40.0], [1500.0, 900.0], [1023.5, 767.5], [2000.0, 1500.0]])
    optics = optics_of(name, (3.0, -2.0))
    ideal = truth.undistort(points)
    assert np.max(np.abs(optics.undistort(points + np.array([3.0, -2.0])) - ideal)) < 1e-6
    assert np.max(np.abs(optics.distort(ideal) - points - [3.0, -2.0])) < 1e-6


@pytest.mark.parametrize("orientation", sorted(TURNS))
def test_a_turned_lens_has_turned_derivatives(orientation: int) -> None:
    optics = optics_of("brown")
    lens = replace(optics.lens, turn=TURNS[orientation], observed_centre=(0.02, -0.01))
    turned = replace(optics, lens=lens)
    points = np.array([[30.0, 40.0], [1500.0, 900.0], [2000.0, 1500.0]])
    assert np.max(np.abs(turned.distort(points) - lens.distort(points))) < 1e-9
    _, by_point, _ = turned.with_derivatives(points)
    found = differences(lambda m: turned.distort(points + m), 2, 1e-4)
    assert np.allclose(by_point, found, atol=1e-6)


def test_what_lies_beyond_the_fold_is_not_seen() -> None:
    """b = −0.1 folds at r = √(1.1 / 0.3); ground beyond maps back into the photo."""
    lens = PhotoLens(Frame(2048, 1536), get_model("ptlens"), (0.0, -0.1, 0.0), 768.0)
    fold = np.sqrt(1.1 / 0.3)
    ideal = np.array([[1023.5 + 768 * r, 767.5] for r in (fold - 0.01, fold + 0.01, 3.2)])
    found = Optics(lens).distort(ideal)
    assert np.isfinite(found[0]).all()
    assert np.isnan(found[1:]).all()
    ghost = 1023.5 + 768 * 3.2 * (1.1 - 0.1 * 3.2**2)
    assert 0 < ghost < 2048, "the formula alone would put it into the photo"

"""The fit against lenses of known distortion, and what it refuses."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache as remembered
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import plumbline
from plumbline import Observations, calibrate
from plumbline.errors import (
    CollapsedFitError,
    DegenerateLinesError,
    OptionError,
    PlumblineError,
    UnsupportedModelError,
)
from plumbline.fit import single
from plumbline.fit.program.task import FitTask, Solution
from plumbline.fit.refusals import refuse_bent, refuse_collapsed
from plumbline.frame import Frame
from plumbline.geometry.lens import Lens
from plumbline.models import CENTRE, MODELS, Model, get_model
from plumbline.observations import Line, Photo
from plumbline.observations.facts import LensFacts
from plumbline.result.calibration import Calibration
from tests import truth
from tests.many import all_calibrated
from tests.truth import TrueLens

Array = truth.Array
Coefficients = Mapping[str, float]

# 16 lines of 12 picks everywhere: one block shape, and so one compiled program for each model.
FOCAL_PX = 2400.0
ACTION_CAMERAS = [
    {"a": 0.06335, "b": -0.18432, "c": -0.13009},
    {"a": 0.01359, "b": -0.06034, "c": -0.10618},
    {"a": 0.1064, "b": -0.2871, "c": -0.1011},
]
MILD = {"a": 0.012, "b": -0.05, "c": 0.013}

LENSES: list[tuple[str, Coefficients]] = [
    *(("ptlens", camera) for camera in ACTION_CAMERAS),
    ("ptlens", {"a": 0.0, "b": -0.06, "c": 0.0}),
    ("ptlens", {"a": 0.01, "b": 0.05, "c": 0.02}),
    ("ptlens", {"a": 0.06, "b": -0.17, "c": 0.12}),  # moustache
    ("poly3", {"k1": -0.05}),
    ("poly3", {"k1": 0.08}),
    ("poly5", {"k1": -0.09, "k2": 0.012}),
    ("poly5", {"k1": 0.05, "k2": 0.01}),
    ("radial", {"a2": 0.15, "a4": -0.03, "a6": 0.006}),
    ("radial", {"a2": -0.06, "a4": 0.01, "a6": -0.001}),
    ("radial:1,2,3", {"a1": 0.03, "a2": 0.1, "a3": -0.02}),
    ("radial:2,4", {"a2": -0.06, "a4": 0.025}),  # moustache
    ("brown", {"k1": 0.12, "k2": 0.02, "k3": -0.003, "p1": 0.004, "p2": -0.003}),
    ("brown", {"k1": -0.06, "k2": 0.01, "k3": -0.001, "p1": -0.004, "p2": 0.002}),
    ("division", {"l1": -0.2, "l2": 0.01}),
    ("division", {"l1": 0.06, "l2": 0.005}),
    ("opencv", {"k1": -0.25, "k2": 0.08, "p1": 0.003, "p2": -0.002, "k3": -0.01}),
    ("acm", {"k1": 0.1, "k2": 0.04, "k3": -0.01, "k4": -0.002, "k5": 0.003}),
]


def picked(lens: TrueLens, noise_px: float = 0.0, seed: int = 0, **facts: Any) -> Observations:
    """What someone picks in a photo taken with that lens."""
    obs = Observations.from_arrays(
        lens.lines(noise_px=noise_px, seed=seed), lens.size, pixel_aspect=lens.aspect
    )
    return replace(obs, lenses=(replace(LensFacts(focal_px=lens.focal_px), **facts),))


def unlike_px(lens: TrueLens, made: Calibration, *, perspective: bool = False) -> float:
    grid = truth.grid_px(lens.size)
    square = np.array([lens.aspect, 1.0])
    return truth.unlike_px(
        lens.undistort(grid) * square, made.lens.undistort(grid) * square, perspective=perspective
    )


def test_every_model_is_recovered_here() -> None:
    assert {name for name, _ in LENSES} >= set(MODELS)


@pytest.mark.parametrize(("name", "c"), LENSES)
def test_the_true_curve_is_found_from_nothing(name: str, c: Coefficients) -> None:
    lens = TrueLens(name, c, focal_px=FOCAL_PX)
    made = calibrate(picked(lens), name)
    assert made.converged
    assert made.rms_before_px > 3
    assert made.rms_after_px < 1e-8
    assert unlike_px(lens, made, perspective=name in truth.TANGENTIAL) < 1e-6
    assert made.free == get_model(name).coefficients
    assert set(made.start.values()) == {0.0}


@pytest.mark.parametrize("name", ["ptlens", "brown"])
def test_a_displaced_centre_is_found(name: str) -> None:
    c = MILD if name == "ptlens" else {"k1": 0.08, "k2": 0.02}
    lens = TrueLens(name, {**c, "d": 35.5, "e": -21.25})
    made = calibrate(picked(lens), name, free=(*c, "d", "e"))
    assert unlike_px(lens, made) < 1e-6
    assert made.coefficients["d"] == pytest.approx(35.5, abs=1e-6)
    assert made.coefficients["e"] == pytest.approx(-21.25, abs=1e-6)
    held = calibrate(picked(lens), name, free=tuple(c))
    assert held.rms_after_px > 0.3


def test_a_displaced_centre_counts_in_the_photos_own_pixels() -> None:
    lens = TrueLens("ptlens", {**MILD, "d": 35.5, "e": -21.25}, aspect=1.25)
    made = calibrate(picked(lens), free="abcde")
    assert made.coefficients["d"] == pytest.approx(35.5, abs=1e-6)
    assert made.coefficients["e"] == pytest.approx(-21.25, abs=1e-6)
    assert unlike_px(lens, made) < 1e-6
    held = calibrate(picked(lens), start={"d": 35.5, "e": -21.25})
    assert held.rms_after_px < 1e-8


def test_a_portrait_photo_is_measured_by_its_shorter_side() -> None:
    lens = TrueLens("ptlens", MILD, (2250, 3000))
    made = calibrate(picked(lens))
    for name, value in MILD.items():
        assert made.coefficients[name] == pytest.approx(value, abs=1e-9)


def test_upright_and_sideways_photos_are_fitted_together() -> None:
    lying, standing = TrueLens("ptlens", MILD), TrueLens("ptlens", MILD, (2250, 3000))
    lines = [Line(points, 0, "l") for points in lying.lines(noise_px=0)[::2]]
    lines += [Line(points, 1, "s") for points in standing.lines(noise_px=0)[1::2]]
    obs = Observations((Photo((3000, 2250)), Photo((2250, 3000))), tuple(lines)).checked()
    made = calibrate(obs)
    assert made.rms_after_px < 1e-8
    for name, value in MILD.items():
        assert made.coefficients[name] == pytest.approx(value, abs=1e-9)
    for free in (("a", "b", "c", "d"), ("b", "e")):
        with pytest.raises(OptionError, match="upright and sideways"):
            calibrate(obs, free=free)
    with pytest.raises(OptionError, match="p1 means different things"):
        calibrate(obs, "brown")
    with pytest.raises(OptionError, match="d means different things"):
        calibrate(obs, start={"d": 3.0})


def test_contradictory_sizes_of_one_lens_are_refused() -> None:
    lines = tuple(Line(points) for points in TrueLens("ptlens", MILD).lines())
    obs = Observations((Photo((3000, 2250)), Photo((3000, 2000), "b.jpg")), lines)
    with pytest.raises(OptionError, match=r"3000x2250 and 3000x2000 \(b\.jpg\)"):
        calibrate(obs)


def test_two_lenses_are_refused() -> None:
    obs = picked(TrueLens("ptlens", MILD))
    with pytest.raises(OptionError, match="of 2 lenses"):
        calibrate(Observations.side_by_side([obs, obs]))


# Negative control


def test_a_wrong_pixel_aspect_cannot_be_straightened() -> None:
    lens = TrueLens("ptlens", ACTION_CAMERAS[0], aspect=1.05)
    right = calibrate(picked(lens))
    assert right.rms_after_px < 1e-8
    assert unlike_px(lens, right) < 1e-6
    assert calibrate(picked(lens).squared()).rms_after_px < 1e-8  # 3150 square pixels wide
    ignored = Observations.from_arrays(lens.lines(), lens.size, pixel_aspect=1.0)
    assert calibrate(ignored).rms_after_px > 1


# Free, held, start


def test_held_coefficients_come_back_bit_identical() -> None:
    held = {"k3": -0.0012345678901234567, "p1": 0.1 + 0.2 - 0.2999, "p2": -1 / 3000, "d": 5.7}
    assert held["d"] / 1125 * 1125 != held["d"]  # normalising it and back would show
    lens = TrueLens("brown", {"k1": 0.12, "k2": 0.02, **held})
    made = calibrate(picked(lens, noise_px=0.5), "brown", free=("k1", "k2"), start=held)
    for name, value in held.items():
        assert made.coefficients[name] == value
        assert made.start[name] == value
    assert made.coefficients["e"] == 0.0
    assert made.held == {**held, "e": 0.0}
    assert set(made.standard_errors) == {"k1", "k2"}
    assert made.coefficients["k1"] == pytest.approx(0.12, abs=0.003)


@pytest.mark.parametrize("start", [{"a": 0.05, "b": -0.15, "c": 0.02}, {}, {"b": -0.03}])
def test_a_good_start_vector_ends_in_the_same_minimum(start: dict[str, float]) -> None:
    lens = TrueLens("ptlens", MILD)
    obs = picked(lens, noise_px=0.5)
    made, staged = calibrate(obs, start=start), calibrate(obs)
    assert made.start == dict.fromkeys("abcde", 0.0) | start
    for name in "abc":
        assert made.coefficients[name] == pytest.approx(staged.coefficients[name], abs=1e-8)
    assert not any("worse fit" in note for note in made.notes)


def test_a_start_vector_that_ends_worse_is_told_with_the_better_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """No start vector is known that ends worse: here the solver stays where the user begins."""
    obs = picked(TrueLens("ptlens", ACTION_CAMERAS[0]), noise_px=0.5, seed=1)
    staged = calibrate(obs)
    solve = single.solve

    def stuck(model: Model, task: FitTask) -> Solution:
        return solve(model, task if task.staged else task._replace(free=np.zeros(5, dtype=bool)))

    monkeypatch.setattr(single, "solve", stuck)
    made = calibrate(obs, start={"a": 0.06, "b": -0.17, "c": -0.13})
    assert made.rms_after_px > 1.5 * staged.rms_after_px
    (told,) = [note for note in made.notes if "worse fit" in note]
    assert f"{staged.rms_after_px:.4g} px with a = {staged.coefficients['a']:.6g}" in told
    assert f"{made.rms_after_px:.4g} px)" in told


def test_a_start_vector_that_folds_is_blamed_itself() -> None:
    obs = picked(TrueLens("ptlens", ACTION_CAMERAS[0]))
    calibrate(obs)
    with pytest.raises(PlumblineError) as caught:
        calibrate(obs, start={"b": -0.5})
    assert "start" in caught.value.message + caught.value.hint


STORED = {"a": 0.011, "b": -0.045, "c": 0.02, "d": 12.25, "e": -8.75, "g": 0.0, "t": 0.0}


def test_the_files_values_are_taken_on_demand_alone() -> None:
    lens = TrueLens("ptlens", {**MILD, "d": 12.25, "e": -8.75})
    obs = picked(lens, stored=STORED)
    from_zero, from_file = calibrate(obs), calibrate(obs, start="file")
    assert from_zero.start == {"a": 0.0, "b": 0.0, "c": 0.0, "d": 12.25, "e": -8.75}
    assert from_file.start == {name: STORED[name] for name in "abcde"}
    assert any("not used: the file's a = 0.011, b = −0.045, c = 0.02" in n for n in from_zero.notes)
    assert not any("not used" in note for note in from_file.notes)
    for made in (from_zero, from_file):
        assert (made.coefficients["d"], made.coefficients["e"]) == (12.25, -8.75)
        assert unlike_px(lens, made) < 1e-6
    held = "held: the project's distortion centre d = 12.25 px, e = −8.75 px"
    assert any(held in note for note in from_zero.notes)
    elsewhere = calibrate(obs, start={"d": 0.0, "e": 0.0})
    assert (elsewhere.coefficients["d"], elsewhere.coefficients["e"]) == (0.0, 0.0)


def test_held_values_of_the_file_stay_with_it() -> None:
    obs = picked(TrueLens("ptlens", MILD), noise_px=0.3, stored=STORED)
    made = calibrate(obs, start="file", free=("b",))
    assert made.held == {"a": 0.011, "c": 0.02, "d": 12.25, "e": -8.75}
    alone = calibrate(obs, free=("b",))
    assert alone.held == {"a": 0.0, "c": 0.0, "d": 12.25, "e": -8.75}


def test_a_file_may_have_no_values_or_not_those_of_the_model() -> None:
    lens = TrueLens("ptlens", MILD)
    with pytest.raises(OptionError, match="stores no lens values"):
        calibrate(picked(lens), start="file")
    with pytest.raises(UnsupportedModelError, match="cannot start the model brown"):
        calibrate(picked(lens, stored=STORED), "brown", start="file")


def test_the_projects_choice_of_coefficients_is_the_default() -> None:
    lens = TrueLens("ptlens", {"a": 0.0, "b": -0.04, "c": 0.0})
    obs = picked(lens, requested=("b", "v"))
    made = calibrate(obs)
    assert made.free == ("b",)
    assert any("asks to optimise b;" in note for note in made.notes)
    assert calibrate(obs, free=("c", "a")).free == ("a", "c")
    assert calibrate(obs, "poly3").free == ("k1",)
    assert calibrate(picked(lens, requested=("e", "b", "d"))).free == ("b", "d", "e")
    assert calibrate(picked(lens, requested=("v",))).free == ("a", "b", "c")
    assert calibrate(picked(lens, requested=("a", "b", "c"))).notes == calibrate(picked(lens)).notes


def test_hold_takes_from_what_is_free() -> None:
    obs = picked(TrueLens("ptlens", MILD))
    assert calibrate(obs, hold=("a", "c")).free == ("b",)
    assert calibrate(obs, free=("c", "b", "d"), hold=("d",)).free == ("b", "c")


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        ({"free": ("a", "x")}, "the free coefficients include an unknown coefficient 'x'"),
        ({"free": ("k1",)}, "unknown coefficient 'k1'"),
        ({"hold": ("v",)}, "the held coefficients include an unknown coefficient 'v'"),
        ({"start": {"q": 1.0}}, "the start vector names an unknown coefficient 'q'"),
        ({"free": ()}, "nothing to fit"),
        ({"hold": ("a", "b", "c")}, "nothing to fit"),
        ({"free": ("b",), "hold": ("b",)}, "nothing to fit"),
        ({"residual": "picture"}, "image or corrected"),
        ({"start": {"b": float("nan")}}, "not finite"),
        ({"start": {"a": float("inf")}}, "not finite"),
        ({"model": "spline"}, "'spline' is not a distortion model"),
        ({"model": "opencv"}, "focal"),
    ],
)
def test_wrong_arguments_are_refused(arguments: dict[str, Any], complaint: str) -> None:
    with pytest.raises(OptionError, match=complaint):
        calibrate(picked(TrueLens("ptlens", MILD)), **arguments)


def test_sheared_and_fisheye_photos_are_refused() -> None:
    lens = TrueLens("ptlens", MILD)
    for name in "gt":
        with pytest.raises(OptionError, match=rf"shears the photo \({name} = 2\)"):
            calibrate(picked(lens, stored={**STORED, name: 2.0}))
    with pytest.raises(OptionError, match="marked as fisheye"):
        calibrate(picked(lens, projection="fisheye"))


# Uncertainty


@remembered
def repeated() -> list[Calibration]:
    """The same lens, picked 64 times over with 0.5 px of noise."""
    lens = TrueLens("ptlens", MILD)
    return all_calibrated([picked(lens, noise_px=0.5, seed=seed) for seed in range(64)])


def test_sigma_is_the_noise_of_the_picks() -> None:
    assert {made.dof for made in repeated()} == {16 * 12 - 2 * 16 - 3}
    # One σ̂² of 157 degrees of freedom scatters by √(2 / 157), the mean of 64 by an eighth of it.
    mean = np.mean([made.sigma_px**2 for made in repeated()]) / 0.25
    assert abs(mean - 1) < 3 * np.sqrt(2 / 157) / 8


def test_standard_errors_are_the_scatter_of_repeated_picks() -> None:
    off = np.array(
        [[(made.coefficients[n] - MILD[n]) / made.standard_errors[n] for n in "abc"]
         for made in repeated()]
    )  # fmt: skip
    # 64 samples: the mean scatters by 1/8, the standard deviation by 1/√128 = 0.088.
    assert np.all(np.abs(off.mean(axis=0)) < 3 / 8)
    assert np.all(np.abs(off.std(axis=0, ddof=1) - 1) < 3 / np.sqrt(128))


def independent_covariance(made: Calibration, lens: TrueLens, kind: str) -> tuple[Array, float]:
    """σ̂² (JᵀJ)⁻¹, or the sandwich around it, with numerical derivatives of independent residuals.

    A pick's error reaches the corrected photo as many times larger as the residual there is than
    that in the photograph.
    """
    lines = [line.points_px for line in made.observations.lines]

    def residual(values: Mapping[str, float], *, in_photo: bool) -> Array:
        at = replace(lens, coefficients=dict(values))
        return np.concatenate(truth.distances_px(at, lines, in_photo=in_photo))

    c, own = made.coefficients, kind == "image"
    columns: list[Array] = []
    for name in made.free:
        h = 0.3 if name in CENTRE else 3e-4
        up = residual({**c, name: c[name] + h}, in_photo=own)
        columns.append((up - residual({**c, name: c[name] - h}, in_photo=own)) / (2 * h))
    jacobian, image = np.stack(columns, axis=-1), residual(c, in_photo=True)
    sigma = float(np.sqrt(image @ image / (len(image) - 2 * len(lines) - len(made.free))))
    inverse = np.linalg.inv(jacobian.T @ jacobian)
    larger = residual(c, in_photo=own) / image
    scatter = (jacobian * larger[:, None] ** 2).T @ jacobian
    return np.asarray(sigma**2 * inverse @ scatter @ inverse, np.float64), sigma


@pytest.mark.parametrize("kind", ["image", "corrected"])
@pytest.mark.parametrize(
    ("name", "c", "free"),
    [
        ("ptlens", ACTION_CAMERAS[0], ("a", "b", "c")),
        ("ptlens", {**MILD, "d": 20.0, "e": -9.0}, ("b", "d", "e")),
        ("division", {"l1": -0.15, "l2": 0.01}, ("l1", "l2")),
        ("brown", {"k1": 0.12, "k2": 0.02}, ("k1", "k2", "p1", "p2")),
    ],
)
def test_covariance_agrees_with_numerical_derivatives(
    name: str, c: dict[str, float], free: tuple[str, ...], kind: Any
) -> None:
    lens = TrueLens(name, c)
    made = calibrate(picked(lens, noise_px=0.4), name, free=free, residual=kind)
    expected, sigma = independent_covariance(made, lens, kind)
    assert made.sigma_px == pytest.approx(sigma, rel=1e-6)
    scale = np.sqrt(np.diag(expected))
    np.testing.assert_allclose(
        made.covariance / np.outer(scale, scale), expected / np.outer(scale, scale), atol=1e-3
    )
    for n, deviation in zip(made.free, scale, strict=True):
        assert made.standard_errors[n] == pytest.approx(deviation, rel=1e-3)
    np.testing.assert_allclose(np.diag(made.correlation), 1.0, rtol=1e-14)


def test_the_minimum_is_one() -> None:
    """No coefficient can be moved without the independent residual growing."""
    lens = TrueLens("ptlens", ACTION_CAMERAS[1])
    for kind in ("image", "corrected"):
        made = calibrate(picked(lens, noise_px=0.5), residual=kind)
        lines = [line.points_px for line in made.observations.lines]

        def rms(c: Coefficients, lines: list[Array] = lines, kind: str = kind) -> float:
            at = truth.distances_px(TrueLens("ptlens", c), lines, in_photo=kind == "image")
            return float(np.sqrt(np.mean(np.concatenate(at) ** 2)))

        c = made.coefficients
        assert rms(c) == pytest.approx(made.rms_after_px, rel=1e-7)
        for name in "abc":
            step = 0.02 * made.standard_errors[name]
            assert rms({**c, name: c[name] + step}) > rms(c)
            assert rms({**c, name: c[name] - step}) > rms(c)


def test_both_residuals_are_reported_whichever_is_minimised() -> None:
    lens = TrueLens("ptlens", ACTION_CAMERAS[0])
    obs = picked(lens, noise_px=0.5)
    image, corrected = calibrate(obs), calibrate(obs, residual="corrected")
    assert corrected.rms_after_px == pytest.approx(corrected.rms_corrected_px, rel=1e-14)
    assert corrected.rms_corrected_px < image.rms_corrected_px
    lines = [line.points_px for line in obs.lines]
    fitted = TrueLens("ptlens", image.coefficients)
    apart = np.concatenate(truth.distances_px(fitted, lines, in_photo=False))
    assert image.rms_corrected_px == pytest.approx(float(np.sqrt(np.mean(apart**2))), rel=1e-7)
    assert image.residual == "image"
    assert corrected.residual == "corrected"
    assert any("--residual image" in note for note in corrected.notes)
    before = [np.linalg.svd(points - points.mean(axis=0))[1][1] ** 2 for points in lines]
    assert image.rms_before_px == pytest.approx(np.sqrt(sum(before) / 192), rel=1e-9)
    for line, after in zip(image.lines, image.residuals_px, strict=True):
        assert line.n_points == 12
        assert line.rms_after_px == pytest.approx(np.sqrt(np.mean(after**2)), rel=1e-12)
        assert line.largest_after_px == np.max(np.abs(after))


# Refusals


MIDDLE = np.array([1499.5, 1124.5])


def radiating() -> list[Array]:
    turns = np.arange(16) * np.pi / 16
    along = np.linspace(-1000, 1000, 12)[:, None]
    return [MIDDLE + along * np.array([np.cos(turn), np.sin(turn)]) for turn in turns]


def test_lines_through_the_centre_are_refused() -> None:
    with pytest.raises(DegenerateLinesError):
        calibrate(Observations.from_arrays(radiating(), (3000, 2250)))


def test_lines_through_the_centre_are_refused_for_what_they_are() -> None:
    with pytest.raises(DegenerateLinesError, match="every line runs through the centre"):
        calibrate(Observations.from_arrays(radiating(), (3000, 2250)))


def test_a_small_cluster_of_short_lines_is_refused() -> None:
    rng = np.random.default_rng(0)
    lines = [
        np.stack((1600 + np.linspace(0, 40, 12), np.full(12, 1200.0 + 3 * i)), axis=-1)
        + rng.normal(0, 0.3, (12, 2))
        for i in range(16)
    ]
    with pytest.raises(DegenerateLinesError, match="too short to show a bend"):
        calibrate(Observations.from_arrays(lines, (3000, 2250)))


def test_too_few_points_are_counted_for_the_user() -> None:
    three = [points[::5] for points in TrueLens("ptlens", MILD).lines()[:2]]
    with pytest.raises(DegenerateLinesError, match=r"6 points on 2 lines cannot .* 8 points are"):
        calibrate(Observations.from_arrays(three, (3000, 2250)))


def weak(seed: int) -> Observations:
    """Level lines alone, in the middle of a small photo, poorly picked."""
    rng = np.random.default_rng(seed)
    lens = TrueLens("brown", {"k1": 0.05}, (640, 480))
    x = np.linspace(220, 420, 12)
    ideal = [np.stack((x, np.full(12, 165.0 + 10 * i)), axis=-1) for i in range(16)]
    seen = [lens.distort(points) + rng.normal(0, 1.0, (12, 2)) for points in ideal]
    return Observations.from_arrays(seen, (640, 480))


@pytest.mark.parametrize("seed", range(2))
def test_brown_with_everything_free_is_refused_on_weak_lines(seed: int) -> None:
    everything = (*MODELS["brown"].coefficients, *CENTRE)
    with pytest.raises(DegenerateLinesError):
        calibrate(weak(seed), "brown", free=everything)


def test_collapses_are_told_apart() -> None:
    frame, zero = Frame(640, 480), dict.fromkeys((*MODELS["brown"].coefficients, *CENTRE), 0.0)
    lens = Lens(MODELS["brown"], frame, zero)
    refuse_collapsed(lens, 1.0, 0)
    with pytest.raises(CollapsedFitError, match=r"scales the photo by 0\.55"):
        refuse_collapsed(lens, 0.55, 0)
    with pytest.raises(CollapsedFitError, match=r"scales the photo by 5\.00"):
        refuse_collapsed(lens, 5.0, 0)
    with pytest.raises(CollapsedFitError, match="2 picks beyond the fold"):
        refuse_collapsed(lens, 1.0, 2)
    with pytest.raises(CollapsedFitError, match="1 pick beyond the fold"):
        refuse_collapsed(lens, 1.0, 1)
    away = Lens(MODELS["brown"], frame, zero | {"d": 2160 - 319.5, "e": 2299 - 239.5})
    with pytest.raises(CollapsedFitError, match=r"centre at \(2160, 2299\), outside the 640x480"):
        refuse_collapsed(away, 1.0, 0)


def test_fits_are_the_same_every_time() -> None:
    obs = picked(TrueLens("ptlens", MILD), noise_px=0.5)
    first, second = calibrate(obs), calibrate(obs)
    assert first.coefficients == second.coefficients
    np.testing.assert_array_equal(first.covariance, second.covariance)


# The worked example of the literature


EXAMPLE = Path(plumbline.__file__).parents[2] / "shared/data/olympus/building.pto"


@pytest.fixture(scope="module")
def building() -> Observations:
    if not EXAMPLE.exists():
        pytest.skip("the worked example lies outside the project and is not here")
    return plumbline.read(EXAMPLE)


def assert_coefficients(made: Calibration, *expected: float) -> None:
    for name, value in zip("abc", expected, strict=True):
        assert made.coefficients[name] == pytest.approx(value, abs=1e-4)


def test_worked_example(building: Observations) -> None:
    made = calibrate(building)
    assert (len(building.lines), building.n_points) == (12, 64)
    assert made.rms_before_px == pytest.approx(2.870, abs=5e-4)
    assert_coefficients(made, 0.032059, -0.097803, 0.041666)
    assert made.rms_after_px == pytest.approx(0.3969, abs=5e-5)
    assert made.sigma_px == pytest.approx(0.522, abs=5e-4)
    assert made.dof == 64 - 24 - 3
    for name, error in (("a", 0.0086), ("b", 0.0241), ("c", 0.0215)):
        assert made.standard_errors[name] == pytest.approx(error, rel=0.01)
    assert made.converged


def test_worked_example_corrected(building: Observations) -> None:
    made = calibrate(building, residual="corrected")
    assert_coefficients(made, 0.032441, -0.098839, 0.042521)
    assert made.rms_after_px == pytest.approx(0.3973, abs=5e-5)


def test_worked_example_with_b_alone(building: Observations) -> None:
    made = calibrate(building, free=("b",))
    assert_coefficients(made, 0.0, -0.025511, 0.0)
    assert made.rms_after_px == pytest.approx(0.5865, abs=5e-5)
    assert (made.coefficients["a"], made.coefficients["c"]) == (0.0, 0.0)


@pytest.mark.parametrize("start", ["file", {"a": 0.03, "b": -0.1, "c": 0.05}])
def test_worked_example_from_elsewhere(building: Observations, start: Any) -> None:
    made = calibrate(building, start=start)
    assert_coefficients(made, 0.032059, -0.097803, 0.041666)
    assert made.rms_after_px == pytest.approx(calibrate(building).rms_after_px, abs=1e-9)


def test_worked_example_in_the_right_and_the_wrong_direction(building: Observations) -> None:
    """Hugin's stored result leaves 0.408 px in the corrected photo; turned round, 5.5 px."""
    stored = {name: building.lenses[0].stored[name] for name in "abcde"}
    lens = Lens(MODELS["ptlens"], building.photos[0].frame, stored)

    def left_px(straighten: Callable[[Array], Array]) -> float:
        spreads: list[float] = []
        for line in building.lines:
            points = straighten(line.points_px)
            spreads.append(float(np.linalg.svd(points - points.mean(axis=0))[1][1]))
        return float(np.sqrt(np.sum(np.square(spreads)) / building.n_points))

    assert left_px(lens.undistort) == pytest.approx(0.408, abs=5e-4)
    assert left_px(lens.distort) == pytest.approx(5.5, abs=0.05)


def test_picks_on_no_lines_are_refused() -> None:
    """Random points have some least-squares lens too, and it means nothing."""
    rng = np.random.default_rng(1)
    lines = list(rng.uniform([0, 0], [1199, 799], (16, 12, 2)))
    with pytest.raises(DegenerateLinesError, match=r"not lie on straight lines|folds|collapsed"):
        calibrate(Observations.from_arrays(lines, (1200, 800)))


def test_the_line_that_strays_most_is_named() -> None:
    good, bad = np.array([0.3, -0.3]), np.array([90.0, -120.0])
    lines = [Line(np.zeros((2, 2)), 0, label) for label in ("roof", "sill")]
    refuse_bent(20.0, 750.0, lines, [good, bad])
    with pytest.raises(DegenerateLinesError, match="those of line sill by 106 px"):
        refuse_bent(53.0, 750.0, lines, [good, bad])


@pytest.mark.parametrize("order", [1, -1])
def test_photos_of_other_pixels_are_refused_in_either_order(order: int) -> None:
    photos = (Photo((1000, 1000), pixel_aspect=1.5), Photo((1000, 1000)))[::order]
    edge = np.array([[10.0, 12], [200, 9], [390, 12]])
    both = plumbline.Observations(photos, (Line(edge, 0, "1"), Line(edge, 1, "2")))
    with pytest.raises(OptionError, match="contradictory pixels"):
        plumbline.calibrate(both)


def test_a_crop_whose_centre_is_far_off_ends_in_the_right_minimum() -> None:
    """A quarter of the photo's width: the right minimum leaves the noise, others much more."""
    for seed, (d, e) in enumerate([(700.0, -250.0), (-650.0, 300.0), (600.0, 420.0)]):
        lens = TrueLens("division", {"l1": -0.05, "l2": 0.0, "d": d, "e": e}, (3000, 2000))
        obs = Observations.from_arrays(lens.lines(noise_px=0.3, seed=seed), lens.size)
        made = calibrate(obs, "division", free=("l1", "d", "e"))
        assert made.converged
        assert made.sigma_px == pytest.approx(0.3, rel=0.25)
        for name, true in (("d", d), ("e", e)):
            assert abs(made.coefficients[name] - true) < 4 * made.standard_errors[name]


@pytest.mark.parametrize("focal_px", [20_000.0, 80_000.0])
def test_a_long_focal_length_changes_units_alone(focal_px: float) -> None:
    """The same lens in focal lengths ten and forty times as long: the same errors in pixels."""
    told: list[tuple[float, ...]] = []
    for f_px in (2000.0, focal_px):
        k1 = -0.1 * (f_px / 2000.0) ** 2
        lens = TrueLens("opencv", {"k1": k1}, (3000, 2000), focal_px=f_px)
        lines = lens.lines(noise_px=0.3, seed=1)
        obs = Observations.from_arrays(lines, lens.size, focal_px=f_px)
        made = calibrate(obs, "opencv", free=("k1", "k2", "k3"))
        assert made.converged
        assert made.displacement is not None
        assert made.jackknife_displacement is not None
        sizes = (made.sigma_px, made.displacement.worst_px, made.jackknife_displacement.worst_px)
        told.append(sizes)
    assert told[1] == pytest.approx(told[0], rel=1e-6)


@pytest.mark.parametrize("aspect", [0.5, 2.0])
@pytest.mark.parametrize("robust", [False, True])
def test_residuals_are_in_the_photograph_s_own_pixels(aspect: float, robust: bool) -> None:
    lens = TrueLens("ptlens", MILD, aspect=aspect)
    made = calibrate(picked(lens, noise_px=1.0), robust=robust)
    square, step = np.array([aspect, 1.0]), 0.01
    for line, residuals in zip(made.observations.lines, made.residuals_px, strict=True):
        ideal = made.lens.undistort(line.points_px) * square
        middle = ideal.mean(axis=0)
        normal = np.linalg.svd(ideal - middle)[2][1]

        def away(points: Array, middle: Array = middle, normal: Array = normal) -> Array:
            return (made.lens.undistort(points) * square - middle) @ normal

        slopes = [
            (away(line.points_px + move) - away(line.points_px - move)) / (2 * step)
            for move in np.eye(2) * step
        ]
        expected = np.abs(away(line.points_px)) / np.hypot(*slopes)
        np.testing.assert_allclose(np.abs(residuals), expected, rtol=1e-4, atol=1e-7)
    assert made.sigma_px == pytest.approx(1.0, rel=0.15)

"""Figures: what they show is what was fitted, and every axis says its unit."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from lxml import etree  # pyright: ignore[reportAttributeAccessIssue]

import plumbline
from plumbline.report.figures import FIGURES, Subject, encoding, style
from plumbline.report.figures.curve import band_px
from plumbline.report.figures.maps import displacement_px
from plumbline.report.figures.photo import magnification
from plumbline.report.figures.subject import drawn_lines, round_factor
from plumbline.result.calibration import Calibration
from tests.report.made import HEIGHT, WIDTH, B, building, grid, hostile, observed

UNITS = (", px", "px of the corrected photo", "corner)", "line")


def svg(name: str, made: Calibration) -> bytes:
    with style.drawing():
        return encoding.svg_bytes(FIGURES[name](Subject(made)))


@pytest.mark.parametrize("name", FIGURES)
def test_every_axis_says_what_it_shows_and_in_which_unit(name: str) -> None:
    with style.drawing():
        figure = FIGURES[name](Subject(building()))
        figure.draw_without_rendering()
    shared = [figure.get_supxlabel(), figure.get_supylabel()]
    for axes in figure.axes:
        if not axes.get_visible():
            continue
        x, y = axes.get_xlabel() or shared[0], axes.get_ylabel() or shared[1]
        below = any(axes.get_shared_x_axes().joined(axes, other) for other in figure.axes[1:])
        assert y.endswith(UNITS) or ", px" in y
        assert "px" in x or x.startswith("line") or below or name in ("displacement", "uncertainty")


@pytest.mark.parametrize("name", FIGURES)
def test_the_same_input_gives_the_same_bytes(name: str) -> None:
    assert svg(name, building()) == svg(name, building())


def test_the_users_matplotlibrc_changes_nothing(tmp_path: Path) -> None:
    rc = tmp_path / "matplotlibrc"
    rc.write_text("font.size: 30\naxes.facecolor: red\nsvg.fonttype: path\nsavefig.dpi: 11\n")
    program = (
        "import sys\nfrom tests.report.figures.test_figures import svg\n"
        "from tests.report.made import building\n"
        "sys.stdout.buffer.write(svg('curve', building()))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program],
        cwd=Path(__file__).parents[3],
        env={"MATPLOTLIBRC": str(rc), "HOME": str(tmp_path), "PATH": ""},
        capture_output=True,
        check=True,
    )
    assert done.stdout == svg("curve", building())


@pytest.mark.parametrize("name", FIGURES)
@pytest.mark.parametrize("robust", [False, True])
def test_names_from_files_are_text(name: str, robust: bool) -> None:
    root = etree.fromstring(svg(name, hostile(robust=robust)))
    assert not [e for e in root.iter() if etree.QName(e).localname.lower() == "script"]


@pytest.mark.parametrize("name", FIGURES)
def test_a_fit_without_any_error_is_drawn(name: str) -> None:
    lines = grid(noise_px=0.0)
    made = plumbline.calibrate(
        plumbline.Observations.from_arrays(lines, size=(WIDTH, HEIGHT)), free=("b",)
    )
    assert svg(name, made)


@pytest.mark.parametrize("name", FIGURES)
def test_many_picks_become_pixels(name: str) -> None:
    rng = np.random.default_rng(0)
    lines = [
        np.stack((np.sort(rng.uniform(5, WIDTH - 5, 100)), np.full(100, y)), axis=-1)
        for y in np.linspace(10, HEIGHT - 10, 60)
    ]
    noisy = [observed(line) + rng.normal(0, 0.2, line.shape) for line in lines]
    made = plumbline.calibrate(
        plumbline.Observations.from_arrays(noisy, size=(WIDTH, HEIGHT)), free=("b",)
    )
    assert len(svg(name, made)) < 500_000


def collinear(points: np.ndarray) -> float:
    """How far points of shape (n, 2) are from one line."""
    return float(np.linalg.svd(points - points.mean(axis=0))[1][1])


def test_fitted_lines_are_straight_without_the_lens() -> None:
    made = building()
    for line in drawn_lines(made):
        assert collinear(made.lens.undistort(line.curve_px)) < 1e-6
        both = np.concatenate((line.foot_px, line.curve_px))
        assert collinear(made.lens.undistort(both)) < 1e-6


def test_residuals_are_the_way_from_the_fitted_line_to_the_pick() -> None:
    made = building()
    centre = np.array(made.lens.centre_px)
    for line, residuals in zip(drawn_lines(made), made.residuals_px, strict=True):
        away = line.observed_px - line.foot_px
        assert np.hypot(*away.T) == pytest.approx(np.abs(residuals), rel=0.06, abs=0.002)
        assert np.abs(line.residual_px) == pytest.approx(np.abs(residuals), abs=1e-6)
        # Along a line the direction from the centre turns, but its part across never does.
        across = np.sum(away * (line.foot_px.mean(axis=0) - centre), axis=1)
        clear = np.abs(across) > 30
        assert np.array_equal(np.sign(line.residual_px[clear]), np.sign(across[clear]))


def test_the_stated_magnification_is_the_drawn_one() -> None:
    made = building()
    with style.drawing():
        figure = FIGURES["photo"](Subject(made))
    whiskers = next(
        c for c in figure.axes[0].collections if str(c.get_label()).startswith("residuals")
    )
    factor = float(whiskers.get_label().split()[-2])
    assert factor == magnification(list(drawn_lines(made)), 1504)
    drawn = np.array([path.vertices for path in whiskers.get_paths()])
    length = np.hypot(*(drawn[:, 1] - drawn[:, 0]).T)
    residuals = np.concatenate(made.residuals_px)
    assert length == pytest.approx(factor * np.abs(residuals), rel=0.06, abs=0.002 * factor)


@pytest.mark.parametrize(
    ("wanted", "size", "factor"),
    [(100, 1, 100), (99, 1, 50), (10, 4, 2), (1, 3, 1), (5, 0, 1), (20.1, 1e-3, 20000), (3, 1, 2)],
)
def test_factors_are_round(wanted: float, size: float, factor: float) -> None:
    assert round_factor(wanted, size) == factor


def test_displacement_in_closed_form() -> None:
    zero = {"a": 0.0, "b": B, "c": 0.0, "d": 0.0, "e": 0.0}
    lens = plumbline.Lens(plumbline.get_model("ptlens"), plumbline.Frame(WIDTH, HEIGHT), zero)
    ideal = np.array([[600.0, 239.5], [319.5, 20.0], [600.0, 20.0]])
    q = (ideal - [319.5, 239.5]) / (HEIGHT / 2)
    # At the scale of the centre, 1 − b, the lens moves q by b |q|² q.
    expected = B * (q**2).sum(axis=1, keepdims=True) * q * HEIGHT / 2
    assert displacement_px(lens, observed(ideal)) == pytest.approx(expected, abs=1e-9)


def test_displacement_does_not_depend_on_the_direction_of_the_polynomial() -> None:
    frame = plumbline.Frame(WIDTH, HEIGHT)
    names = {"d": 3.0, "e": -2.0}
    inwards = plumbline.Lens(plumbline.get_model("radial:2"), frame, names | {"a2": 0.05})
    points = np.array([[600.0, 100.0], [40.0, 470.0]])
    centre = np.array([322.5, 237.5])
    q = (points - centre) / (HEIGHT / 2)
    expected = -0.05 * (q**2).sum(axis=1, keepdims=True) * q * HEIGHT / 2
    assert displacement_px(inwards, points) == pytest.approx(expected, abs=1e-9)


def test_the_band_ends_with_the_photo() -> None:
    made = building()
    corner = float(np.hypot(2256, 1504) / 2)
    band = band_px(made, np.array([0.0, 500.0, corner - 2, corner + 5]))
    assert band is not None
    assert 0 < band[1] < band[2]
    assert np.isnan(band[3])


def test_the_band_is_that_of_the_error_to_quote() -> None:
    made = building()
    assert made.quoted is not None
    worst = made.quoted.total.worst_at_px[0]
    radius = float(np.hypot(*(worst - made.lens.centre_px)))
    band = band_px(made, np.array([radius]))
    assert band is not None
    # Directions are 22.5° apart: the worst place lies between two of them.
    assert band[0] == pytest.approx(1.96 * made.quoted.worst_px, rel=0.1)
    assert made.displacement is not None
    assert band[0] > 2.5 * made.displacement.worst_px


def test_an_upright_photo_among_sideways_ones() -> None:
    """Its fitted lines lie on its picks, in its own pixels."""
    lines = grid()
    turned = [line[:, ::-1].copy() for line in grid(8)]
    wide, tall = plumbline.Photo((WIDTH, HEIGHT)), plumbline.Photo((HEIGHT, WIDTH), number=1)
    observations = plumbline.Observations(
        (wide, tall),
        tuple(
            plumbline.Line(points, photo, f"{photo} {index}")
            for photo, each in enumerate((lines, turned))
            for index, points in enumerate(each)
        ),
    ).checked()
    made = plumbline.calibrate(observations, free=("b",))
    for line in drawn_lines(made):
        assert np.hypot(*(line.foot_px - line.observed_px).T).max() < 0.5


def test_pixels_that_are_not_square() -> None:
    """Feet and distances are in the photo's own pixels."""
    lines = [line * [0.5, 1.0] + [-0.25, 0.0] for line in grid()]
    observations = plumbline.Observations.from_arrays(
        lines, size=(WIDTH // 2, HEIGHT), pixel_aspect=2.0
    )
    made = plumbline.calibrate(observations, free=("b",))
    for line in drawn_lines(made):
        away = line.foot_px - line.observed_px
        assert np.hypot(*away.T) == pytest.approx(np.abs(line.residual_px), rel=0.06, abs=0.002)
        assert line.radius_px.max() <= np.hypot(WIDTH, HEIGHT) / 2


@pytest.mark.parametrize("name", FIGURES)
def test_a_fold_inside_the_photo_is_drawn_round(name: str) -> None:
    """The picks end before the fold; what lies beyond has neither displacement nor band."""
    middle = [line for line in grid() if np.hypot(*(line - [319.5, 239.5]).T).max() < 350]
    made = plumbline.calibrate(
        plumbline.Observations.from_arrays(middle, size=(WIDTH, HEIGHT)), free=("b",)
    )
    lens = plumbline.Lens(
        made.lens.model, plumbline.Frame(3 * WIDTH, 3 * HEIGHT), made.coefficients | {"b": -0.12}
    )
    folded = replace(made, lens=lens)
    assert lens.fold_radius_px() is not None
    assert folded.displacement is None
    assert svg(name, folded)

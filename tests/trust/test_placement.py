"""Checks of where lines lie, on layouts made to fail one by one, each with its remedy."""

from __future__ import annotations

import numpy as np
import pytest

from plumbline import Observations
from plumbline.observations import Line, Photo
from plumbline.trust.check import Check
from plumbline.trust.placement import before_fit, extrapolated_share, placed_lines
from tests.truth import Array

SIZE = WIDTH, HEIGHT = 3000, 2000


def level(y: float, left: float = 60, right: float = 2940, n: int = 8) -> Array:
    return np.stack((np.linspace(left, right, n), np.full(n, y)), axis=1)


def upright(x: float, top: float = 40, bottom: float = 1960, n: int = 8) -> Array:
    return np.stack((np.full(n, x), np.linspace(top, bottom, n)), axis=1)


GOOD = [level(60), level(650), level(1940), upright(80), upright(950), upright(2920)]


def checked(lines: list[Array], n_free: int = 3) -> dict[str, Check]:
    """By name, each with a remedy if and only if it failed."""
    checks = before_fit(Observations.from_arrays(lines, SIZE), n_free, n_free)
    for check in checks:
        assert bool(check.remedy) != check.passed
        assert check.finding in check.sentence
        assert check.remedy in check.sentence
    return {check.name: check for check in checks}


def failed(lines: list[Array], n_free: int = 3) -> set[str]:
    return {name for name, check in checked(lines, n_free).items() if not check.passed}


def test_good_lines_pass() -> None:
    assert failed(GOOD) == set()


def test_lines_are_placed_as_they_lie() -> None:
    placed = placed_lines(Observations.from_arrays([level(199.5), upright(2249.5)], SIZE))
    np.testing.assert_allclose(placed.outward, [0.8, 0.5], rtol=1e-12)
    np.testing.assert_allclose(placed.length, [2880 / 2000, 1920 / 2000], rtol=1e-12)
    np.testing.assert_allclose(placed.angle, [-np.pi / 2, 0.0], atol=1e-12)
    # A magnification of 1 + 0.01 r² moves the middle of the line by 0.01 h (h / R)² and its ends
    # by 0.01 h (h² + L²) / R²: 0.01 h L² / R² further.
    np.testing.assert_allclose(placed.bend, [0.01 * 800 * 1.44**2, 0.01 * 750 * 0.96**2], rtol=1e-9)


def test_pixels_that_are_not_square_count_as_wide_as_they_are() -> None:
    square = placed_lines(Observations.from_arrays(GOOD, SIZE))
    # The same photo on pixels half as wide again: two thirds as many of them in a row.
    video = [(line + 0.5) / (1.5, 1.0) - 0.5 for line in GOOD]
    found = placed_lines(Observations.from_arrays(video, (2000, 2000), pixel_aspect=1.5))
    for name in ("outward", "length", "bend", "angle"):
        np.testing.assert_allclose(getattr(found, name), getattr(square, name), rtol=1e-9)


def test_too_few_points() -> None:
    few = [level(60, n=3), level(650, n=3), upright(80, n=4), upright(2920, n=4)]
    check = checked(few, 3)["points"]
    assert not check.passed
    assert "14 points on 4 lines leave 3 degrees of freedom for 3 coefficients" in check.finding
    assert (
        "3 degrees of freedom are uncertain themselves; pick at least 3 more points" in check.remedy
    )
    assert checked([*few, level(1940, n=5)], 3)["points"].passed
    fewer = checked(few, 5)["points"]
    assert "leave 1 degree of freedom for 5 coefficients" in fewer.finding
    assert "from 1 degree of freedom are nearly worthless; pick at least 5 more" in fewer.remedy


@pytest.mark.parametrize(("n_free", "more"), [(6, 6), (8, 8)])
def test_no_degrees_of_freedom_at_all(n_free: int, more: int) -> None:
    few = [level(60, n=3), level(650, n=3), upright(80, n=4), upright(2920, n=4)]
    check = checked(few, n_free)["points"]
    assert check.finding == (
        f"14 points on 4 lines are too few for {n_free} coefficients: 2 of each line only place "
        "it, which leaves 6"
    )
    assert check.remedy.startswith(f"pick at least {more} more along the lines")


def test_picks_that_leave_the_outside_to_extrapolation() -> None:
    inner = [level(300, 600, 2400), level(800, 600, 2400), upright(600, 300, 1700)]
    check = checked(inner)["radius"]
    assert not check.passed
    assert "nearer to the corners" in check.remedy
    obs = Observations.from_arrays(inner, SIZE)
    reached = np.hypot(1499.5 - 600, 999.5 - 300)
    assert f"{100 * reached / np.hypot(1500, 1000):.0f} % of the way" in check.finding
    # Of the photo, by counting its pixels.
    x, y = np.meshgrid(np.arange(0, WIDTH, 5) - 1499.5, np.arange(0, HEIGHT, 5) - 999.5)
    share = float(np.mean(np.hypot(x, y) > reached))
    assert extrapolated_share(obs) == pytest.approx(share, abs=0.02)
    assert extrapolated_share(Observations.from_arrays(GOOD, SIZE)) < 0.01


def test_lines_in_one_quadrant() -> None:
    quadrant = [
        level(60, 60, 1400),
        level(600, 60, 1400),
        upright(80, 40, 900),
        upright(900, 40, 900),
    ]
    checks = checked(quadrant)
    assert failed(quadrant) >= {"corners"}
    assert "the top right, bottom right and bottom left corners" in checks["corners"].finding
    assert "top left" not in checks["corners"].finding
    assert checks["corners"].remedy == "pick lines that run into the corners"
    every = checked([level(60), level(1940)])["corners"]
    assert every.finding == "there are picks near all four corners"
    assert every.passed
    assert not every.doubtful


@pytest.mark.parametrize(
    ("lines", "bare"),
    [
        ([level(60), level(1940, 60, 900)], "bottom right corner"),
        ([level(60), level(650)], "bottom right and bottom left corners"),
    ],
)
def test_one_or_two_bare_corners_deserve_a_look(lines: list[Array], bare: str) -> None:
    check = checked(lines)["corners"]
    assert check.finding == f"there are no picks near the {bare}"
    assert (check.passed, check.doubtful) == (True, True)


def test_corners_are_those_of_each_photo() -> None:
    """A standing photo beside a lying one, with picks in the corners of the standing one alone."""
    photos = (Photo(SIZE), Photo((HEIGHT, WIDTH)))
    inner, left, right = level(650, 900, 2100), upright(100, 100, 2900), upright(1900, 100, 2900)
    lines = (Line(inner, 0), Line(left, 1), Line(right, 1))
    check = {c.name: c for c in before_fit(Observations(photos, lines), 1, 1)}["corners"]
    assert check.finding == "there are picks near all four corners"


def test_lines_through_the_centre() -> None:
    turns = np.linspace(0, np.pi, 7)[:-1]
    along = np.linspace(-900, 900, 8)[:, None]
    central = [(1499.5, 999.5) + along * (np.cos(turn), np.sin(turn)) for turn in turns]
    check = checked(central)["central lines"]
    assert not check.passed
    assert check.finding.startswith("6 lines (1, 2, 3, 4, 5, 6) run too close to the centre")
    assert "near the edges" in check.remedy
    assert not checked(GOOD)["central lines"].doubtful
    near = level(1004.5)  # 5 px off the centre, where 1 % of magnification bends it by 0.1 px
    told = checked([*GOOD, central[0], near])["central lines"]
    assert told.passed
    assert told.doubtful
    assert told.finding.startswith("2 lines (7, 8) run too close to the centre")
    alone = checked([*GOOD, level(1029.5)])["central lines"]  # here by 0.6 px
    assert not alone.doubtful


@pytest.mark.parametrize(
    ("lines", "n_radial", "edge"),
    [
        ([level(650), level(1350), upright(950), upright(1950)], 3, ""),
        ([level(650), level(1500), upright(950), upright(2050)], 1, "top"),
        ([level(500), level(1350), upright(950), upright(2050)], 1, "bottom"),
        ([level(500), level(1500), upright(1050), upright(2050)], 1, "left"),
        ([level(500), level(1500), upright(950), upright(1950)], 1, "right"),
    ],
)
def test_no_line_near_an_edge(lines: list[Array], n_radial: int, edge: str) -> None:
    check = checked(lines, n_radial)["profile makers' rule"]
    assert not check.passed
    assert check.finding.startswith("0 long lines near the edge")
    assert f"near the {edge}" in check.remedy


def test_no_line_a_third_of_the_way_out_matters_to_two_coefficients_alone() -> None:
    outer = [level(60), level(1940), upright(80), upright(2920)]
    check = checked(outer, 2)["profile makers' rule"]
    assert not check.passed
    assert "a third of the way from the centre" in check.remedy
    assert check.finding == (
        "4 long lines near the edge, 0 about a third of the way out; at least one of each is needed"
    )
    assert checked(outer, 1)["profile makers' rule"].passed
    assert checked([level(60)], 1)["profile makers' rule"].passed


def test_short_lines_do_not_count_for_the_rule() -> None:
    short = [level(60, 60, 600), level(650, 60, 600), upright(80, 40, 500)]
    assert "profile makers' rule" in failed(short)


def test_one_line_of_three_points_is_checked_too() -> None:
    assert failed([level(60, n=3)]) >= {"points", "corners"} - {"corners"}

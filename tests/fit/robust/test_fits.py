"""Suspicious picks: named, said what they look like, left out on demand and never otherwise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache as remembered

import numpy as np
import pytest

from plumbline import Observations, calibrate
from plumbline.errors import DegenerateLinesError
from plumbline.fit.bootstrap import bootstrap
from plumbline.observations import Line, Photo
from plumbline.result.calibration import Calibration
from plumbline.result.files import consistent_results
from plumbline.result.writing import to_json
from plumbline.trust.assessment import ResidualKind
from tests.fit.test_calibrate import ACTION_CAMERAS, MILD, picked
from tests.many import all_calibrated
from tests.truth import Array, TrueLens

BARREL = TrueLens("ptlens", {"a": 0.02, "b": -0.09, "c": -0.02})
NOISE_PX = 0.4
SWAPPED = {(2, 3), (5, 7), (8, 1)}
MOVED = {(0, 4): (25.0, 30.0), (3, 2): (-40.0, 9.0), (6, 8): (30.0, -12.0), (11, 6): (18.0, 0.0)}


@remembered
def clean() -> tuple[Array, ...]:
    return tuple(BARREL.lines(noise_px=NOISE_PX, seed=5))


def observed(lines: list[Array]) -> Observations:
    return Observations.from_arrays(lines, BARREL.size)


def moved(places: dict[tuple[int, int], tuple[float, float]] = MOVED) -> Observations:
    lines = [line.copy() for line in clean()]
    for (line, pick), by in places.items():
        lines[line][pick] += by
    return observed(lines)


def named(made: Calibration) -> set[tuple[int, int]]:
    """Line and place of every pick that is left out, or would be."""
    return {(s.line, pick) for s in made.suspects if s.left_out for pick in s.picks}


def left_out(made: Calibration) -> set[tuple[int, int]]:
    return {
        (line, int(pick)) for line, kept in enumerate(made.kept) for pick in np.flatnonzero(~kept)
    }


def without(obs: Observations, places: set[tuple[int, int]]) -> Observations:
    """Only the good picks."""
    lines = [
        replace(
            line, points_px=np.delete(line.points_px, sorted(p for n, p in places if n == i), 0)
        )
        for i, line in enumerate(obs.lines)
    ]
    return replace(obs, lines=tuple(line for line in lines if len(line.points_px) > 2))


def assert_same_fit(made: Calibration, told: Calibration, within_px: float = 1e-6) -> None:
    grid = np.stack(np.meshgrid(np.linspace(0, 2999, 9), np.linspace(0, 2249, 9)), -1)
    apart = made.lens.undistort(grid) - told.lens.undistort(grid)
    assert np.max(np.abs(apart)) < within_px
    assert made.dof == told.dof
    assert made.sigma_px == pytest.approx(told.sigma_px, rel=1e-6)
    assert made.rms_after_px == pytest.approx(told.rms_after_px, rel=1e-6)
    assert made.rms_before_px == pytest.approx(told.rms_before_px, rel=1e-9)
    np.testing.assert_allclose(made.covariance, told.covariance, rtol=1e-4)


def test_good_picks_are_not_suspected() -> None:
    made = calibrate(observed(list(clean())))
    assert made.suspects == ()
    assert not made.robust
    robust = calibrate(observed(list(clean())), robust=True)
    assert robust.robust
    assert left_out(robust) == set()
    assert robust.coefficients == made.coefficients


def test_of_clean_projects_one_in_fifty_at_most_names_a_pick() -> None:
    """At that rate six or more of 128 would have a chance of 5 %."""
    rng = np.random.default_rng(10)
    exact = BARREL.lines()
    every = [
        observed([line + rng.normal(0, NOISE_PX, line.shape) for line in exact]) for _ in range(128)
    ]
    assert sum(bool(made.suspects) for made in all_calibrated(every)) <= 5


@pytest.mark.parametrize("share", [300, 200])
def test_careless_picks_are_not_wrong_ones(share: int) -> None:
    """Five a line with σ of 1/300 and 1/200 of the shorter side."""
    rng = np.random.default_rng(share)
    exact = BARREL.lines(14, 5)
    sigma_px = min(BARREL.size) / share
    noisy = [line + rng.normal(0, sigma_px, line.shape) for line in exact]
    made = calibrate(observed([line.clip(0, np.array(BARREL.size) - 1) for line in noisy]))
    assert made.suspects == ()


def test_picks_at_whole_pixels_are_not_wrong_ones() -> None:
    small = TrueLens("ptlens", {"a": 0.01, "b": -0.05, "c": 0.01}, (320, 240))
    lines = [np.rint(line) for line in small.lines(12, 100)]
    assert calibrate(Observations.from_arrays(lines, small.size)).suspects == ()


@pytest.mark.parametrize("lens", [MILD, *ACTION_CAMERAS])
def test_picks_without_noise_are_not_suspected(lens: dict[str, float]) -> None:
    assert calibrate(picked(TrueLens("ptlens", lens))).suspects == ()


def test_moved_picks_are_named_and_a_plain_fit_uses_them() -> None:
    made = calibrate(moved())
    assert named(made) == set(MOVED)
    assert left_out(made) == set()
    assert made.dof == 192 - 32 - 3
    assert not made.robust
    for suspect in made.suspects:
        assert suspect.kind == "stray"
        place = suspect.picks[0]
        x, y = made.observations.lines[suspect.line].points_px[place]
        assert (
            f"pick {place + 1} of line {suspect.line + 1} at ({x:.0f}, {y:.0f})" in suspect.sentence
        )
        assert suspect.studentised > 8
    (told,) = [check for check in made.checks if check.name == "suspects"]
    assert told.finding == "4 picks of 192 are suspicious"
    assert "--robust" in told.remedy


def test_a_plain_fit_is_what_it_is_without_the_search(monkeypatch: pytest.MonkeyPatch) -> None:
    def no_search(problems: Sequence[object], _: object) -> list[None]:
        return [None] * len(problems)

    made = calibrate(moved())
    monkeypatch.setattr("plumbline.fit.single.robust_fits", no_search)
    blind = calibrate(moved())
    assert made.suspects
    assert not blind.suspects
    assert made.coefficients == blind.coefficients
    assert (made.dof, made.sigma_px, made.rms_after_px) == (
        blind.dof,
        blind.sigma_px,
        blind.rms_after_px,
    )
    np.testing.assert_array_equal(made.covariance, blind.covariance)
    for one, other in zip(made.residuals_px, blind.residuals_px, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("residual", ["image", "corrected"])
def test_a_robust_fit_is_the_fit_of_the_good_picks(residual: ResidualKind) -> None:
    made = calibrate(moved(), robust=True, residual=residual)
    assert left_out(made) == named(made) == set(MOVED)
    told = calibrate(without(moved(), set(MOVED)), residual=residual)
    assert_same_fit(made, told)
    assert made.rms_corrected_px == pytest.approx(told.rms_corrected_px, rel=1e-6)
    for line, fewer in zip(made.lines, told.lines, strict=True):
        assert line.n_points == fewer.n_points
        assert line.rms_after_px == pytest.approx(fewer.rms_after_px, rel=1e-5)
    (check,) = [each for each in made.checks if each.name == "suspects"]
    assert check.finding == "4 picks of 192 left out as suspicious"


def test_the_residual_of_a_pick_left_out_is_how_far_it_was_moved() -> None:
    made = calibrate(moved({(0, 5): (3.0, 40.0)}), robust=True)
    assert left_out(made) == {(0, 5)}
    (suspect,) = made.suspects
    # Line 0 runs level, and bends little where it is: 40 px down, but for the noise.
    assert suspect.residual_px == pytest.approx(40, abs=1.5)
    assert abs(made.residuals_px[0][5]) == pytest.approx(suspect.residual_px, rel=1e-9)


def test_held_coefficients_and_start_vectors() -> None:
    made = calibrate(moved(), free=("b",), start={"a": 0.02, "c": -0.02}, robust=True)
    assert made.held == {"a": 0.02, "c": -0.02, "d": 0.0, "e": 0.0}
    assert left_out(made) == set(MOVED)
    started = calibrate(moved(), start={"a": 0.01, "b": -0.05}, robust=True)
    assert left_out(started) == set(MOVED)
    assert_same_fit(started, calibrate(moved(), robust=True))
    assert not any("worse fit" in note for note in started.notes)


def test_many_name_the_same_as_one_by_one() -> None:
    twice = moved({(1, 3): (30.0, 0.0)})
    every = [moved(), observed(list(clean())), twice, picked(TrueLens("ptlens", MILD)), moved()]
    for together, obs in zip(all_calibrated(every), every, strict=True):
        alone = calibrate(obs)
        assert [(s.line, s.picks, s.kind) for s in together.suspects] == [
            (s.line, s.picks, s.kind) for s in alone.suspects
        ]
    for together, obs in zip(all_calibrated(every, robust=True), every, strict=True):
        assert left_out(together) == left_out(calibrate(obs, robust=True))


def exchanged() -> Observations:
    """Picks of three lines are given to the next but one, and one pair changes places."""
    lines = [line.copy() for line in clean()]
    for line, pick in SWAPPED:
        lines[line][pick] = lines[(line + 2) % 16][pick]
    lines[12][4], lines[14][4] = lines[14][4].copy(), lines[12][4].copy()
    return observed(lines)


def test_picks_of_other_lines_say_which() -> None:
    with pytest.raises(DegenerateLinesError, match="not lie on straight lines") as caught:
        calibrate(exchanged())
    assert "--robust fits the others" in caught.value.hint
    made = calibrate(exchanged(), robust=True)
    assert left_out(made) == named(made)
    assert named(made) == SWAPPED | {(12, 4), (14, 4)}
    kinds = {(s.line, s.picks[0]): s for s in made.suspects if s.left_out}
    for line, pick in SWAPPED:
        assert kinds[line, pick].kind == "other line"
        assert f"fits line {line + 3} within" in kinds[line, pick].sentence
    assert kinds[12, 4].kind == kinds[14, 4].kind == "exchanged"
    assert "exchanged with pick 5 of line 15" in kinds[12, 4].sentence
    assert "exchanged with pick 5 of line 13" in kinds[14, 4].sentence


def test_a_quarter_of_bad_picks_does_not_hide_itself() -> None:
    rng = np.random.default_rng(3)
    lines = [line.copy() for line in clean()]
    bad = {(int(n) // 12, int(n) % 12) for n in rng.choice(192, 48, replace=False)}
    for line, pick in bad:
        angle = rng.uniform(0, 2 * np.pi)
        step = rng.uniform(20, 90) * np.array([np.cos(angle), np.sin(angle)])
        step[0 if line % 2 else 1] += 20 * np.sign(step[0 if line % 2 else 1])
        lines[line][pick] = np.clip(lines[line][pick] + step, 0, np.array(BARREL.size) - 1)
    made = calibrate(observed(lines), robust=True)
    found = left_out(made)
    assert len(found & bad) >= 0.95 * len(bad)
    assert len(found - bad) <= 0.02 * (192 - len(bad))
    error = made.lens.undistort([[0.0, 0.0]]) - calibrate(
        without(observed(lines), bad)
    ).lens.undistort([[0.0, 0.0]])
    assert np.max(np.abs(error)) < 2
    plain = calibrate(observed(lines))
    assert named(plain) == found
    assert plain.sigma_px > 10 * made.sigma_px


def test_places_picked_twice() -> None:
    lines = [line.copy() for line in clean()]
    lines[4] = np.insert(lines[4], 6, lines[4][5] + (0.3, 0.2), axis=0)
    made = calibrate(observed(lines), robust=True)
    (suspect,) = made.suspects
    assert (suspect.kind, suspect.line, suspect.picks) == ("duplicate", 4, (5, 6))
    assert not suspect.left_out
    assert suspect.residual_px == pytest.approx(np.hypot(0.3, 0.2), rel=1e-6)
    assert "counts double" in suspect.sentence
    assert left_out(made) == set()


def test_an_edge_that_bends_by_itself() -> None:
    lines = [line.copy() for line in clean()]
    lines[6][:, 1] += 3.0 * (1 - np.linspace(-1, 1, 12) ** 2)  # line 6 runs level
    made = calibrate(observed(lines))
    told = [s for s in made.suspects if s.kind == "bent line"]
    assert told
    assert {s.line for s in told} == {6}
    assert all("the edge may not be straight" in s.sentence for s in told)
    assert {s.line for s in made.suspects} == {6}


def test_a_line_with_more_wrong_than_right_picks_is_no_line() -> None:
    lines = [line.copy() for line in clean()]
    rng = np.random.default_rng(9)
    lines[10][[0, 1, 3, 4, 6, 7, 9, 10], 1] += rng.choice([-1, 1], 8) * rng.uniform(30, 90, 8)
    made = calibrate(observed(lines), robust=True)
    assert {line for line, _ in left_out(made)} == {10}
    good = calibrate(without(observed(lines), {(10, pick) for pick in range(12)}))
    apart = made.lens.undistort([[0.0, 0.0]]) - good.lens.undistort([[0.0, 0.0]])
    assert np.max(np.abs(apart)) < 2
    assert {pick for told in made.suspects for pick in told.picks} == set(range(12))
    rests = [told for told in made.suspects if told.kind == "no line"]
    assert len(rests) == 1
    assert "too few picks of line 11 agree on a straight line" in rests[0].sentence
    assert all(told.kind in ("no line", "stray", "other line") for told in made.suspects)
    # They are measured from a line of their own.
    assert 20 < made.lines[10].rms_after_px < 90
    assert made.lines[10].n_points == 0
    (back,) = consistent_results(to_json([made]), "x.json")
    assert left_out(back) == left_out(made)
    assert back.suspects == made.suspects


def test_lines_of_three_picks() -> None:
    lines = [line[[0, 5, 11]].copy() for line in clean()]
    assert calibrate(observed(lines)).suspects == ()
    lines[4][1] += (0.0, 60.0)
    made = calibrate(observed(lines), robust=True)
    assert {line for line, _ in left_out(made)} <= {4}
    assert made.dof >= 16 * 3 - 32 - 3 - 1
    assert {s.line for s in made.suspects} == {4}


def test_the_least_that_can_be_fitted() -> None:
    """One line of three picks for nothing free but b would have no degrees of freedom left."""
    line = clean()[0]
    made = calibrate(observed([line[[0, 3, 7, 11]]]), free=("b",), robust=True)
    assert made.dof == 1
    assert made.jackknife is None
    assert made.jackknife_displacement is None
    assert left_out(made) == set()
    assert made.intervals["b"][1] - made.intervals["b"][0] == pytest.approx(
        2 * 12.706204736 * made.standard_errors["b"], rel=1e-9
    )
    assert consistent_results(to_json([made]), "x.json")[0].notes == made.notes
    with pytest.raises(DegenerateLinesError):
        calibrate(observed([line[[0, 5, 11]]]), free=("b",), robust=True)


def test_several_photos_upright_and_sideways() -> None:
    lying, standing = BARREL, TrueLens("ptlens", BARREL.coefficients, (2250, 3000))
    lines = [Line(points.copy(), 0, f"l{i}") for i, points in enumerate(clean()[::2])]
    others = standing.lines(noise_px=NOISE_PX, seed=6)[1::2]
    lines += [Line(points.copy(), 1, f"s{i}") for i, points in enumerate(others)]
    lines[2].points_px[4] += (10.0, 35.0)
    lines[11].points_px[7] += (35.0, 20.0)
    # A pick on a line of the other photo alone is a stray.
    obs = Observations((Photo(lying.size), Photo(standing.size)), tuple(lines)).checked()
    made = calibrate(obs, robust=True)
    assert left_out(made) == {(2, 4), (11, 7)}
    (first, second) = made.suspects
    x, y = lines[11].points_px[7]
    assert f"pick 8 of line s3 at ({x:.0f}, {y:.0f})" in second.sentence
    assert first.line == 2
    told = calibrate(without(obs, {(2, 4), (11, 7)}))
    assert_same_fit(made, told)


def test_a_stray_beyond_the_fold_is_left_out_and_has_no_residual() -> None:
    folding = TrueLens("ptlens", {"a": 0.0, "b": -0.2, "c": 0.0}, (3000, 2250))
    rng = np.random.default_rng(4)
    share = np.linspace(-1.0, 1.0, 12)[:, None]
    ideal = [
        (1499.5, 1124.5) + share * (0, 850) + (at, 0) for at in np.linspace(-1000, 1000, 8)
    ] + [(1499.5, 1124.5) + share * (1000, 0) + (0, at) for at in np.linspace(-800, 800, 8)]
    lines = [folding.distort(line) + rng.normal(0, 0.3, (12, 2)) for line in ideal]
    lines[3][11] = 5.0, 5.0
    made = calibrate(observed(lines), free=("b",), robust=True)
    assert left_out(made) == {(3, 11)}
    assert made.residuals_px[3][11] == np.inf
    assert np.isfinite([line.rms_after_px for line in made.lines]).all()
    assert np.isfinite([made.rms_before_px, made.rms_after_px, made.largest_after_px]).all()
    assert made.jackknife is not None
    assert np.isfinite(made.jackknife.covariance).all()
    (suspect,) = made.suspects
    assert "lies beyond the fold" in suspect.sentence
    assert any("folds over" in note for note in made.notes)
    again = bootstrap(made, 50)
    assert again.bootstrap is not None
    assert again.bootstrap.failed == 0
    (back,) = consistent_results(to_json([again]), "x.json")
    assert back.residuals_px[3][11] == np.inf
    assert back.suspects == made.suspects
    assert to_json([back]) == to_json([again])
    plain = calibrate(without(observed(lines), {(3, 11)}), free=("b",))
    assert made.coefficients["b"] == pytest.approx(plain.coefficients["b"], abs=1e-8)


def test_where_too_few_picks_agree_the_plain_fit_says_so_and_the_robust_one_fails() -> None:
    """The picks of the one line that tells anything stray; the others run through the centre."""
    middle, share = np.array([1499.5, 1124.5]), np.linspace(-1, 1, 12)[:, None]
    turns = np.linspace(0.1, 3.0, 6)
    central = [middle + 900 * share * (np.cos(turn), np.sin(turn)) for turn in turns]
    rng = np.random.default_rng(8)
    telling = clean()[0] + (0.0, 120.0)
    telling[:, 1] += rng.uniform(-25, 25, 12)
    obs = observed([*(line + rng.normal(0, 0.3, (12, 2)) for line in central), telling])
    made = calibrate(obs, free=("b",))
    assert any("which picks are wrong cannot be told" in note for note in made.notes)
    assert left_out(made) == set()
    assert made.suspects == ()
    with pytest.raises(DegenerateLinesError):
        calibrate(obs, free=("b",), robust=True)

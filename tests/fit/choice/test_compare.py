"""Which model is enough: the table against independent computations, and what is recommended."""

from __future__ import annotations

from dataclasses import replace
from functools import cache as remembered
from pathlib import Path

import numpy as np
import pytest

import plumbline
from plumbline import Candidate, Comparison, Observations, calibrate, compare
from plumbline.errors import DegenerateLinesError, OptionError, PlumblineError
from plumbline.observations.facts import LensFacts
from plumbline.trust import picked as trust_picked
from plumbline.trust.displacement import displacement_errors
from plumbline.trust.linearised import linearise
from plumbline.wording import px
from tests import truth
from tests.truth import TrueLens

BUILDING = Path(__file__).parents[4] / "shared" / "data" / "olympus" / "building.pto"
BARREL = TrueLens("ptlens", {"a": 0.012, "b": -0.05, "c": 0.013})
B_ALONE = TrueLens("ptlens", {"b": -0.03})
NOISE_PX = 0.3


def picked(lens: TrueLens, noise_px: float = NOISE_PX, seed: int = 0, n: int = 16) -> Observations:
    lines = lens.lines(n, noise_px=noise_px, seed=seed)
    return Observations.from_arrays(lines, lens.size)


@remembered
def compared(name: str) -> Comparison:
    return compare(picked({"barrel": BARREL, "b alone": B_ALONE}[name]))


def row(found: Comparison, name: str) -> Candidate:
    return next(each for each in found.candidates if each.name == name)


def taken(found: Comparison) -> Candidate:
    return found.candidates[found.recommended]


def as_true(made: plumbline.Calibration) -> TrueLens:
    """The fitted lens in the independent implementation."""
    return TrueLens(made.model, made.coefficients, made.lens.frame.size)


def says_whether_b_is_enough(reason: str) -> bool:
    return reason.startswith(
        (
            "b alone is enough",
            "b alone is not enough",
            "b alone cannot be ",
            "whether b alone is enough cannot be told",
        )
    )


def compared_or_refused(picks: Observations) -> Comparison | PlumblineError:
    """What comes of picks that may be too few or too bad; nothing but a sentence is raised."""
    try:
        found = compare(picks)
    except PlumblineError as error:
        return error
    assert says_whether_b_is_enough(found.reason)
    assert found.calibration.converged
    return found


def test_rows_are_there_once_simple_ones_first() -> None:
    rows = compared("barrel").candidates
    assert len({each.name for each in rows}) == len(rows) == 13
    sizes = [len(each.free) for each in rows]
    assert sizes == sorted(sizes)
    assert all(each.calibration is not None for each in rows)


@pytest.mark.parametrize(
    ("name", "model", "free"),
    [
        ("ptlens b", "poly3", None),
        ("radial:2", "radial:2", None),
        ("poly5", "opencv", ("k1", "k2")),
        ("radial:2,4,6", "radial:2,4,6", None),
    ],
)
def test_models_that_are_the_same_in_other_words_give_one_curve(
    name: str, model: str, free: tuple[str, ...] | None
) -> None:
    picks = replace(picked(BARREL), lenses=(LensFacts(focal_px=2400.0),))
    mine, other = row(compared("barrel"), name), calibrate(picks, model, free=free)
    assert mine.calibration is not None
    grid = truth.grid_px(BARREL.size)
    here, there = mine.calibration.lens.undistort(grid), other.lens.undistort(grid)
    assert truth.unlike_px(here, there) < 1e-6


def test_aicc_is_that_of_independent_residuals() -> None:
    picks = [line.points_px for line in picked(BARREL).lines]
    for each in compared("barrel").candidates:
        assert each.calibration is not None
        residual = np.concatenate(
            truth.distances_px(as_true(each.calibration), picks, in_photo=True)
        )
        # Two numbers a line are spent on the line; σ counts as one more parameter than are free.
        n, k = residual.size - 2 * len(picks), len(each.free) + 1
        expected = n * np.log(residual @ residual / n) + 2 * k + 2 * k * (k + 1) / (n - k - 1)
        assert each.aicc == pytest.approx(expected, abs=1e-3)


@pytest.mark.parametrize("name", ["ptlens b", "ptlens a, b, c", "division l1, l2"])
def test_the_error_of_lines_left_out_is_that_of_fits_without_them(name: str) -> None:
    picks, mine = picked(BARREL), row(compared("barrel"), name)
    missed: list[truth.Array] = []
    for left in range(len(picks.lines)):
        others = [line for number, line in enumerate(picks.lines) if number != left]
        made = calibrate(replace(picks, lines=tuple(others)), mine.model, free=mine.free)
        missed += truth.distances_px(as_true(made), [picks.lines[left].points_px], in_photo=True)
    expected = np.sqrt(np.mean(np.concatenate(missed) ** 2))
    assert mine.left_out_px == pytest.approx(expected, rel=5e-3)


def test_the_difference_is_that_of_the_curves_over_the_range_of_the_picks() -> None:
    found = compared("barrel")
    best = found.candidates[found.best].calibration
    assert best is not None
    middle = (np.array(BARREL.size) - 1) / 2
    reached = max(np.max(np.hypot(*(p.points_px - middle).T)) for p in best.observations.lines)
    grid = truth.grid_px(BARREL.size, 17)
    grid = grid[np.hypot(*(grid - middle).T) <= reached]
    for each in found.candidates:
        assert each.calibration is not None
        ideal = [as_true(made).undistort(grid) for made in (best, each.calibration)]
        expected = truth.unlike_px(*ideal, perspective=bool({"p1", "p2"} & {*each.free}))
        assert each.difference_px == pytest.approx(expected, rel=0.02, abs=1e-6)


def picked_range_px(made: plumbline.Calibration) -> truth.Array:
    return trust_picked.picked_range_px(made.lens, made.observations)


def test_the_error_stated_is_the_larger_of_both_over_the_range_of_the_picks() -> None:
    for each in compared("barrel").candidates:
        made = each.calibration
        assert made is not None
        assert made.jackknife is not None
        points = picked_range_px(made)
        both = [
            displacement_errors(made.lens, made.free, covariance, points, gauge_px=points)
            for covariance in (made.covariance, made.jackknife.covariance)
        ]
        assert each.error_px == max(float(np.max(errors)) for errors in both if errors is not None)


def test_the_error_to_quote_is_that_of_the_fit() -> None:
    found = compared("barrel")
    for each in found.candidates:
        assert each.calibration is not None
        assert each.calibration.quoted is not None
        assert each.overall_error_px == each.calibration.quoted.worst_px
    made = calibrate(picked(BARREL), taken(found).model, free=taken(found).free)
    assert made.quoted is not None
    assert found.quote == found.calibration.quoted.sentence  # type: ignore[union-attr]


def test_rows_that_two_lines_cannot_determine_do_not_enter() -> None:
    """LensFun's prescription: one line at the edge, one a third of the way in."""
    height = BARREL.size[1]
    lines = []
    for y in (0.04 * height, 0.33 * height):
        x = np.linspace(0.03, 0.97, 400) * BARREL.size[0]
        first, last = BARREL.undistort(np.array([[x[0], y], [x[-1], y]]))
        share = np.linspace(0, 1, 12)[:, None]
        picks = BARREL.distort(first * (1 - share) + last * share)
        lines.append(picks + np.random.default_rng(len(lines)).normal(0, 0.3, picks.shape))
    found = compare(Observations.from_arrays(lines, BARREL.size))
    off = [each for each in found.candidates if each.failure.startswith("not determined: ")]
    assert off
    assert all(each.aicc is None for each in off)
    assert taken(found) not in off
    grid = picked_range_px(found.calibration)
    ideal = BARREL.undistort(grid), found.calibration.lens.undistort(grid)
    assert (taken(found).overall_error_px or 0.0) < 10 * max(truth.unlike_px(*ideal), 1.0)


def test_where_models_part_beyond_the_picks_is_told() -> None:
    found = compared("barrel")
    grid = truth.grid_px(BARREL.size, 17)
    mine = as_true(found.calibration).undistort(grid)
    named = next(e for e in found.candidates if f"differs from {e.name}, which" in found.beyond)
    assert named.calibration is not None
    far_px = truth.unlike_px(mine, as_true(named.calibration).undistort(grid))
    assert f"by up to {px(far_px)}: pick lines there before" in found.beyond


def test_the_recommended_fit_is_that_of_calibrate() -> None:
    found = compared("barrel")
    again = calibrate(picked(BARREL), taken(found).model, free=taken(found).free)
    assert found.calibration.coefficients == again.coefficients
    assert found.calibration is taken(found).calibration


def test_b_alone_is_mostly_enough_for_a_lens_of_b_alone_and_few_picks() -> None:
    found = [compare(picked(B_ALONE, noise_px=0.5, seed=seed, n=8)) for seed in range(8)]
    alone = [each.recommended == 0 for each in found]
    assert np.count_nonzero(alone) >= 5
    for each in found:
        assert each.reason.startswith("b alone is not enough") == (each.recommended != 0)


def test_b_alone_is_not_enough_for_a_lens_that_it_cannot_follow() -> None:
    found = compare(picked(TrueLens("ptlens", {"a": 0.06, "b": -0.17, "c": 0.12})))
    alone = found.candidates[0]
    assert len(taken(found).free) >= 2
    assert found.reason.startswith("b alone is not enough: within the range of the picks its curve")
    assert alone.left_out_px is not None
    assert px(alone.left_out_px) in found.reason


def test_the_centre_is_not_freed_for_a_lens_in_the_middle() -> None:
    for name in ("barrel", "b alone"):
        found = compared(name)
        assert not {"d", "e", "p1", "p2"} & {*taken(found).free}
        assert found.centre.startswith("the distortion centre of ptlens a, b, c, if freed, lies at")


def test_the_centre_is_freed_where_it_is_60_px_off_and_the_picks_are_good() -> None:
    lens = TrueLens("ptlens", {**BARREL.coefficients, "d": 48.0, "e": -36.0})
    found = compare(picked(lens, noise_px=0.1))
    made = found.calibration
    assert {"d", "e"} <= {*made.free}
    for name, value in (("d", 48.0), ("e", -36.0)):
        assert abs(made.coefficients[name] - value) < 4 * made.standard_errors[name]
    freed, held = row(found, "ptlens with centre"), row(found, "ptlens a, b, c")
    assert freed.calibration is not None
    assert f"lies at d = {freed.calibration.coefficients['d']:+.1f} ± " in found.centre
    assert freed.left_out_px is not None
    assert held.left_out_px is not None
    assert freed.left_out_px < held.left_out_px


def test_the_worked_example_is_told_whether_b_alone_is_enough() -> None:
    if not BUILDING.exists():
        pytest.skip("the worked example is not here: ../shared/data/olympus/building.pto")
    found = compare(plumbline.read(BUILDING))
    alone, default = row(found, "ptlens b"), row(found, "ptlens a, b, c")
    assert alone.calibration is not None
    assert default.calibration is not None
    # Hugin's and plumbline's documented figures for these picks.
    assert alone.calibration.rms_after_px == pytest.approx(0.5865, abs=1e-4)
    assert default.calibration.rms_after_px == pytest.approx(0.3969, abs=1e-4)
    assert found.reason.startswith("b alone is not enough: ")
    chosen_px = taken(found).left_out_px
    assert chosen_px is not None
    assert alone.left_out_px is not None
    assert chosen_px < alone.left_out_px


def test_noise_free_picks_get_the_true_curve() -> None:
    found = compare(picked(BARREL, noise_px=0.0))
    grid = truth.grid_px(BARREL.size)
    ideal = BARREL.undistort(grid), found.calibration.lens.undistort(grid)
    assert truth.unlike_px(*ideal) < 0.1
    assert says_whether_b_is_enough(found.reason)
    found = compare(picked(B_ALONE, noise_px=0.0))
    assert taken(found).name == "ptlens b"


def test_suspicious_picks_are_named_and_used() -> None:
    picks = picked(BARREL)
    points = picks.lines[3].points_px.copy()
    points[5] += 25.0
    lines = tuple(
        replace(line, points_px=points) if number == 3 else line
        for number, line in enumerate(picks.lines)
    )
    found = compare(replace(picks, lines=lines))
    assert (3, (5,)) in [(each.line, each.picks) for each in found.calibration.suspects]
    assert all(np.concatenate(found.calibration.kept))
    assert says_whether_b_is_enough(found.reason)


def spoiled(share: float, far_px: float) -> Observations:
    """Good picks, a share of which is moved anywhere near."""
    rng = np.random.default_rng(3)
    lines = [line.points_px.copy() for line in picked(BARREL).lines]
    for points in lines:
        wrong = rng.random(len(points)) < share
        points[wrong] += rng.normal(0, far_px, (np.count_nonzero(wrong), 2))
    size = np.array(BARREL.size) - 1
    return Observations.from_arrays([points.clip(0, size) for points in lines], BARREL.size)


def test_wrong_picks_that_spoil_every_fit_are_named_with_a_remedy() -> None:
    with pytest.raises(DegenerateLinesError, match="no model can be fitted: ") as caught:
        compare(spoiled(0.1, 600.0))
    assert "; suspicious: pick " in caught.value.message
    assert caught.value.hint == "correct these picks, or leave them out with --robust"


def test_a_robust_comparison_leaves_wrong_picks_out() -> None:
    found = compare(spoiled(0.1, 600.0), robust=True)
    assert found.calibration.robust
    assert sum(len(each.picks) for each in found.calibration.suspects if each.left_out) > 10
    grid = picked_range_px(found.calibration)
    ideal = BARREL.undistort(grid), found.calibration.lens.undistort(grid)
    assert truth.unlike_px(*ideal) < max(0.1, 3 * (taken(found).overall_error_px or 0.0))
    assert truth.unlike_px(*ideal) < 5


def test_photos_of_both_orientations_are_fitted_where_nothing_is_off_centre() -> None:
    width, height = BARREL.size
    upright = TrueLens("ptlens", BARREL.coefficients, (height, width))
    both = Observations.side_by_side([picked(BARREL, n=8), picked(upright, n=8)])
    photos = tuple(replace(photo, lens=0) for photo in both.photos)
    found = compare(replace(both, photos=photos, lenses=both.lenses[:1]))
    for each in found.candidates:
        off_centre = bool({"d", "e", "p1", "p2"} & {*each.free})
        assert (each.calibration is None) == off_centre
        assert ("upright and sideways" in each.failure) == off_centre
    assert found.centre.startswith("what a free distortion centre would do is not known: ")
    assert says_whether_b_is_enough(found.reason)


@pytest.mark.parametrize("n_points", [5, 4, 3])
@pytest.mark.parametrize("n_lines", [1, 2, 4])
def test_very_few_picks_are_compared_or_refused_in_a_sentence(n_lines: int, n_points: int) -> None:
    lines = BARREL.lines(16, n_points, noise_px=0.3)[:n_lines]
    found = compared_or_refused(Observations.from_arrays(lines, BARREL.size))
    assert isinstance(found, Comparison) == (n_points * n_lines > 2 * n_lines + 1)


def test_picks_too_few_for_a_criterion_get_the_simplest_model() -> None:
    lines = [points[:n] for points, n in zip(BARREL.lines(16, 4), (4, 3, 2), strict=False)]
    found = compare(Observations.from_arrays(lines, BARREL.size))  # three contrasts are left
    assert found.candidates[0].aicc == np.inf
    assert found.reason == (
        "whether b alone is enough cannot be told from so few picks; it is taken since no model "
        "has fewer coefficients"
    )
    assert found.calibration.quoted is not None
    assert found.quote == found.calibration.quoted.sentence


def test_picks_on_no_straight_lines_are_compared_or_refused_in_a_sentence() -> None:
    rng = np.random.default_rng(7)
    for _ in range(6):
        lines = [rng.uniform(0, 2000, (12, 2)) for _ in range(16)]
        found = compared_or_refused(Observations.from_arrays(lines, BARREL.size))
        assert isinstance(found, PlumblineError)
        assert found.message.startswith("no model can be fitted: ")


def test_what_no_model_can_be_fitted_to_is_refused_at_once() -> None:
    picks = picked(BARREL)
    with pytest.raises(DegenerateLinesError, match="there are no lines"):
        compare(replace(picks, lines=()))
    with pytest.raises(OptionError, match="these observations are of 2 lenses"):
        compare(Observations.side_by_side([picks, replace(picks)]))
    middle = (np.array(BARREL.size) - 1) / 2
    central = [middle + np.linspace(-900, 900, 12)[:, None] * way for way in np.eye(2)]
    with pytest.raises(DegenerateLinesError, match="runs through the centre"):
        compare(Observations.from_arrays(central, BARREL.size))


def test_progress_is_told_once_for_each_model() -> None:
    told: list[None] = []
    found = compare(picked(BARREL), lambda: told.append(None))
    assert len(told) == len(found.candidates)


def test_a_pick_beyond_the_fold_does_not_spoil_the_derivatives_of_its_line() -> None:
    lens = plumbline.Lens(
        plumbline.get_model("ptlens"),
        plumbline.Frame(*BARREL.size),
        {"a": 0.0, "b": -0.2, "c": 0.0, "d": 0.0, "e": 0.0},
    )
    near = [np.array([[x, 300.0 + x / 40] for x in np.linspace(700, 2300, 8)])]
    far = [np.vstack((near[0], [[2.0e4, 400.0]]))]
    kept = np.ones(9, dtype=np.bool_)
    alone = linearise(lens, near, ("a", "b"), kept[:8], image=True)
    beside = linearise(lens, far, ("a", "b"), kept, image=True)
    assert beside.kept.tolist() == [True] * 8 + [False]
    assert np.allclose(beside.jacobian[:8], alone.jacobian, rtol=1e-12, atol=1e-9)
    assert np.allclose(beside.residual_px[:8], alone.residual_px, rtol=1e-12, atol=1e-9)


def test_picks_in_the_middle_of_the_photo_have_errors_too() -> None:
    """The range of the picks holds points, however small it is."""
    shown = TrueLens("division", {"l1": -0.1}, (1000, 800))
    far = np.array([(6000 - 1000) / 2, (4000 - 800) / 2])
    lines = [points + far for points in shown.lines(noise_px=0.1, seed=1)]
    found = compare(Observations.from_arrays(lines, (6000, 4000)))
    points = picked_range_px(found.calibration)
    assert len(points) > 100
    assert np.ptp(points, axis=0).min() > 600
    assert (taken(found).error_px or 0) > 0.01
    assert (taken(found).overall_error_px or 0) > 0.01


def test_few_picks_are_compared_robustly_as_far_as_they_go() -> None:
    """Three lines of three picks carry no a, b, c; b alone tells which to believe."""
    shown = TrueLens("ptlens", {"b": -0.03}, (1000, 800))
    few = [points[::5][:3] for points in shown.lines(noise_px=0.1, seed=2)[:3]]
    picks = Observations.from_arrays(few, (1000, 800))
    with pytest.raises(DegenerateLinesError, match="3 coefficients"):
        calibrate(picks, robust=True)
    made = compare(picks, robust=True).calibration
    assert made.robust
    assert made.converged
    assert len(made.free) == 1

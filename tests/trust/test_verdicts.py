"""What is said of a finished fit, on fits that are made to fail one check each."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from plumbline import Observations, calibrate
from plumbline.result.calibration import Calibration
from plumbline.trust.check import Check
from plumbline.trust.verdicts import after_fit
from tests.benchmarks.groups import lens
from tests.benchmarks.simulated import Group, Layout
from tests.benchmarks.spoiling import bent
from tests.fit.test_calibrate import picked
from tests.trust.test_next_line import INNER, noisy, seen
from tests.truth import TrueLens

BARREL = TrueLens("ptlens", {"a": 0.02, "b": -0.09, "c": -0.02})


def checked(made: Calibration) -> dict[str, Check]:
    """By name; each has a remedy where it failed, and is then among the notes."""
    for check in made.checks:
        assert check.passed or check.remedy
        assert check.passed or check.sentence in made.notes
        assert not check.passed or check.sentence not in made.notes
    return {check.name: check for check in made.checks}


ALIKE = [seen(np.array([[700.0, y], [2300.0, y]])) for y in (300.0, 320.0, 1930.0, 1950.0)]
"""Lines at one distance from the centre."""


def test_a_good_fit_passes_every_check() -> None:
    checks = checked(calibrate(picked(BARREL, noise_px=0.3, seed=2)))
    assert [name for name, check in checks.items() if not check.passed] == []
    assert checks["suspects"].finding == "none of the 192 picks is suspicious"
    assert {"condition", "correction", "line by line", "model"} <= set(checks)


def test_the_condition_is_that_of_the_scaled_jacobian() -> None:
    for obs, passes in ((picked(BARREL, noise_px=0.3), True), (noisy(ALIKE, 1), False)):
        made = calibrate(obs)
        jacobian = made.linearised.jacobian
        number = np.linalg.cond(jacobian / np.linalg.norm(jacobian, axis=0))
        check = checked(made)["condition"]
        assert f"problem {number:,.0f}" in check.finding
        assert check.passed == passes == (number <= 300)
    assert "problem 1" in checked(calibrate(picked(BARREL), free=("b",)))["condition"].finding


def test_an_uncertain_correction_names_the_line_to_pick_next() -> None:
    made = calibrate(noisy([line[[0, 4, 8]] for line in INNER], 1, 1.0))
    check = checked(made)["correction"]
    assert check.passed == (made.quoted.worst_px <= max(1.0, abs(made.finding.corner_px) / 20))  # type: ignore[union-attr]
    assert "one more horizontal line near the top or bottom edge, for ins" in check.sentence
    assert "would lower that to about" in check.sentence
    sure = made.quoted
    assert sure is not None
    assert check.finding.startswith(sure.sentence)
    assert "quote ±" in check.finding


def test_bent_edges_are_said_with_the_error_to_quote() -> None:
    group = Group("S120", lens("S120 5.2 mm"), Layout("by hand", 10, 19, 19), 0.1)
    points = bent(group, group.picks_px(1))[0]
    made = calibrate(Observations.from_arrays(group.by_line(points), group.lens.size))
    check = checked(made)["line by line"]
    wide = made.jackknife_displacement
    assert wide is not None
    assert not check.passed
    assert made.trust.steadiness is not None
    assert f"±{made.trust.steadiness.left_out_px:#.2g} px" in check.finding
    assert "edges are not quite straight" in check.remedy


def test_a_line_that_is_needed_is_said() -> None:
    true = TrueLens("ptlens", {"a": 0.0, "b": -0.06, "c": 0.0})
    made = calibrate(Observations.from_arrays(true.lines(noise_px=0.2)[:1], true.size), free=("b",))
    check = checked(made)["line by line"]
    assert not check.passed
    assert "without which the others do not determine the lens" in check.finding


def test_a_model_that_cannot_follow_the_lens_is_said() -> None:
    check = checked(calibrate(picked(BARREL, noise_px=0.1), free=("b",)))["model"]
    assert not check.passed
    assert "with r³ and r" in check.finding
    assert "plumbline compare" in check.remedy


def test_a_richer_model_that_the_picks_can_neither_want_nor_refuse() -> None:
    """A model error below 2.5 of its own errors, and above the error to quote, deserves a look."""
    found = [calibrate(picked(BARREL, noise_px=0.3, seed=seed), free=("b", "c")) for seed in (1, 2)]
    for made in found:
        more, sure = made.model_error, made.quoted_displacement
        assert more is not None
        assert sure is not None
        for factor, verdict in ((0.9, (True, False)), (1.1, (True, True)), (9.0, (False, False))):
            size = factor * sure.worst_px
            told = replace(more, largest_px=size, error_px=sure.worst_px)
            object.__setattr__(made.trust.besides, "unlike", lambda _group: False)  # pyright: ignore[reportUnknownLambdaType]
            object.__setattr__(made.trust, "model_error", told)
            (check,) = [c for c in after_fit(made.trust) if c.name == "model"]
            assert (check.passed, check.doubtful) == verdict
            assert ("more than the error to quote" in check.finding) == check.doubtful


def test_what_a_robust_fit_left_out_is_said() -> None:
    obs = picked(BARREL, noise_px=0.3, seed=2)
    obs.lines[2].points_px[4] += (0.0, 30.0)
    assert checked(calibrate(obs))["suspects"].sentence == (
        "1 pick of 192 is suspicious: look at it, or leave it out with --robust"
    )
    assert checked(calibrate(obs, robust=True))["suspects"].sentence == (
        "1 pick of 192 left out as suspicious: look at it"
    )
    lines = [line.points_px for line in picked(BARREL, noise_px=0.3, seed=2).lines]
    lines[4] = np.insert(lines[4], 6, lines[4][5] + (0.3, 0.2), axis=0)
    made = calibrate(Observations.from_arrays(lines, BARREL.size))
    assert checked(made)["suspects"].sentence == (
        "1 oddity (a bent line or a place picked twice) on the lines: look at it"
    )
    lines[2][4] += (0.0, 30.0)
    lines[7][4] += (0.0, 30.0)
    made = calibrate(Observations.from_arrays(lines, BARREL.size), robust=True)
    finding = checked(made)["suspects"].finding
    assert finding.startswith("2 picks of 193 left out as suspicious, and 1 oddity besides")
    assert checked(made)["suspects"].remedy == "look at each of them"


def test_a_lens_that_sees_no_pick_has_no_condition() -> None:
    made = calibrate(noisy(INNER, 1))
    folding = replace(
        made,
        lens=replace(made.lens, coefficients=made.coefficients | {"a": 0.0, "b": -9.0, "c": 9.0}),
    )
    assert not {c.name: c for c in folding.checks}["condition"].passed

"""What Python decides of picks in one call: checks, the automatic model, a second opinion."""

from __future__ import annotations

from dataclasses import FrozenInstanceError

import numpy as np
import pytest

from plumbline import Observations, calibrate, check, compare
from plumbline.errors import DegenerateLinesError, OptionError
from plumbline.result.checked import as_dict
from tests.truth import TrueLens

MILD = TrueLens("ptlens", {"a": 0.0, "b": -0.05, "c": 0.0})


def picked(noise_px: float = 0.3) -> Observations:
    return Observations.from_arrays(MILD.lines(noise_px=noise_px, seed=3), MILD.size)


def spoiled() -> Observations:
    """One line in sixteen is rubbish, so that the plain fit is refused."""
    lines = MILD.lines(noise_px=0.3, seed=3)
    lines[5] = np.random.default_rng(1).uniform(40, 2200, lines[5].shape)
    return Observations.from_arrays(lines, MILD.size)


def test_a_check_holds_the_fit_and_its_checks_and_cannot_be_changed() -> None:
    found, made = check(picked(), free=("b",)), calibrate(picked(), free=("b",))
    assert found.error is None
    assert found.calibration is not None
    assert found.calibration.coefficients == made.coefficients
    assert found.checks == made.checks
    assert found.passed == all(each.passed for each in made.checks)
    assert as_dict(found)["error"] is None
    with pytest.raises(FrozenInstanceError):
        found.error = ValueError()  # type: ignore[misc,assignment]


def test_a_refused_fit_is_part_of_the_check_with_its_suspects() -> None:
    found = check(spoiled())
    assert isinstance(found.error, DegenerateLinesError)
    assert not found.passed
    assert 5 in {suspect.line for suspect in found.suspects if suspect.left_out}
    assert found.checks[-1].name == "suspects"
    with pytest.raises(DegenerateLinesError) as refused:
        calibrate(spoiled())
    assert refused.value.suspects == found.suspects
    assert "--robust fits the others" in refused.value.hint


def test_what_no_fit_can_answer_is_raised_by_a_check_too() -> None:
    with pytest.raises(OptionError, match="unknown coefficient"):
        check(picked(), free=("k9",))


def test_the_automatic_model_is_the_recommended_one() -> None:
    obs, calls = picked(), list[int]()
    made = calibrate(obs, "auto", done=lambda: calls.append(1))
    comparison = compare(obs)
    taken = comparison.candidates[comparison.recommended]
    assert (made.model, made.free) == (taken.model, taken.free)
    assert made.coefficients == comparison.calibration.coefficients
    assert len(calls) == len(comparison.candidates)
    assert any(taken.name in remark and "was chosen" in remark for remark in made.remarks)


def test_the_automatic_model_takes_no_coefficients() -> None:
    with pytest.raises(OptionError, match="chooses its coefficients itself"):
        calibrate(picked(), "auto", free=("b",))

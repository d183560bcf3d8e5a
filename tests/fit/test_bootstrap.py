"""Bootstrap errors against the covariance, and what may not change."""

from __future__ import annotations

from functools import cache as remembered
from types import ModuleType

import numpy as np
import pytest

import plumbline
from plumbline import calibrate
from plumbline.errors import OptionError
from plumbline.fit.bootstrap import bootstrap
from plumbline.result.calibration import Calibration
from plumbline.trust.assessment import ResidualKind
from tests.fit.robust.test_fits import MOVED, left_out, moved
from tests.fit.test_calibrate import picked
from tests.truth import TrueLens

LENS = TrueLens("ptlens", {"a": 0.02, "b": -0.09, "c": -0.02})
FITS = 320


@remembered
def plain() -> Calibration:
    return calibrate(picked(LENS, noise_px=0.5, seed=8))


@remembered
def repeated() -> Calibration:
    return bootstrap(plain(), FITS)


def test_errors_are_those_of_the_covariance() -> None:
    """As far as one set of residuals tells them: those of 16 lines, 12 each."""
    made, found = plain(), repeated().bootstrap
    assert found is not None
    assert (found.fits, found.failed) == (FITS, 0)
    ratio = np.sqrt(np.diag(found.covariance) / np.diag(made.covariance))
    np.testing.assert_allclose(ratio, 1.0, atol=0.2)
    scale = np.sqrt(np.diag(found.covariance))
    np.testing.assert_allclose(
        found.covariance / np.outer(scale, scale), made.correlation, atol=0.02
    )
    # Percentiles of a distribution that is nearly normal, about the fit.
    for (low, high), name in zip(found.intervals, made.free, strict=True):
        error = made.standard_errors[name]
        assert (high - low) / (2 * 1.96 * error) == pytest.approx(1, abs=0.25)
        assert (high + low) / 2 == pytest.approx(made.coefficients[name], abs=0.35 * error)
    sure, wide = made.displacement, repeated().bootstrap_displacement
    assert sure is not None
    assert wide is not None
    np.testing.assert_allclose(np.delete(wide.errors_px / sure.errors_px, 40), 1.0, atol=0.25)


def test_the_calibration_itself_stays() -> None:
    assert repeated().coefficients == plain().coefficients
    np.testing.assert_array_equal(repeated().covariance, plain().covariance)


def test_the_same_seed_gives_the_same_and_another_another() -> None:
    told: list[int] = []
    first, second = (bootstrap(plain(), 50, seed=3).bootstrap for _ in range(2))
    other = bootstrap(plain(), 50, told.append, seed=4).bootstrap
    assert first is not None
    assert second is not None
    assert other is not None
    np.testing.assert_array_equal(first.covariance, second.covariance)
    np.testing.assert_array_equal(first.intervals, second.intervals)
    assert np.all(first.covariance != other.covariance)
    assert sum(told) == 50


@pytest.mark.parametrize("residual", ["image", "corrected"])
def test_held_coefficients_stay_and_picks_left_out_stay_out(residual: ResidualKind) -> None:
    made = calibrate(
        moved(),
        free=("b", "d"),
        start={"a": 0.02, "c": -0.02},
        robust=True,
        residual=residual,
    )
    assert left_out(made) == set(MOVED)
    found = bootstrap(made, 160).bootstrap
    assert found is not None
    assert found.covariance.shape == (2, 2)
    ratio = np.sqrt(np.diag(found.covariance) / np.diag(made.covariance))
    np.testing.assert_allclose(ratio, 1.0, atol=0.25)


def test_a_line_left_out_as_a_whole_takes_no_part() -> None:
    obs = moved({})
    points = obs.lines[10].points_px
    points[[0, 1, 3, 4, 6, 7, 9, 10], 1] += [80, -50, 35, 70, -90, -40, 60, -75]
    made = calibrate(obs, robust=True)
    assert not made.kept[10].any()
    found = bootstrap(made, 50).bootstrap
    assert found is not None
    assert found.failed == 0
    ratio = np.sqrt(np.diag(found.covariance) / np.diag(made.covariance))
    np.testing.assert_allclose(ratio, 1.0, atol=0.4)


@pytest.mark.parametrize("fits", [0, 49, 100_001])
def test_senseless_numbers_of_fits_are_refused(fits: int) -> None:
    with pytest.raises(OptionError, match="is out of range") as caught:
        bootstrap(plain(), fits)
    assert "from 50 to 100,000" in caught.value.hint


def test_the_public_name_stays_the_function_once_a_fit_was_made() -> None:
    # A module of the package under a public name would take its place when it is imported.
    for name in plumbline.__all__:
        assert not isinstance(getattr(plumbline, name), ModuleType), name
    assert callable(plumbline.bootstrap)

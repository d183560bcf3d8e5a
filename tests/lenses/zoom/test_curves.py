"""Coefficients over focal length: against LensFun's library, the literature, and closed forms."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

from plumbline.errors import OptionError
from plumbline.formats.lens_files.lensfun import Distortion
from plumbline.frame import Array
from plumbline.lenses.lensfun.database import common_database
from plumbline.lenses.zoom.curves import (
    hermite_weights,
    lensfun_values,
    linear_weights,
    polynomial,
    polynomial_weights,
)
from tests.lenses.library import lensfunpy

FOCALS = np.array([8.2, 10.1, 13.6, 18.4, 23.4, 28.3, 31.0])
COOLPIX_995_B = np.array([-0.019966, -0.010931, -0.002049, 0.003845, 0.006884, 0.008666, 0.009298])


def test_the_literature_s_cubic_of_the_coolpix_995() -> None:
    found = polynomial(FOCALS, COOLPIX_995_B, 3, np.ones(7))
    expected = [0.000005142, -0.000380839, 0.009606325, -0.075316854]
    assert np.max(np.abs(found - expected)) < 5e-10
    at_12 = polynomial_weights(FOCALS, 12.0, 3, np.ones(7)) @ COOLPIX_995_B
    assert at_12 == pytest.approx(np.polyval(expected, 12.0), abs=1e-6)


def test_weights_of_a_polynomial_follow_the_standard_errors() -> None:
    # A constant fitted to two values is their mean weighted by 1/σ².
    weights = polynomial_weights(np.array([10.0, 20.0]), 13.0, 0, np.array([1.0, 2.0]))
    np.testing.assert_allclose(weights, [0.8, 0.2], rtol=1e-12)


def test_hermite_is_lensfun_s_for_the_coolpix_995() -> None:
    entries = [
        Distortion("poly3", focal, {"k1": value})
        for focal, value in zip(FOCALS.tolist(), COOLPIX_995_B.tolist(), strict=True)
    ]
    database = lensfunpy.Database(load_common=False)
    camera = database.find_cameras("NIKON", "E995")[0]
    lens = next(e for e in database.find_lenses(camera) if "Standard" in e.model)
    for at in np.linspace(8.2, 31.0, 97):
        theirs = lens.interpolate_distortion(float(at)).terms[0]
        assert lensfun_values(entries, float(at)).coefficients["k1"] == pytest.approx(
            theirs, abs=1e-6
        )


def test_hermite_is_lensfun_s_for_the_whole_database() -> None:
    database = common_database()
    worst, compared = 0.0, 0
    for lens in database.library.lenses:
        entry = database.entry(lens)
        models = {each.model for each in entry.distortions} if entry else set()
        if entry is None or len(models) != 1 or len(entry.distortions) < 2:
            continue
        focals = [each.focal_mm for each in entry.distortions]
        for low, high in pairwise(focals):
            at = float(np.float32(low + 0.37 * (high - low)))
            theirs = lens.interpolate_distortion(at).terms
            ours = lensfun_values(entry.distortions, at).coefficients.values()
            worst = max(worst, *(abs(a - b) for a, b in zip(theirs, ours, strict=False)))
            compared += 1
    assert compared > 3000
    assert worst < 1e-6


def test_linear_weights_in_closed_form() -> None:
    np.testing.assert_allclose(linear_weights(FOCALS, 15.0), [0, 0, 3.4 / 4.8, 1.4 / 4.8, 0, 0, 0])
    assert np.any(np.abs(linear_weights(FOCALS, 9.0) - hermite_weights(FOCALS, 9.0)) > 0.01)


@pytest.mark.parametrize("weights", [linear_weights, hermite_weights])
def test_both_pass_through_the_nodes_and_are_clamped_outside(
    weights: Callable[[Array, float], Array],
) -> None:
    for index, focal in enumerate(FOCALS):
        np.testing.assert_allclose(weights(FOCALS, float(focal)), np.eye(7)[index], atol=1e-12)
    np.testing.assert_array_equal(weights(FOCALS, 5.0), np.eye(7)[0])
    np.testing.assert_array_equal(weights(FOCALS, 50.0), np.eye(7)[6])
    np.testing.assert_array_equal(weights(np.array([18.0]), 20.0), [1.0])


def test_hermite_is_exact_where_coefficient_times_focal_length_runs_straight() -> None:
    # c·f linear in f on evenly spaced nodes: c = m + n / f.
    focals = np.array([10.0, 20.0, 30.0, 40.0, 50.0])
    values = 0.002 - 0.3 / focals
    for at in (11.0, 17.0, 25.0, 44.0):
        assert hermite_weights(focals, at) @ values == pytest.approx(0.002 - 0.3 / at, rel=1e-12)


def test_acm_scales_by_powers_of_the_focal_length() -> None:
    # k1 f², k2 f⁴, k3 f⁶ and k4 f, k5 f are what LensFun 0.4 interpolates.
    powers = (2, 4, 6, 1, 1)
    entries = [
        Distortion("acm", f, {f"k{i + 1}": 0.5 / f**p for i, p in enumerate(powers)})
        for f in (10.0, 14.0, 20.0)
    ]
    found = lensfun_values(entries, 12.0).coefficients
    for index, power in enumerate(powers):
        assert found[f"k{index + 1}"] == pytest.approx(0.5 / 12.0**power, rel=1e-12)


def test_too_few_focal_lengths_for_a_polynomial() -> None:
    with pytest.raises(OptionError, match="degree 3 needs 4 focal lengths, and there are 3"):
        polynomial_weights(np.array([1.0, 2.0, 3.0]), 1.5, 3, np.ones(3))

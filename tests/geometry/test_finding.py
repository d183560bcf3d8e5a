"""Barrel, pincushion or wavy, and how much, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from plumbline.frame import Frame
from plumbline.geometry.finding import finding_of, radial_curve
from plumbline.geometry.lens import Lens
from plumbline.models import get_model

FRAME = Frame(4000, 3000)  # R = 1500 px, the corner at 5/3 R = 2500 px
CORNER = 5 / 3


def lens(name: str, frame: Frame = FRAME, focal_px: float = 3000.0, **given: float) -> Lens:
    model = get_model(name)
    zero = dict.fromkeys((*model.coefficients, "d", "e"), 0.0)
    return Lens(model, frame, zero | given, focal_px=focal_px)


@pytest.mark.parametrize("l1", [-0.1, -0.003, 0.002, 0.08])
def test_division_in_closed_form(l1: float) -> None:
    # observed / ideal = 1 + l1 r² exactly.
    found = finding_of(lens("division", l1=l1))
    assert found.kind == ("barrel" if l1 < 0 else "pincushion")
    assert found.percent == pytest.approx(100 * l1 * CORNER**2, rel=1e-12)
    ideal = 2500 / (1 + l1 * CORNER**2)
    assert found.corner_px == pytest.approx(2500 - ideal, rel=1e-12)


@pytest.mark.parametrize("k1", [-0.06, -0.01, 0.05])
def test_poly3_in_closed_form(k1: float) -> None:
    roots = np.roots([k1, 0.0, 1 - k1, -CORNER])
    ideal = float(min(r.real for r in roots if abs(r.imag) < 1e-9 and r.real > 0))
    central = ideal * (1 - k1)  # to the scale of the centre, not of the gauge
    found = finding_of(lens("poly3", k1=k1))
    assert found.kind == ("barrel" if k1 < 0 else "pincushion")
    assert found.percent == pytest.approx(100 * (CORNER / central - 1), rel=1e-9)
    assert found.corner_px == pytest.approx(1500 * (CORNER - central), rel=1e-9)
    assert finding_of(lens("ptlens", b=k1)) == found


def test_focal_lengths_do_not_matter_where_they_cancel() -> None:
    # poly5 k1 in half short sides is opencv k1 (f / R)².
    found = finding_of(lens("opencv", k1=-0.05 * 4, focal_px=3000.0))
    same = finding_of(lens("poly5", k1=-0.05))
    assert found.percent == pytest.approx(same.percent, rel=1e-12)
    assert found.corner_px == pytest.approx(same.corner_px, rel=1e-12)


def test_portrait_and_landscape_agree() -> None:
    assert finding_of(lens("ptlens", Frame(3000, 4000), b=-0.03)) == finding_of(
        lens("ptlens", b=-0.03)
    )


@pytest.mark.parametrize("name", ["ptlens", "poly3", "poly5", "radial", "brown", "division", "acm"])
def test_no_distortion_is_none(name: str) -> None:
    found = finding_of(lens(name))
    assert (found.kind, found.percent, found.corner_px) == ("none", 0.0, 0.0)


def test_none_ends_at_a_hundredth_of_a_pixel() -> None:
    # 2500 px · l1 · (5/3)² of displacement
    per_px = 1 / (2500 * CORNER**2)
    assert finding_of(lens("division", l1=-0.009 * per_px)).kind == "none"
    assert finding_of(lens("division", l1=-0.011 * per_px)).kind == "barrel"


def test_moustache_is_wavy() -> None:
    # ideal/observed = 1 + a2 r² + a4 r⁴ turns round at r² = −a2 / 2 a4 = (5/3)² / 2: back to
    # nothing at the corner.
    found = finding_of(lens("radial:2,4", a2=0.05, a4=-0.05 / CORNER**2))
    assert found.kind == "wavy"
    assert found.percent == pytest.approx(0.0, abs=1e-10)


def test_a_slight_return_is_no_wave() -> None:
    # Turns round at r = 0.95 of the corner: the return is small.
    turn = (0.95 * CORNER) ** 2
    assert finding_of(lens("radial:2,4", a2=0.05, a4=-0.05 / (2 * turn))).kind == "barrel"


def test_tangential_terms_and_the_centre_do_not_count() -> None:
    plain = finding_of(lens("brown", k1=0.03))
    assert finding_of(lens("brown", k1=0.03, p1=0.01, p2=-0.02, d=30.0, e=20.0)) == plain


def test_the_curve_ends_where_the_model_folds() -> None:
    b = -0.2
    fold = 1500 * 2 / 3 * (1 - b) * np.sqrt((b - 1) / (3 * b))
    observed, ideal = radial_curve(lens("ptlens", b=b))
    assert fold - 2500 / 64 < observed[-1] < fold
    assert np.all(np.diff(ideal) > 0)
    observed, ideal = radial_curve(lens("radial:2,4", a2=-0.2))
    fold = 1500 * np.sqrt(1 / 0.6)
    assert fold - 2500 / 64 < observed[-1] < fold
    np.testing.assert_allclose(ideal, observed * (1 - 0.2 * (observed / 1500) ** 2), rtol=1e-13)

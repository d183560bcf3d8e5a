"""Generalised least squares against explicit covariance matrices and simulated bends."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import plumbline
from plumbline import Observations, calibrate
from plumbline.fit.bends.generalised import bending
from plumbline.fit.bends.restricted import estimated
from plumbline.result.files import read_calibration
from plumbline.trust.bends import Bends, weighed
from plumbline.trust.straightness import edges_bend_px
from tests.benchmarks.dense import CASES, NOISE_PX, error_px, ordinary, picks
from tests.benchmarks.groups import lens
from tests.benchmarks.simulated import Group, Layout
from tests.benchmarks.trials import observations
from tests.fit.test_calibrate import picked
from tests.truth import Array, TrueLens

MILD = TrueLens("ptlens", {"a": 0.02, "b": -0.09, "c": -0.02})
FACADE = Group("S120", lens("S120 5.2 mm"), Layout("façade", 20, 40, 40), 0.7)
STRAIGHT, WAVY = CASES[0], CASES[3]


def matern(share: Array, tau: float, length: float) -> Array:
    """The covariance of order 3/2 from its formula."""
    d = np.sqrt(3) * np.abs(share[:, None] - share) / length
    return tau**2 * (1 + d) * np.exp(-d)


def bent(group: Group, tau: float, length: float, seed: int) -> Observations:
    rng = np.random.default_rng(seed)
    parts: list[Array] = []
    for line in group.lines:
        share = (line.places_px - line.places_px[0]) / np.ptp(line.places_px)
        root = np.linalg.cholesky(matern(share, tau, length) + 1e-12 * np.eye(len(share)))
        parts.append(root @ rng.standard_normal(len(share)) + 0.1 * rng.standard_normal(len(share)))
    return observations(group, group.true_px + np.concatenate(parts)[:, None] * group.across)


def test_noise_and_bends_are_told_apart() -> None:
    found: list[tuple[float, float]] = []
    for seed in range(3):
        made = calibrate(bent(FACADE, 0.3, 0.25, seed))
        assert made.bends is not None
        found.append((made.sigma_px, made.bends.typical_px))
    # 20 lines of 40 samples tell either to about 10 % a trial.
    np.testing.assert_allclose(np.mean(found, axis=0), (0.1, 0.3), rtol=0.2)


def test_whitened_products_are_those_of_the_inverse_covariance() -> None:
    """At the nodes themselves, where nothing is interpolated."""
    rng = np.random.default_rng(3)
    layout = Group("nodes", lens("Sigma 14 mm"), Layout("nodes", 4, 33, 33), 0.1)
    made = calibrate(observations(layout, layout.picks_px(1)[0]))
    line = made.linearised.line == 2
    along = np.where(line, np.linspace(-700, 700, 33)[np.arange(len(line)) % 33], 0.0)
    stretch = rng.uniform(0.8, 1.2, len(line))
    linear = replace(made.linearised, along_px=along, stretch=stretch)
    sigma_px, tau = 0.2, 0.7
    out = weighed(linear, Bends(0.3, 1.5, np.full(4, tau)), sigma_px)
    columns = np.column_stack((linear.image_px, linear.jacobian))[line]
    white = np.column_stack((out.image_px, out.jacobian))[line]
    v = matern(np.linspace(0, 1, 33), tau, 0.3) + sigma_px**2 * np.eye(33)
    x = np.column_stack((np.ones(33), along[line])) / stretch[line, None]
    inverse = np.linalg.inv(v)
    inverse -= inverse @ x @ np.linalg.inv(x.T @ inverse @ x) @ x.T @ inverse
    want = sigma_px**2 * columns.T @ inverse @ columns
    np.testing.assert_allclose(white.T @ white, want, rtol=1e-7, atol=1e-9 * np.abs(want).max())


def test_sparse_picks_are_fitted_as_ever() -> None:
    made = calibrate(picked(MILD, noise_px=0.5, seed=2))
    assert made.bends is None
    assert bending(made) is made
    assert made.trust.weighed is made.linearised


@pytest.mark.parametrize("trial", range(4))
def test_straight_edges_are_not_said_to_bend(trial: int) -> None:
    made = calibrate(observations(STRAIGHT.group, picks(STRAIGHT, trial)))
    assert made.bends is None


def test_the_fit_is_better_than_the_ordinary_one() -> None:
    squares: list[list[float]] = []
    for trial in range(6):
        made = calibrate(observations(WAVY.group, picks(WAVY, trial)))
        assert made.bends is not None
        assert made.sigma_px == pytest.approx(NOISE_PX, rel=0.2)
        both = (ordinary(made), made)
        squares.append([float(np.mean(error_px(WAVY.group, each) ** 2)) for each in both])
    plain, fitted = np.sqrt(np.mean(squares, axis=0))
    assert fitted < 0.75 * plain


def test_a_wavy_line_weighs_less() -> None:
    observed = bent(FACADE, 0.1, 0.3, 5)
    share = np.linspace(0, 1, 40)
    wave = 3 * np.cos(2 * np.pi * share)[:, None] * FACADE.across[FACADE.line_of == 7]
    lines = list(observed.lines)
    lines[7] = replace(lines[7], points_px=lines[7].points_px + wave)
    made = calibrate(replace(observed, lines=tuple(lines)))
    assert made.bends is not None
    others = np.delete(made.bends.tau_px, 7)
    assert made.bends.tau_px[7] > 5 * np.median(others)
    wrong = [each for each in made.suspects if each.kind == "bent line"]
    assert [each.line for each in wrong] == [7]
    assert float(np.max(error_px(FACADE, made))) < 0.5 * float(
        np.max(error_px(FACADE, ordinary(made)))
    )


def test_bends_are_written_and_read(tmp_path: Path) -> None:
    made = calibrate(bent(FACADE, 0.3, 0.25, 1))
    assert made.bends is not None
    path = tmp_path / "bent.json"
    plumbline.write(made, path)
    stored = json.loads(path.read_text("utf-8"))
    assert stored["bends"]["bend_px"] == pytest.approx(edges_bend_px(made.lines))
    again = read_calibration(str(path))
    assert again.bends is not None
    np.testing.assert_array_equal(again.bends.tau_px, made.bends.tau_px)
    assert again.quoted is not None
    assert made.quoted is not None
    assert again.quoted.worst_px == pytest.approx(made.quoted.worst_px)


def test_estimates_do_not_hang_on_the_lens() -> None:
    """Restricted likelihood: what the lens can take up is not seen."""
    made = calibrate(bent(FACADE, 0.3, 0.25, 2))
    linear = made.linearised
    moved = replace(
        linear, image_px=linear.image_px + linear.jacobian @ np.array([1e-5, 2e-5, 0.0])
    )
    one, other = estimated(linear), estimated(moved)
    assert one[:2] == other[:2]
    assert one.gain == pytest.approx(other.gain, rel=1e-6)


def test_strays_are_named_and_left_out() -> None:
    observed = bent(FACADE, 0.2, 0.3, 6)
    lines = list(observed.lines)
    points = lines[4].points_px.copy()
    points[17] += 4 * FACADE.across[FACADE.line_of == 4][17]
    lines[4] = replace(lines[4], points_px=points)
    spoiled = replace(observed, lines=tuple(lines))
    plain, sound = calibrate(spoiled), calibrate(spoiled, robust=True)
    for made in (plain, sound):
        assert [(each.line, each.picks) for each in made.suspects if each.left_out] == [(4, (17,))]
    assert all(kept.all() for kept in plain.kept)
    assert not sound.kept[4][17]
    assert sound.sigma_px == pytest.approx(0.1, rel=0.2)

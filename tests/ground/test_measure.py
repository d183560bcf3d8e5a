"""Quantities against closed forms, and their errors against drawn places."""

from __future__ import annotations

import numpy as np
import pytest

from plumbline.ground.ellipses import CHI_2, ellipse
from plumbline.ground.measure import KINDS, Kind, measured

PLACES = {
    "place": np.array([[3.0, 4.0]]),
    "distance": np.array([[1.0, 1.0], [4.0, 5.0]]),
    "angle": np.array([[5.0, 0.0], [1.0, 0.0], [1.0, 4.0]]),
    "area": np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [1.0, 3.0]]),
}
VALUES = {"place": (3.0, 4.0), "distance": (5.0,), "angle": (90.0,), "area": (10.5,)}


@pytest.mark.parametrize("kind", KINDS)
def test_the_values_are_those_of_the_closed_form(kind: Kind) -> None:
    places = PLACES[kind]
    names = "ABCD"[: len(places)]
    found = measured(kind, names, places, np.eye(2 * len(places)) * 1e-6)
    assert found.values == pytest.approx(VALUES[kind])


@pytest.mark.parametrize("kind", KINDS)
def test_the_errors_are_those_of_drawn_places(kind: Kind) -> None:
    places = PLACES[kind]
    rng = np.random.default_rng(1)
    root = rng.normal(0, 0.01, (2 * len(places), 2 * len(places)))
    covariance = root @ root.T
    names = "ABCD"[: len(places)]
    stated = measured(kind, names, places, covariance).errors
    draws = rng.multivariate_normal(places.ravel(), covariance, 4000).reshape(4000, -1, 2)
    values = np.array([measured(kind, names, draw, covariance).values for draw in draws])
    assert np.allclose(values.std(axis=0), stated, rtol=0.06)


def test_the_ellipse_holds_95_percent() -> None:
    covariance = np.array([[0.04, 0.015], [0.015, 0.01]])
    long, short, angle = ellipse(covariance)
    draws = np.random.default_rng(2).multivariate_normal((0, 0), covariance, 50_000)
    turn = np.radians(angle)
    along = draws @ [np.cos(turn), np.sin(turn)]
    across = draws @ [-np.sin(turn), np.cos(turn)]
    inside = (along / long) ** 2 + (across / short) ** 2 <= 1
    assert np.mean(inside) == pytest.approx(0.95, abs=0.005)
    assert pytest.approx(5.9915, abs=1e-3) == CHI_2

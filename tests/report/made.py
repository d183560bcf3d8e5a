"""Calibrations and photos that several tests of the report share."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

import plumbline
from plumbline.frame import Array
from plumbline.result.calibration import Calibration

SAMPLES = Path(__file__).parents[2] / "sample_projects"
BUILDING = SAMPLES / "building" / "building.pto"
WIDTH, HEIGHT = 640, 480
B = -0.03
SCRIPT = "<script>alert(1)</script>"


@cache
def building() -> Calibration:
    """The first sample project, fitted."""
    return plumbline.calibrate(plumbline.read(BUILDING))


def observed(ideal: Array, b: float = B) -> Array:
    """Where a `ptlens` lens with that b shows ideal points: q (b |q|² + 1 − b)."""
    centre = np.array([(WIDTH - 1) / 2, (HEIGHT - 1) / 2])
    q = (ideal - centre) / (HEIGHT / 2)
    return centre + q * (b * (q**2).sum(-1, keepdims=True) + 1 - b) * HEIGHT / 2


def grid(n: int = 12, noise_px: float = 0.1) -> list[Array]:
    """Rows and columns as that lens shows them."""
    rng = np.random.default_rng(3)
    lines: list[Array] = []
    for index in range(n):
        row = index % 2 == 0
        along = np.linspace(25, (WIDTH if row else HEIGHT) - 25, 9)
        across = np.full(9, 20 + (HEIGHT - 40 if row else WIDTH - 40) * (index // 2) / (n // 2 - 1))
        points = np.stack((along, across) if row else (across, along), axis=-1)
        lines.append(observed(points) + rng.normal(0, noise_px, points.shape))
    return lines


@cache
def without_a_line() -> Calibration:
    """A robust fit of 108 picks on 12 lines: one line is rubbish, and one pick of another."""
    lines = grid()
    lines[4] = np.random.default_rng(8).uniform((20, 20), (WIDTH - 20, HEIGHT - 20), (9, 2))
    lines[7][3] += (15.0, 0.0)
    observations = plumbline.Observations.from_arrays(lines, size=(WIDTH, HEIGHT))
    return plumbline.calibrate(observations, free=("b",), robust=True)


@cache
def hostile(*, robust: bool = False) -> Calibration:
    """Picks of which three are wrong, with names that would like to be code."""
    lines = grid()
    for index, (place, away) in {0: (3, (0, 9)), 3: (5, (-11, 0)), 6: (2, (0, -8))}.items():
        lines[index][place] += away
    labels = [f"{SCRIPT} {i}" if i % 3 == 0 else rf"$\frac{{x {i}" for i in range(len(lines))]
    made = plumbline.calibrate(
        plumbline.Observations.from_arrays(lines, size=(WIDTH, HEIGHT), labels=labels),
        free=("b",),
        robust=robust,
    )
    photos = (replace(made.observations.photos[0], name=f"{SCRIPT}.jpg"),)
    evil = replace(made.observations, photos=photos, notes=(f"a note of {SCRIPT} & 'more' \x00",))
    return replace(made, observations=evil, command=f"plumbline fit '{SCRIPT}'")

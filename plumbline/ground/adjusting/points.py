"""Equations of points: picks, places, unevenness, tapes, right angles, and the datum."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from plumbline.frame import Array
from plumbline.ground.adjusting.block import Block, ones, seen_by_steps
from plumbline.ground.adjusting.network import Network
from plumbline.ground.adjusting.state import Layout, State

DATUM_M = 1e-6
"""Standard error of a held datum: chosen, a micrometre, far below what any tape tells."""


def picks(network: Network, layout: Layout, state: State) -> Iterator[Block]:
    """Picks against where the points are seen."""
    seen = state.camera.see(state.places)
    rows = seen_by_steps(seen, layout)
    for index in range(layout.points):
        rows[index, :, layout.point(index)] = seen.by_place[index]
    yield Block(
        "picks",
        ((network.picks_px - seen.px) / network.sigma_pick_px).ravel(),
        -rows.reshape(-1, layout.size) / network.sigma_pick_px,
        np.repeat(np.arange(layout.points), 2),
    )


def points(network: Network, layout: Layout, state: State) -> Iterator[Block]:
    """Places as measured."""
    known = network.known
    sigma = np.repeat(network.sigma_places_m[known], 2)
    columns = layout.places[known].ravel()
    away = (network.places_m[known] - state.places[known, :2]).ravel()
    yield Block("points", away / sigma, ones(columns, -1 / sigma, layout.size), np.repeat(known, 2))


def flatness(network: Network, layout: Layout, state: State) -> Iterator[Block]:
    """Heights of the points over the plane, which should be none."""
    columns = layout.places[:, 0] + 2
    scale = np.full(layout.points, -1 / network.flatness_m)
    residuals = -state.places[:, 2] / network.flatness_m
    rows = ones(columns, scale, layout.size)
    yield Block("flatness", residuals, rows, np.arange(layout.points))


def tapes(network: Network, layout: Layout, state: State) -> Iterator[Block]:
    """Tape distances."""
    residuals, rows = np.zeros(len(network.tapes)), np.zeros((len(network.tapes), layout.size))
    for index, tape in enumerate(network.tapes):
        apart = state.places[tape.second, :2] - state.places[tape.first, :2]
        length = max(float(np.hypot(*apart)), DATUM_M)
        residuals[index] = (tape.metres - length) / tape.sigma_m
        rows[index, layout.places[tape.second]] = -apart / length / tape.sigma_m
        rows[index, layout.places[tape.first]] = apart / length / tape.sigma_m
    yield Block("tapes", residuals, rows, np.arange(len(network.tapes)))


def right_angles(network: Network, layout: Layout, state: State) -> Iterator[Block]:
    """Right angles, by the cosine."""
    count = len(network.right_angles)
    residuals, rows = np.zeros(count), np.zeros((count, layout.size))
    for index, angle in enumerate(network.right_angles):
        corner = state.places[angle.corner, :2]
        p, q = (state.places[i, :2] - corner for i in (angle.first, angle.last))
        size = max(float(np.hypot(*p) * np.hypot(*q)), DATUM_M**2)
        cosine = float(p @ q) / size
        residuals[index] = -cosine / angle.sigma_rad
        by_p = (cosine * p / max(p @ p, DATUM_M**2) - q / size) / angle.sigma_rad
        by_q = (cosine * q / max(q @ q, DATUM_M**2) - p / size) / angle.sigma_rad
        rows[index, layout.places[angle.first]] = by_p
        rows[index, layout.places[angle.last]] = by_q
        rows[index, layout.places[angle.corner]] = -by_p - by_q
    yield Block("angles", residuals, rows, np.arange(count))


def datum(network: Network, layout: Layout, state: State) -> Iterator[Block]:
    """What holds points without coordinates in place: the first at 0, 0, the second to its X."""
    known = network.known
    if len(known) >= 2 or layout.points < 2:
        return
    first = int(known[0]) if len(known) else 0
    second = 1 if first == 0 else 0
    rows, residuals = list[Array](), list[float]()
    if not len(known):
        rows += [ones(layout.places[first], np.full(2, -1.0), layout.size)]
        residuals += (-state.places[first, :2]).tolist()
    level = ones(layout.places[[second, first], 1], np.array([-1.0, 1.0]), layout.size)
    rows.append(level.sum(axis=0, keepdims=True))
    residuals.append(float(state.places[first, 1] - state.places[second, 1]))
    held = np.array(residuals) / DATUM_M
    yield Block("datum", held, np.concatenate(rows) / DATUM_M, np.zeros(len(held), dtype=np.int64))

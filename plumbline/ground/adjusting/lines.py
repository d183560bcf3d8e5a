"""Equations of lines: those on the plane in parallel sets, the horizon, and others in the photo."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from plumbline.frame import Array
from plumbline.ground.adjusting.block import Block, ones, seen_by_steps
from plumbline.ground.adjusting.network import SIGMA_SLOPE, Network
from plumbline.ground.adjusting.state import Layout, State
from plumbline.ground.camera import CENTRE


def lines(network: Network, layout: Layout, state: State) -> Iterator[Block]:
    """Picks against lines on the plane, in parallel sets."""
    for index, line in enumerate(network.lines):
        turn = state.directions[line.group]
        along, aside = _unit(turn)
        base = state.anchors[index] + state.offsets[index] * aside
        places = _nearest_on_line(line.picks_px, state, base, along)
        seen = state.camera.see(places)
        travel = (places[:, :2] - state.anchors[index]) @ along
        rows = seen_by_steps(seen, layout)
        by_turn = travel[:, None] * aside - state.offsets[index] * along
        by_aside = seen.by_place[:, :, :2] @ aside
        rows[..., layout.direction(line.group)] = np.einsum(
            "nij,nj->ni", seen.by_place[:, :, :2], by_turn
        )
        rows[..., layout.offset(index)] = by_aside
        tangent = seen.by_place[:, :, :2] @ along
        spread = (
            by_aside * network.sigma_line_m,
            seen.by_place[:, :, 2] * network.flatness_m,
        )
        yield _across("lines", line.picks_px, seen.px, tangent, rows, spread, network, index)


def _nearest_on_line(picks: Array, state: State, base: Array, along: Array) -> Array:
    """Places on a line of the plane whose images are nearest to picks, shape (n, 3)."""
    ground = state.camera.ground(picks)
    travel = (ground - base) @ along
    places = np.zeros((len(picks), 3))
    for _ in range(3):  # Newton steps; the last leaves less than the next step of the unknowns
        places[:, :2] = base + travel[:, None] * along
        seen = state.camera.see(places)
        tangent = seen.by_place[:, :, :2] @ along
        travel = travel + np.sum(tangent * (picks - seen.px), axis=1) / np.sum(tangent**2, axis=1)
    places[:, :2] = base + travel[:, None] * along
    return places


def horizon(network: Network, layout: Layout, state: State) -> Iterator[Block]:
    """Picks of the horizon, and how much the plane may slope against it."""
    if not layout.horizon:
        return
    picks = network.horizon_px
    rays = state.camera.rays(picks)[:, :2]
    turn = np.arctan2(rays[:, 1], rays[:, 0])
    flat = np.stack((np.cos(turn), np.sin(turn)), axis=1)
    seen = state.camera.see(np.column_stack((flat, flat @ state.slopes)), w=0.0)
    rows = seen_by_steps(seen, layout)
    rows[..., layout.slopes] = seen.by_place[:, :, 2:] * flat[:, None, :]
    swing = np.column_stack((-flat[:, 1], flat[:, 0], np.zeros(len(flat))))
    tangent = np.einsum("nij,nj->ni", seen.by_place, swing)
    yield _across("horizon", picks, seen.px, tangent, rows, (), network, 0)
    columns = np.arange(layout.size)[layout.slopes]
    prior = ones(columns, np.full(2, -1 / SIGMA_SLOPE), layout.size)
    yield Block("horizon", -state.slopes / SIGMA_SLOPE, prior, np.zeros(2, dtype=np.int64))


def straight(network: Network, layout: Layout, state: State) -> Iterator[Block]:
    """Picks against straight lines of the ideal picture."""
    optics = state.camera.optics
    for index, picks in enumerate(network.straight):
        turn, offset = state.straight[index]
        along, aside = _unit(turn)
        anchor = state.straight_anchors[index]
        travel = (optics.undistort(picks) - anchor) @ along
        ideal = anchor + offset * aside + travel[:, None] * along
        px, by_ideal, by_lens = optics.with_derivatives(ideal)
        rows = np.zeros((len(picks), 2, layout.size))
        rows[..., CENTRE] = np.eye(2)
        rows[..., layout.lens] = by_lens[..., list(layout.refined)]
        own = np.stack((travel[:, None] * aside - offset * along, aside + 0 * ideal), axis=-1)
        rows[..., layout.straight_line(index)] = by_ideal @ own
        tangent = by_ideal @ along
        yield _across("straight", picks, px, tangent, rows, (), network, index)


def _across(
    kind: str,
    picks: Array,
    px: Array,
    tangent: Array,
    rows: Array,
    spread: tuple[Array, ...],
    network: Network,
    owner: int,
) -> Block:
    """The distances of picks from a curve, along its normals in the photo."""
    normal = np.stack((-tangent[:, 1], tangent[:, 0]), axis=1)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    variance = np.full(len(picks), network.sigma_pick_px**2)
    for each in spread:
        variance += np.sum(normal * each, axis=1) ** 2
    sigma = np.sqrt(variance)
    return Block(
        kind,
        np.sum(normal * (picks - px), axis=1) / sigma,
        -np.einsum("ni,nij->nj", normal, rows) / sigma[:, None],
        np.full(len(picks), owner),
    )


def _unit(turn: float) -> tuple[Array, Array]:
    """The direction of an angle, and that a quarter turn on."""
    along = np.array([np.cos(turn), np.sin(turn)])
    return along, np.array([-along[1], along[0]])

"""The observation equations: how far each observation is from what a state says.

Every block holds residuals over their standard errors and the derivative of these by the steps
of the unknowns. The weight of a point is not that of its pick alone: its place on the plane and
its height are unknowns, observed with errors of their own, which is the same as weighting its
pick by (σ_p² I + J Σ_g Jᵀ)⁻¹.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from plumbline.frame import Array
from plumbline.ground.camera import CENTRE, FOCAL, N_STEPS, TURN, Seen
from plumbline.ground.network import SIGMA_SLOPE, Network
from plumbline.ground.state import Layout, State

DATUM_M = 1e-6
"""Standard error of a held datum: chosen, a micrometre, far below what any tape tells."""


@dataclass(frozen=True)
class Block:
    """Observations of one kind.

    Attributes:
        kind: What they are: "picks", "points", "flatness", "tapes", "angles", "lines",
            "horizon", "focal length", "centre", "lens", "square", "straight" or "datum".
        residuals: Observed minus computed over the standard error, shape (m,).
        derivative: Of the residuals by the steps, shape (m, unknowns).
        owners: Which point, tape, … each residual belongs to, shape (m,).
    """

    kind: str
    residuals: Array
    derivative: Array
    owners: Array


def blocks(network: Network, layout: Layout, start: State, state: State) -> list[Block]:
    """All observation equations.

    Args:
        network: What was observed.
        layout: Order of the unknowns.
        start: The state whose lens is the observed one.
        state: Where to evaluate.
    """
    builders = (
        _picks,
        _points,
        _flatness,
        _tapes,
        _right_angles,
        _lines,
        _horizon,
        _straight,
        _datum,
    )
    made = [block for build in builders for block in build(network, layout, state)]
    return [*made, *_camera(network, layout, start, state), *_lens(network, layout, start, state)]


def seen_by_steps(seen: Seen, layout: Layout) -> Array:
    """Derivative of what is seen by camera and refined coefficients, shape (n, 2, steps)."""
    rows = np.zeros((len(seen.px), 2, layout.size))
    rows[..., :N_STEPS] = seen.by_camera
    rows[..., layout.lens] = seen.by_lens[..., list(layout.refined)]
    return rows


def _picks(network: Network, layout: Layout, state: State) -> Iterator[Block]:
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


def _points(network: Network, layout: Layout, state: State) -> Iterator[Block]:
    known = network.known
    sigma = np.repeat(network.sigma_places_m[known], 2)
    columns = layout.places[known].ravel()
    away = (network.places_m[known] - state.places[known, :2]).ravel()
    yield Block(
        "points", away / sigma, _ones(columns, -1 / sigma, layout.size), np.repeat(known, 2)
    )


def _flatness(network: Network, layout: Layout, state: State) -> Iterator[Block]:
    columns = layout.places[:, 0] + 2
    scale = np.full(layout.points, -1 / network.flatness_m)
    residuals = -state.places[:, 2] / network.flatness_m
    rows = _ones(columns, scale, layout.size)
    yield Block("flatness", residuals, rows, np.arange(layout.points))


def _tapes(network: Network, layout: Layout, state: State) -> Iterator[Block]:
    residuals, rows = np.zeros(len(network.tapes)), np.zeros((len(network.tapes), layout.size))
    for index, tape in enumerate(network.tapes):
        apart = state.places[tape.second, :2] - state.places[tape.first, :2]
        length = max(float(np.hypot(*apart)), DATUM_M)
        residuals[index] = (tape.metres - length) / tape.sigma_m
        rows[index, layout.places[tape.second]] = -apart / length / tape.sigma_m
        rows[index, layout.places[tape.first]] = apart / length / tape.sigma_m
    yield Block("tapes", residuals, rows, np.arange(len(network.tapes)))


def _right_angles(network: Network, layout: Layout, state: State) -> Iterator[Block]:
    count = len(network.right_angles)
    residuals, rows = np.zeros(count), np.zeros((count, layout.size))
    for index, angle in enumerate(network.right_angles):
        corner = state.places[angle.corner, :2]
        p, q = (state.places[i, :2] - corner for i in (angle.first, angle.last))
        size = max(float(np.hypot(*p) * np.hypot(*q)), DATUM_M**2)
        cosine = float(p @ q) / size
        residuals[index] = -cosine / angle.sigma_rad
        by_p = (q / size - cosine * p / max(p @ p, DATUM_M**2)) / angle.sigma_rad
        by_q = (p / size - cosine * q / max(q @ q, DATUM_M**2)) / angle.sigma_rad
        rows[index, layout.places[angle.first]] = by_p
        rows[index, layout.places[angle.last]] = by_q
        rows[index, layout.places[angle.corner]] = -by_p - by_q
    yield Block("angles", residuals, rows, np.arange(count))


def _lines(network: Network, layout: Layout, state: State) -> Iterator[Block]:
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


def _horizon(network: Network, layout: Layout, state: State) -> Iterator[Block]:
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
    prior = _ones(columns, np.full(2, -1 / SIGMA_SLOPE), layout.size)
    yield Block("horizon", -state.slopes / SIGMA_SLOPE, prior, np.zeros(2, dtype=np.int64))


def _straight(network: Network, layout: Layout, state: State) -> Iterator[Block]:
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


def _camera(network: Network, layout: Layout, start: State, state: State) -> Iterator[Block]:
    if network.focal is not None:
        scale = 1.0
        if layout.refined:  # what EXIF tells belongs to the observed picture
            scale = start.camera.optics.paraxial_scale / state.camera.optics.paraxial_scale
        away = np.log(network.focal.px * scale / state.camera.focal_px) / network.focal.sigma
        rows = _ones(np.array([FOCAL]), np.array([-1 / network.focal.sigma]), layout.size)
        yield Block("focal length", np.array([away]), rows, np.zeros(1, dtype=np.int64))
    if np.isfinite(network.sigma_centre_px):
        sigma = max(network.sigma_centre_px, DATUM_M)
        shift = np.array(start.camera.optics.shift_px) - state.camera.optics.shift_px
        columns = np.arange(layout.size)[CENTRE]
        rows = _ones(columns, np.full(2, -1 / sigma), layout.size)
        yield Block("centre", shift / sigma, rows, np.zeros(2, dtype=np.int64))
    if network.sigma_square_rad is not None:
        upright = state.camera.rotation @ np.array([0.0, 0.0, 1.0])
        rows = np.zeros((2, layout.size))
        rows[:, TURN] = -np.array([[0, upright[2], -upright[1]], [-upright[2], 0, upright[0]]])
        rows /= network.sigma_square_rad
        residuals = -upright[:2] / network.sigma_square_rad
        yield Block("square", residuals, rows, np.zeros(2, dtype=np.int64))


def _lens(network: Network, layout: Layout, start: State, state: State) -> Iterator[Block]:
    """What the lens's source says of refined coefficients, where it says anything."""
    if network.lens_covariance is None or not layout.refined:
        return
    chosen = list(layout.refined)
    covariance = network.lens_covariance[np.ix_(chosen, chosen)]
    told = np.isfinite(np.diag(covariance)) & (np.diag(covariance) > 0)
    if not told.any():
        return
    columns = np.arange(layout.size)[layout.lens][told]
    root = np.linalg.inv(np.linalg.cholesky(covariance[np.ix_(told, told)]))
    values = (np.array(each.camera.optics.lens.coefficients) for each in (start, state))
    away = np.subtract(*values)[chosen][told]
    rows = np.zeros((len(columns), layout.size))
    rows[:, columns] = -root
    yield Block("lens", root @ away, rows, np.zeros(len(columns), dtype=np.int64))


def _datum(network: Network, layout: Layout, state: State) -> Iterator[Block]:
    """What holds points without coordinates in place: the first at 0, 0, the second to its X."""
    known = network.known
    if len(known) >= 2 or layout.points < 2:
        return
    first = int(known[0]) if len(known) else 0
    second = 1 if first == 0 else 0
    rows, residuals = list[Array](), list[float]()
    if not len(known):
        rows += [_ones(layout.places[first], np.full(2, -1.0), layout.size)]
        residuals += (-state.places[first, :2]).tolist()
    level = _ones(layout.places[[second, first], 1], np.array([-1.0, 1.0]), layout.size)
    rows.append(level.sum(axis=0, keepdims=True))
    residuals.append(float(state.places[first, 1] - state.places[second, 1]))
    held = np.array(residuals) / DATUM_M
    yield Block("datum", held, np.concatenate(rows) / DATUM_M, np.zeros(len(held), dtype=np.int64))


def _unit(turn: float) -> tuple[Array, Array]:
    """The direction of an angle, and that a quarter turn on."""
    along = np.array([np.cos(turn), np.sin(turn)])
    return along, np.array([-along[1], along[0]])


def _ones(columns: Array, values: Array, size: int) -> Array:
    """Rows with one value each, at these columns."""
    rows = np.zeros((len(columns), size))
    rows[np.arange(len(columns)), columns] = values
    return rows

"""Simulated road scenes, their observations, and the Cramér–Rao bound of places on the ground.

Everything here comes from `tests.ground.scenes`, an independent forward model; the bound from
its numerical derivatives. plumbline only adjusts what `observe` hands out.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from plumbline.frame import Frame
from plumbline.ground.adjusting.network import Focal, GroundLine, Network, Tape
from plumbline.ground.optics import Optics
from plumbline.lenses.mapping import PhotoLens
from plumbline.models import get_model
from tests.ground.scenes import Scene
from tests.truth import Array

PICK_PX, GROUND_M, FLAT_M, FOCAL, CENTRE_PX = 0.5, 0.01, 0.02, 0.02, 11.5
EDGES = ((-1.75, (8.0, 60.0)), (1.75, (8.0, 60.0)))
"""Lane edges: sideways place, from and to."""

LINE_PICKS = 12


@dataclass(frozen=True)
class Group:
    """One kind of scene.

    Attributes:
        name: For people.
        scene: The camera.
        corners: The four outermost points on the ground.
        points: How many points there are.
        checks: Where the errors are looked at.
        taped: Whether tapes are known instead of coordinates.
        lines: Whether two lane edges are traced.
        flat_m: How uneven the ground is.
        focal: Relative error of the focal length that is told; None if none is.
    """

    name: str
    scene: Scene
    corners: tuple[tuple[float, float], ...]
    points: int
    checks: tuple[tuple[float, float], ...]
    taped: bool = False
    lines: bool = False
    flat_m: float = FLAT_M
    focal: float | None = FOCAL

    @property
    def ground(self) -> Array:
        """The points: the corners first, then others within, always the same."""
        corners = np.array(self.corners)
        shares = np.random.default_rng(7).dirichlet(np.ones(4), self.points - 4)
        return np.concatenate((corners, shares @ corners))

    @property
    def tapes(self) -> list[tuple[int, int]]:
        """Pairs of points: all of the corners, and three to each further point."""
        pairs = [(i, j) for i in range(4) for j in range(i)]
        return pairs + [(i, j % 4) for i in range(4, self.points) for j in range(i, i + 3)]


SMALL = ((-1.5, 6.0), (1.5, 6.0), (1.5, 10.0), (-1.5, 10.0))
WIDE = ((-1.4, 4.5), (1.4, 4.5), (5.0, 25.0), (-5.0, 25.0))
SMALL_5M = ((-1.5, 9.0), (1.5, 9.0), (1.5, 13.0), (-1.5, 13.0))
WIDE_5M = ((-2.4, 7.5), (2.4, 7.5), (7.0, 30.0), (-7.0, 30.0))
CHECKS = ((0.0, 8.0), (1.0, 9.0), (-2.0, 12.0), (3.0, 16.0), (0.0, 25.0))
CHECKS_5M = ((0.0, 11.0), (1.0, 12.0), (-2.0, 15.0), (3.0, 20.0), (0.0, 27.0))
EYE, HIGH = Scene(height=1.6, pitch=9.0), Scene(height=5.0, pitch=20.0)


def groups() -> list[Group]:
    """The scenes of the benchmark."""
    made: list[Group] = []
    for where, scene, small, wide, checks in (
        ("1.6 m", EYE, SMALL, WIDE, CHECKS),
        ("5 m", HIGH, SMALL_5M, WIDE_5M, CHECKS_5M),
    ):
        for shape, corners in (("small", small), ("wide", wide)):
            for points in (4, 6, 12, 20):
                made.append(Group(f"{where}, {shape}, {points}", scene, corners, points, checks))
            for taped, lines in ((True, False), (False, True), (True, True)):
                name = f"{where}, {shape}, 6" + ", tapes" * taped + ", lane edges" * lines
                made.append(Group(name, scene, corners, 6, checks, taped, lines))
    return made


def optics(scene: Scene) -> Optics:
    """The lens of a scene, as its source has it."""
    frame = Frame(*scene.size)
    return Optics(PhotoLens(frame, get_model("ptlens"), (0.0, scene.b, 0.0), frame.radius_px))


def observe(group: Group, rng: np.random.Generator) -> tuple[Network, Array, Array]:
    """One trial: what is observed, picks of the check places, and the true places.

    The lens's centre, the unevenness, and every observation are drawn anew.
    """
    shift = rng.normal(0, CENTRE_PX, 2)
    scene = group.scene.with_(shift=(float(shift[0]), float(shift[1])))
    ground, checks = group.ground, np.array(group.checks)
    names = tuple(f"P{index}" for index in range(group.points))

    def pick(places: Array) -> Array:
        seen = scene.photo(places, rng.normal(0, group.flat_m, len(places)))
        return seen + rng.normal(0, PICK_PX, seen.shape)

    network = Network(
        names,
        pick(ground),
        ground + rng.normal(0, GROUND_M, ground.shape),
        np.full(group.points, GROUND_M),
        sigma_pick_px=PICK_PX,
        flatness_m=max(group.flat_m, 1e-6),
        sigma_centre_px=CENTRE_PX,
    )
    if group.focal is not None:
        told = scene.focal * float(np.exp(rng.normal(0, group.focal)))
        network = replace(network, focal=Focal(told, group.focal))
    if group.taped:
        apart = [float(np.hypot(*(ground[i] - ground[j]))) for i, j in group.tapes]
        tapes = [
            Tape(i, j, length + float(rng.normal(0, GROUND_M)))
            for (i, j), length in zip(group.tapes, apart, strict=True)
        ]
        network = replace(network, tapes=tuple(tapes), places_m=np.full(ground.shape, np.nan))
    if group.lines:
        edges = [GroundLine(f"edge {x:g}", pick(_edge(x, ends, rng)), 0) for x, ends in EDGES]
        network = replace(network, lines=tuple(edges))
    picks = pick(checks)
    return network, picks, in_datum(checks, ground) if group.taped else checks


def _edge(x: float, ends: tuple[float, float], rng: np.random.Generator) -> Array:
    along = np.geomspace(*ends, LINE_PICKS)
    return np.stack((x + rng.normal(0, GROUND_M, LINE_PICKS), along), axis=1)


def in_datum(places: Array, ground: Array) -> Array:
    """Places with the first point of the ground at 0, 0 and the second on the X axis."""
    x = ground[1] - ground[0]
    x = x / np.hypot(*x)
    return (places - ground[0]) @ np.array([[x[0], -x[1]], [x[1], x[0]]])


def bound(group: Group) -> Array:
    """The Cramér–Rao bound of the check places, shape (checks, 2, 2).

    Unknown are the camera (9), place and height of every point, of every check place and of every
    point of the lane edges, and where the edges lie; priors count as observations.
    """
    ground, checks = group.ground, np.array(group.checks)
    shown = np.concatenate((ground, checks))
    edges = [(x, np.geomspace(*ends, LINE_PICKS)) for x, ends in EDGES] if group.lines else []
    n, m = len(shown), sum(len(along) for _, along in edges)
    where = np.column_stack((shown, np.zeros(n))).ravel()
    turn = 1 if edges else 0
    start = np.concatenate((np.zeros(9), where, np.zeros(turn + len(edges) + 3 * m)))
    rows = derivative(lambda u: _equations(u, group, ground, n, edges), start)
    datum = derivative(lambda u: _datum(u, group), start)
    information = rows.T @ rows + datum.T @ datum * 1e12
    covariance = np.linalg.inv(information)
    first = 9 + 3 * len(ground)
    blocks = [covariance[i : i + 2, i : i + 2] for i in range(first, first + 3 * len(checks), 3)]
    return np.asarray(np.stack(blocks), dtype=np.float64)


def _datum(u: Array, group: Group) -> Array:
    if not group.taped:
        return np.zeros(1) * u[:1]
    x = np.array(group.corners[1]) - np.array(group.corners[0])
    across = np.array([-x[1], x[0]]) / np.hypot(*x)
    return np.array([u[9], u[10], across @ (u[12:14] - u[9:11])])


def _equations(
    u: Array, group: Group, ground: Array, n: int, edges: list[tuple[float, Array]]
) -> Array:
    scene = group.scene
    camera = scene.with_(
        height=scene.height * np.exp(u[2]),
        pitch=scene.pitch + np.degrees(u[3]),
        heading=scene.heading + np.degrees(u[4]),
        roll=scene.roll + np.degrees(u[5]),
        focal=scene.focal * np.exp(u[6]),
        shift=(u[7], u[8]),
    )
    points = u[9 : 9 + 3 * n].reshape(-1, 3)
    turn, *offsets = u[9 + 3 * n : 10 + 3 * n + len(edges)] if edges else [0.0]
    own = u[10 + 3 * n + len(edges) :].reshape(-1, 3) if edges else np.empty((0, 3))
    made = [
        camera.photo(points[:, :2] - u[:2], points[:, 2]).ravel() / PICK_PX,
        points[:, 2] / group.flat_m,
        u[7:9] / CENTRE_PX,
    ]
    if group.focal is not None:
        made.append(u[6:7] / group.focal)
    places = points[: len(ground), :2]
    if group.taped:
        apart = np.array([np.hypot(*(places[i] - places[j])) for i, j in group.tapes])
        made.append(apart / GROUND_M)
    else:
        made.append(places.ravel() / GROUND_M)
    at = 0
    for (x, along), offset in zip(edges, offsets, strict=True):
        travel, aside, lift = own[at : at + len(along)].T
        at += len(along)
        y = along + travel
        sideways = x + offset + turn * (y - along.mean()) + aside
        made += [
            camera.photo(np.stack((sideways, y), axis=1) - u[:2], lift).ravel() / PICK_PX,
            aside / GROUND_M,
            lift / group.flat_m,
        ]
    return np.concatenate(made)


def derivative(function: Callable[[Array], Array], at: Array, step: float = 1e-5) -> Array:
    """Central differences, shape (values, unknowns)."""
    columns: list[Array] = []
    for index in range(len(at)):
        move = np.zeros(len(at))
        move[index] = step
        columns.append((function(at + move) - function(at - move)) / (2 * step))
    return np.stack(columns, axis=1)

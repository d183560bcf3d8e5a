"""Where an adjustment starts: cameras tried on a grid, ranked by the distances that are known.

A pick and a camera over the plane give a place on it. Seen from above the plane these places have
one handedness, so that a network of tapes, which has a mirror image, gets the one of the photo.
For each camera of the grid the known distances over those of its places should all have one
ratio, the scale; the spread of their logarithms ranks the cameras, together with how far right
angles and parallel lines are from being so.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from plumbline.errors import OptionError
from plumbline.frame import Array, Indices
from plumbline.ground.adjusting.network import Network
from plumbline.ground.adjusting.state import State
from plumbline.ground.camera import Camera, looking
from plumbline.ground.optics import Optics

_CLEARANCES_DEG = np.geomspace(0.3, 85.0, 18)
_ROLLS_DEG = np.arange(-24.0, 25.0, 8.0)
_FOCALS = np.geomspace(0.35, 6.0, 9)
"""The grid: how far the highest pick lies below the horizon, how the camera is rolled, and the
focal length over the photo's diagonal where it is not known. Chosen: steps of about a third, from
which the adjustment finds its way, from ultra-wide lenses to long ones."""

_WELL_KNOWN = 0.3
"""Relative error of a focal length up to which no other is tried: chosen, below a grid step."""

_MOST_STARTS = 5
"""Chosen: a second minimum is rare, a third was never met."""

_LEAST_DOWN = 1e-6
"""Least descent of a ray that meets the plane, per unit ahead: chosen, a millionth."""


class _Grid(NamedTuple):
    """Cameras one metre over the plane, looking towards Y.

    Attributes:
        focals: Focal lengths in pixels, shape (m,).
        pitches: Degrees, shape (m,).
        rolls: Degrees, shape (m,).
    """

    focals: Array
    pitches: Array
    rolls: Array

    def camera(self, index: int, optics: Optics) -> Camera:
        """One of them."""
        above = np.array([0.0, 0.0, 1.0])
        pitch, roll = float(self.pitches[index]), float(self.rolls[index])
        return looking(above, pitch, roll, float(self.focals[index]), optics)

    def ground(self, ideal: Array) -> Array:
        """Where each sees the picks on the plane, shape (m, n, 2); NaN above its horizon.

        Args:
            ideal: Ideal square pixels from the optical axis, shape (n, 2).
        """
        pitch, roll = np.radians(self.pitches)[:, None], np.radians(self.rolls)[:, None]
        x, y = (each / self.focals[:, None] for each in ideal.T)
        right = x * np.cos(roll) - y * np.sin(roll)
        below = x * np.sin(roll) + y * np.cos(roll)
        down = below * np.cos(pitch) - np.sin(pitch)
        ahead = np.cos(pitch) + below * np.sin(pitch)
        down = np.where(down > _LEAST_DOWN, down, np.nan)
        return np.stack((right / down, ahead / down), axis=-1)


def starts(network: Network, optics: Optics) -> Iterator[State]:
    """States to start from, the most likely first.

    Raises:
        OptionError: no camera sees all picks below its horizon, or nothing tells the scale.
    """
    pairs, lengths = network.distances()
    if not len(pairs):
        raise OptionError(
            "nothing gives the scale of the ground",
            hint="give the places of at least two points, or one measured distance with --tapes",
        )
    ideal = optics.undistort(network.ground_picks_px) - optics.axis_px
    ideal = ideal * [optics.aspect, 1.0]
    grid = _grid(network, optics, ideal)
    ground = grid.ground(ideal)
    apart = ground[:, pairs[:, 0]] - ground[:, pairs[:, 1]]
    ratios = np.log(lengths / np.maximum(np.hypot(apart[..., 0], apart[..., 1]), 1e-12))
    spread = np.hypot(np.std(ratios, axis=1), _turned_wrongly(network, ground))
    spread[~np.isfinite(ground).all(axis=(1, 2))] = np.inf
    order = np.argsort(spread, kind="stable").astype(np.int64)
    order = order[np.isfinite(spread[order])]
    if not len(order):
        raise OptionError(
            "no camera over a plane sees all of the picks: some lie on or beyond the horizon",
            hint="remove the points that are not on the ground",
        )
    for index in _apart(order, grid.focals):
        yield _laid(grid.camera(index, optics), network)


def _turned_wrongly(network: Network, ground: Array) -> Array:
    """How far right angles are from right and parallel lines from parallel, radians, (m,)."""
    wrong = np.zeros(len(ground))
    for angle in network.right_angles:
        p, q = (ground[:, end] - ground[:, angle.corner] for end in (angle.first, angle.last))
        sizes = np.maximum(np.hypot(*p.T) * np.hypot(*q.T), 1e-12)
        wrong += (np.sum(p * q, axis=1) / sizes) ** 2
    first, turns = network.n_points, dict[int, Array]()
    for line in network.lines:
        last = first + len(line.picks_px)
        along = ground[:, last - 1] - ground[:, first]
        turn = np.arctan2(along[:, 1], along[:, 0])
        wrong += np.sin(turn - turns.setdefault(line.group, turn)) ** 2
        first = last
    return np.sqrt(wrong)


def _grid(network: Network, optics: Optics, ideal: Array) -> _Grid:
    diagonal = float(np.hypot(*optics.lens.frame.square_size))
    known = network.focal is not None and network.focal.sigma <= _WELL_KNOWN
    tried = np.array([network.focal.px]) if known and network.focal else _FOCALS * diagonal
    if network.sigma_square_rad is not None:
        return _Grid(tried, np.full(len(tried), -90.0), np.zeros(len(tried)))
    focals, rolls, clearances = (
        each.ravel() for each in np.meshgrid(tried, _ROLLS_DEG, _CLEARANCES_DEG, indexing="ij")
    )
    turn = np.radians(rolls)[:, None]
    below = (ideal[:, 0] * np.sin(turn) + ideal[:, 1] * np.cos(turn)) / focals[:, None]
    highest = np.degrees(np.arctan(below.min(axis=1)))
    pitches = highest - clearances
    good = pitches >= -90.0
    return _Grid(focals[good], pitches[good], rolls[good])


def _apart(order: Indices, focals: Array) -> list[int]:
    """The best of each focal length, few of them."""
    found: dict[float, int] = {}
    for index in order.tolist():
        found.setdefault(float(focals[index]), index)
    second = [index for index in order.tolist() if index not in found.values()]
    return [*found.values(), *second][:_MOST_STARTS]


def _laid(camera: Camera, network: Network) -> State:
    """The camera's ground laid to scale over the known places, and the state that it makes."""
    pairs, lengths = network.distances()
    ground = camera.ground(network.picks_px)
    apart = np.hypot(*(ground[pairs[:, 0]] - ground[pairs[:, 1]]).T)
    scale = float(np.exp(np.mean(np.log(lengths / apart))))
    turn, shift = _onto(ground * scale, network)
    spin = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    places = np.zeros((network.n_points, 3))
    places[:, :2] = ground * scale @ spin.T + shift
    known = network.known
    places[known, :2] = network.places_m[known]
    above = np.append(camera.place[:2] * scale @ spin.T + shift, camera.place[2] * scale)
    about_z = np.eye(3)
    about_z[:2, :2] = spin
    laid = replace(camera, place=above, rotation=camera.rotation @ about_z.T)
    return _with_lines(laid, places, network)


def _onto(ground: Array, network: Network) -> tuple[float, Array]:
    """The turn and shift that lay ground on the known places, or on the datum."""
    known = network.known
    if len(known) >= 2:
        a, b = ground[known], network.places_m[known]
        a0, b0 = a.mean(axis=0), b.mean(axis=0)
        p, q = a - a0, b - b0
        turn = float(np.arctan2(np.sum(p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]), np.sum(p * q)))
    else:
        first = int(known[0]) if len(known) else 0
        ahead = ground[1 if first == 0 else 0] - ground[first]
        turn = -float(np.arctan2(ahead[1], ahead[0]))
        a0, b0 = ground[first], network.places_m[first] if len(known) else np.zeros(2)
    spin = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    return turn, b0 - spin @ a0


def _with_lines(camera: Camera, places: Array, network: Network) -> State:
    """The state of a camera and places, its lines fitted to their picks."""
    anchors = np.zeros((len(network.lines), 2))
    directions = np.zeros(network.n_groups)
    lengths = np.zeros(network.n_groups)
    for index, line in enumerate(network.lines):
        ground = camera.ground(line.picks_px)
        anchors[index] = ground.mean(axis=0)
        turn, length = _direction(ground)
        if length > lengths[line.group]:  # the longest line of a set tells its direction best
            directions[line.group], lengths[line.group] = turn, length
    straight = np.zeros((len(network.straight), 2))
    middles = np.zeros((len(network.straight), 2))
    for index, picks in enumerate(network.straight):
        ideal = camera.optics.undistort(picks)
        middles[index] = ideal.mean(axis=0)
        straight[index, 0] = _direction(ideal)[0]
    offsets = np.zeros(len(network.lines))
    return State(camera, places, directions, anchors, offsets, np.zeros(2), straight, middles)


def _direction(points: Array) -> tuple[float, float]:
    """Direction of the best line through points of shape (n, 2), and their spread along it."""
    away = points - points.mean(axis=0)
    _, sizes, axes = np.linalg.svd(away, full_matrices=False)
    return float(np.arctan2(axes[0, 1], axes[0, 0])), float(sizes[0])

"""A camera over a plane: where the ground is seen, with derivatives.

The plane is Z = 0 with X to the right, Y ahead and Z up, metres. A point P, or a direction at
infinity (w = 0), has in the camera's axes (right, down, forward) the coordinates

    v = R (P − w C),    ideal = axis + f · (v₁ / v₃ / aspect, v₂ / v₃),    observed = D(ideal) + δ

Steps of the rotation are small turns ω in the camera's own axes, R ← exp([ω]×) R, so that no
attitude is singular; height and focal length step by their logarithms, so that both stay positive.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from plumbline.frame import Array
from plumbline.ground.optics import Optics

STEPS = ("x", "y", "height", "turn x", "turn y", "turn z", "focal length", "centre x", "centre y")
"""What a camera's steps change, in order: metres, logarithm, radians, logarithm, pixels."""

N_STEPS = len(STEPS)
HEIGHT, FOCAL, CENTRE = 2, 6, slice(7, 9)
TURN = slice(3, 6)
"""Where the turn stands among the steps of a camera."""

_NEAREST = 1e-6
"""Least depth over height of what counts as before the camera: chosen, a millionth."""


class Seen(NamedTuple):
    """Where points are seen, and how that moves.

    Attributes:
        px: Observed points, shape (n, 2); NaN behind the camera or beyond the lens's fold.
        by_place: Derivative by X, Y, Z, shape (n, 2, 3).
        by_camera: By the steps of the camera, shape (n, 2, 9).
        by_lens: By the lens's coefficients, shape (n, 2, k).
    """

    px: Array
    by_place: Array
    by_camera: Array
    by_lens: Array


@dataclass(frozen=True)
class Camera:
    """A camera over the plane.

    Attributes:
        place: C, shape (3,), metres; its third coordinate is the height.
        rotation: R, shape (3, 3): rows are the camera's right, down and forward.
        focal_px: f, ideal pixels of square height.
        optics: The lens.
    """

    place: Array
    rotation: Array
    focal_px: float
    optics: Optics

    @property
    def height_m(self) -> float:
        """Height over the plane."""
        return float(self.place[2])

    @property
    def heading_deg(self) -> float:
        """Where it looks, from Y towards X."""
        return float(np.degrees(np.arctan2(self.rotation[2, 0], self.rotation[2, 1])))

    @property
    def pitch_deg(self) -> float:
        """How far it looks up; negative is down."""
        return float(np.degrees(np.arcsin(np.clip(self.rotation[2, 2], -1, 1))))

    @property
    def roll_deg(self) -> float:
        """How far it is turned clockwise about its axis."""
        return float(np.degrees(np.arctan2(-self.rotation[0, 2], -self.rotation[1, 2])))

    def stepped(self, step: Array) -> Camera:
        """The camera moved by small steps, shape (9,)."""
        place = self.place + np.array([step[0], step[1], 0.0])
        place[2] *= np.exp(step[HEIGHT])
        return replace(
            self,
            place=place,
            rotation=_turned(step[TURN]) @ self.rotation,
            focal_px=self.focal_px * float(np.exp(step[FOCAL])),
            optics=self.optics.moved(step[CENTRE]),
        )

    def ideal(self, points: Array, w: float = 1.0) -> Array:
        """Ideal pixels of points of shape (n, 3); NaN behind the camera."""
        return self._ideal(self._axes(points, w))

    def project(self, points: Array, w: float = 1.0) -> Array:
        """Observed pixels of points, shape (n, 3) → (n, 2); NaN where they are not seen."""
        return self.optics.distort(self.ideal(points, w))

    def see(self, points: Array, w: float = 1.0) -> Seen:
        """As `project`, with derivatives."""
        v = self._axes(points, w)
        ideal = self._ideal(v)
        px, lens, by_lens = self.optics.with_derivatives(ideal)
        by_v = lens @ self._by_axes(v)
        by_place = by_v @ self.rotation
        by_camera = np.empty((len(v), 2, N_STEPS))
        by_camera[..., :3] = -w * by_place
        by_camera[..., HEIGHT] *= self.place[2]
        by_camera[..., TURN] = by_v @ -_cross(v)
        by_camera[..., FOCAL] = np.einsum("nij,nj->ni", lens, ideal - self.optics.axis_px)
        by_camera[..., CENTRE] = np.eye(2)
        return Seen(px, by_place, by_camera, by_lens)

    def rays(self, observed_px: Array) -> Array:
        """Directions in the world of observed points, shape (n, 2) → (n, 3), not normalised."""
        ideal = self.optics.undistort(observed_px)
        across = (ideal - self.optics.axis_px) / self.focal_px
        across = across * np.array([self.optics.aspect, 1.0])
        return np.concatenate((across, np.ones((len(across), 1))), axis=1) @ self.rotation

    def ground(self, observed_px: Array) -> Array:
        """Places on the plane of observed points, shape (n, 2) → (n, 2); NaN above the horizon."""
        rays = self.rays(observed_px)
        down = np.where(-rays[:, 2] > _NEAREST * np.linalg.norm(rays, axis=1), -rays[:, 2], np.nan)
        return self.place[:2] + rays[:, :2] * (self.place[2] / down)[:, None]

    def _axes(self, points: Array, w: float) -> Array:
        return (points - w * self.place) @ self.rotation.T

    def _ideal(self, v: Array) -> Array:
        least = _NEAREST * np.linalg.norm(v, axis=1)
        ahead = np.where(v[:, 2] > least, v[:, 2], np.nan)[:, None]
        return self.optics.axis_px + self.focal_px * v[:, :2] / ahead / [self.optics.aspect, 1.0]

    def _by_axes(self, v: Array) -> Array:
        """Derivative of ideal points by the camera's coordinates, shape (n, 2, 3)."""
        found = np.zeros((len(v), 2, 3))
        scale = self.focal_px / v[:, 2]
        found[:, 0, 0] = scale / self.optics.aspect
        found[:, 1, 1] = scale
        found[:, 0, 2] = -scale * v[:, 0] / v[:, 2] / self.optics.aspect
        found[:, 1, 2] = -scale * v[:, 1] / v[:, 2]
        return found


def looking(
    place: Array,
    pitch_deg: float,
    roll_deg: float,
    focal_px: float,
    optics: Optics,
    heading_deg: float = 0.0,
) -> Camera:
    """A camera by its angles; see `Camera`."""
    heading, pitch, roll = np.radians([heading_deg, pitch_deg, roll_deg])
    forward = np.array(
        [
            np.sin(heading) * np.cos(pitch),
            np.cos(heading) * np.cos(pitch),
            np.sin(pitch),
        ]
    )
    level = np.array([np.cos(heading), -np.sin(heading), 0.0])
    down = np.cross(forward, level)
    right = np.cos(roll) * level + np.sin(roll) * down
    below = np.cos(roll) * down - np.sin(roll) * level
    return Camera(np.asarray(place, float), np.stack((right, below, forward)), focal_px, optics)


def _cross(v: Array) -> Array:
    """[v]× for each of shape (n, 3)."""
    zero = np.zeros(len(v))
    x, y, z = v.T
    rows = (zero, -z, y, z, zero, -x, -y, x, zero)
    return np.stack(rows, axis=-1).reshape(-1, 3, 3)


def _turned(turn: Array) -> Array:
    """exp([ω]×), by O. Rodrigues (1840)."""
    angle = float(np.linalg.norm(turn))
    k = _cross(turn[None])[0]
    if angle < 1e-12:
        return np.eye(3) + k
    return np.eye(3) + np.sin(angle) / angle * k + (1 - np.cos(angle)) / angle**2 * (k @ k)

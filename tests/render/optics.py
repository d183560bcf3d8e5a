"""The truth: published ptlens coefficients, the formula, its inverse, and a pinhole camera.

r_obs = r (a r³ + b r² + c r + 1 − a − b − c), with r the ideal radius over half the shorter side,
about the centre ((w − 1)/2, (h − 1)/2); pixel (0, 0) is the centre of the top-left pixel. The
direction is that of LensFun's, Panorama Tools' and ImageMagick's code: ideal in, observed out.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

DIAGONAL_35MM = 43.267  # mm; Hugin splits the sensor's diagonal by the aspect ratio of the image
DATABASE = "LensFun database 0.3.3 (Debian liblensfun-data-v1 0.3.3-1)"
TABLE_STEPS = 40_000


@dataclass(frozen=True)
class Lens:
    """One published calibration: a lens at one focal length, on the camera it was measured with."""

    make: str
    camera: str
    lens: str
    focal: float
    crop: float
    a: float
    b: float
    c: float
    entry: str

    @property
    def coefficients(self) -> dict[str, float]:
        return {"a": self.a, "b": self.b, "c": self.c}

    @property
    def source(self) -> str:
        return f"{DATABASE}, {self.entry}, focal {self.focal:g}, crop factor {self.crop:g}"

    def stretch(self, r: Array) -> Array:
        """Return r_obs / r at the ideal radius r."""
        return ((self.a * r + self.b) * r + self.c) * r + 1 - self.a - self.b - self.c

    def hfov(self, width: int, height: int) -> float:
        """Return the horizontal field of view in degrees, worked out as Hugin does."""
        sensor = DIAGONAL_35MM / self.crop * width / np.hypot(width, height)
        return float(np.degrees(2 * np.arctan(sensor / 2 / self.focal)))


_EFS = "slr-canon.xml, Canon EF-S 18-55mm f/3.5-5.6 IS"
_24_85 = "slr-nikon.xml, Nikon AF-S Nikkor 24-85 mm f/3.5-4.5G ED VR"
_G15 = "compact-canon.xml, Canon PowerShot G15 & compatibles (Standard)"
_18_105 = "slr-nikon.xml, Nikon AF-S DX Zoom-Nikkor 18-105mm f/3.5-5.6G ED VR"
_NIKON = "NIKON CORPORATION"
_D7100 = (_NIKON, "NIKON D7100", "Nikkor AF-S 18-105mm f/3.5-5.6G DX ED VR")

EFS_18 = Lens(
    "Canon", "Canon EOS 450D", "Canon EF-S 18-55mm f/3.5-5.6 IS",
    18, 1.622, 0.00644, -0.01245, -0.0348, _EFS,
)  # fmt: skip
NIKKOR_42 = Lens(
    _NIKON, "NIKON D750", "Nikkor AF-S 24-85mm f/3.5-4.5G ED VR",
    42, 1.0, 0.00831, -0.00929, 0.02554, _24_85,
)  # fmt: skip
G15_6 = Lens(
    "Canon", "Canon PowerShot G15", "Canon PowerShot G15 6.1-30.5mm f/1.8-2.8",
    6.1, 4.65, 0.022578, -0.081031, 0.011077, _G15,
)  # fmt: skip
DX_18 = Lens(*_D7100, 18, 1.534, 0.02437, -0.06486, 0.00154, _18_105)
DX_35 = Lens(*_D7100, 35, 1.534, 0.00716, -0.00354, 0.00352, _18_105)
DX_105 = Lens(*_D7100, 105, 1.534, -0.00026, 0.02117, -0.02621, _18_105)


@dataclass(frozen=True)
class Pose:
    """Where the camera stands before the façade (metres) and how it is turned (degrees).

    x runs along the façade, `eye` is the height above the ground and `distance` the way to the
    wall; yaw turns right, pitch up, roll clockwise.
    """

    x: float
    eye: float
    distance: float
    yaw: float = 0.0
    pitch: float = 0.0
    roll: float = 0.0

    @cached_property
    def rotation(self) -> Array:
        """World axes (right, down, into the wall) to the camera's (right, down, forward)."""
        yaw, pitch, roll = np.radians([self.yaw, self.pitch, self.roll])
        about_y = [[np.cos(yaw), 0, -np.sin(yaw)], [0, 1, 0], [np.sin(yaw), 0, np.cos(yaw)]]
        about_x = [[1, 0, 0], [0, np.cos(pitch), np.sin(pitch)], [0, -np.sin(pitch), np.cos(pitch)]]
        about_z = [[np.cos(roll), np.sin(roll), 0], [-np.sin(roll), np.cos(roll), 0], [0, 0, 1]]
        return np.array(about_z) @ np.array(about_x) @ np.array(about_y)


@dataclass(frozen=True)
class View:
    """One exposure: a lens, a pose and the picture's size, in pixels."""

    lens: Lens
    pose: Pose
    width: int
    height: int

    @property
    def centre(self) -> Array:
        return np.array([(self.width - 1) / 2, (self.height - 1) / 2])

    @property
    def radius(self) -> float:
        return min(self.width, self.height) / 2

    @property
    def focal_px(self) -> float:
        half = np.radians(self.lens.hfov(self.width, self.height)) / 2
        return float(self.width / 2 / np.tan(half))

    def distort(self, ideal: Array) -> Array:
        """Map ideal points to observed ones, pixels, shape (..., 2)."""
        q = ideal - self.centre
        r = np.linalg.norm(q, axis=-1, keepdims=True) / self.radius
        return self.centre + q * self.lens.stretch(r)

    @cached_property
    def _table(self) -> tuple[Array, Array]:
        """Observed and ideal radii side by side, as far as the formula rises."""
        ideal = np.linspace(0.0, 4.0, TABLE_STEPS + 1)
        observed = ideal * self.lens.stretch(ideal)
        falls = np.flatnonzero(np.diff(observed) <= 0)
        end = int(falls[0]) + 1 if falls.size else ideal.size
        corner = float(np.hypot(self.width, self.height)) / 2 / self.radius
        if observed[end - 1] < 1.02 * corner:
            raise ValueError(f"the polynomial of {self.lens.lens} folds inside the photo")
        return observed[:end], ideal[:end]

    def undistort(self, observed: Array) -> Array:
        """Map observed points to ideal ones: a dense table of radii, then linear interpolation."""
        q = observed - self.centre
        r = np.linalg.norm(q, axis=-1, keepdims=True) / self.radius
        ideal = np.interp(r, *self._table)
        return self.centre + q * (ideal / np.maximum(r, 1e-12))

    def project(self, wall: Array) -> Array:
        """Map points of the façade (metres right, metres up) to observed pixels; NaN if unseen."""
        pose = self.pose
        world = np.stack(
            [
                wall[..., 0] - pose.x,
                pose.eye - wall[..., 1],
                np.full(wall.shape[:-1], pose.distance),
            ],
            axis=-1,
        )
        seen = world @ pose.rotation.T
        ahead = np.where(seen[..., 2:] > 0.1, seen[..., 2:], np.nan)
        ideal = self.centre + self.focal_px * seen[..., :2] / ahead
        r = np.linalg.norm(ideal - self.centre, axis=-1, keepdims=True) / self.radius
        return self.distort(np.where(r < self._table[1][-1], ideal, np.nan))

    def rays(self, observed: Array) -> Array:
        """Return the world direction (right, down, into the wall) seen at each observed point."""
        q = (self.undistort(observed) - self.centre) / self.focal_px
        directions = np.concatenate([q, np.ones((*q.shape[:-1], 1))], axis=-1)
        return directions @ self.pose.rotation

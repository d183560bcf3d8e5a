"""An independent truth: every distortion model in NumPy, inverted by bisection.

Written from the equations alone. It must never import `plumbline.models`, nor anything that
does, so that a mistake there cannot repeat itself here. To test a new model, give `POWERS`
and `scale` its equation.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Values = Mapping[str, float] | Mapping[str, Array]
"""Coefficients by name; arrays, for many lenses at once, broadcast with the radii."""

IDEAL_TO_OBSERVED = ("ptlens", "poly3", "poly5", "opencv", "acm")
IN_FOCAL_LENGTHS = ("opencv", "acm")
TRUE_AT_ONE = ("ptlens", "poly3")

POWERS: dict[str, dict[str, int]] = {
    "ptlens": {"a": 3, "b": 2, "c": 1},
    "poly3": {"k1": 2},
    "poly5": {"k1": 2, "k2": 4},
    "brown": {"k1": 2, "k2": 4, "k3": 6, "p1": 0, "p2": 0},
    "division": {"l1": 2, "l2": 4},
    "opencv": {"k1": 2, "k2": 4, "p1": 0, "p2": 0, "k3": 6},
    "acm": {"k1": 2, "k2": 4, "k3": 6, "k4": 0, "k5": 0},
}
"""The power of the radius each coefficient goes with; 0 marks the tangential ones."""

TANGENTIAL = {"brown": ("p1", "p2"), "opencv": ("p1", "p2"), "acm": ("k4", "k5")}


def powers(name: str) -> dict[str, int]:
    """Coefficients of a model in its order, with the power of the radius they go with."""
    if name.startswith("radial"):
        listed = name.partition(":")[2] or "2,4,6"
        return {f"a{power}": int(power) for power in listed.split(",")}
    return POWERS[name]


def scale(name: str, c: Values, r: ArrayLike) -> Array:
    """Radius out over radius in, in the model's own direction."""
    r = np.asarray(r, dtype=np.float64)
    if name == "ptlens":
        return c["a"] * r**3 + c["b"] * r**2 + c["c"] * r + 1 - c["a"] - c["b"] - c["c"]
    if name == "poly3":
        return 1 - c["k1"] + c["k1"] * r**2
    total = np.ones_like(r)
    for coefficient, power in powers(name).items():
        if power:
            total = total + c[coefficient] * r**power
    return 1 / total if name == "division" else total


def tangential(name: str, c: Values, x: Array, y: Array) -> tuple[Array, Array]:
    """The decentring displacement."""
    if name not in TANGENTIAL:
        return np.zeros_like(x), np.zeros_like(y)
    p1, p2 = (c[key] for key in TANGENTIAL[name])
    r2 = x**2 + y**2
    return 2 * p1 * x * y + p2 * (r2 + 2 * x**2), p1 * (r2 + 2 * y**2) + 2 * p2 * x * y


def forward(name: str, c: Values, points: ArrayLike) -> Array:
    """Map normalised points, shape (..., 2), in the model's own direction."""
    points = np.asarray(points, dtype=np.float64)
    x, y = points[..., 0], points[..., 1]
    dx, dy = tangential(name, c, x, y)
    s = scale(name, c, np.hypot(x, y))
    return np.stack((s * x + dx, s * y + dy), axis=-1)


def monotonic_to(name: str, c: Mapping[str, float], furthest: float = 20.0) -> float:
    """The radius up to which the radius out rises with the radius in, looked at closely."""
    r = np.linspace(0, furthest, 40_001)
    with np.errstate(divide="ignore"):
        out = r * scale(name, c, r)
    falls = np.flatnonzero(~(np.diff(out) > 0))
    return float(r[falls[0]]) if len(falls) else furthest


def bisected(name: str, c: Mapping[str, float], target: ArrayLike) -> Array:
    """Radii in for radii out, by bisection alone; NaN where there are none."""
    target = np.asarray(target, dtype=np.float64)
    top = monotonic_to(name, c)
    low, high = np.zeros_like(target), np.full_like(target, top)
    for _ in range(80):
        middle = (low + high) / 2
        below = middle * scale(name, c, middle) < target
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return np.where(target <= top * scale(name, c, top), (low + high) / 2, np.nan)


def backward(name: str, c: Mapping[str, float], points: ArrayLike) -> Array:
    """Map normalised points against the model's own direction.

    The radial part is bisected; tangential terms are taken in by fixed-point iteration.
    """
    wanted = np.asarray(points, dtype=np.float64)
    solved = wanted
    for _ in range(200 if name in TANGENTIAL else 1):
        dx, dy = tangential(name, c, solved[..., 0], solved[..., 1])
        rest = wanted - (np.stack((dx, dy), axis=-1) if name in TANGENTIAL else 0.0)
        out = np.hypot(rest[..., 0], rest[..., 1])
        ratio = np.where(out > 0, bisected(name, c, out) / np.where(out > 0, out, 1.0), 1.0)
        before, solved = solved, rest * ratio[..., None]
        if np.nanmax(np.abs(solved - before), initial=0.0) < 1e-15:
            break
    return solved


@dataclass(frozen=True)
class TrueLens:
    """A lens of known distortion in front of a photo of known size.

    Attributes:
        name: Name of the model.
        coefficients: Of the model; `d`, `e` in pixels where the centre is displaced.
        size: Width and height in pixels.
        focal_px: Focal length in pixels of square height.
        aspect: Width of one pixel over its height.
    """

    name: str
    coefficients: Mapping[str, float]
    size: tuple[int, int] = (3000, 2250)
    focal_px: float | None = None
    aspect: float = 1.0
    all_coefficients: dict[str, float] = field(init=False)

    def __post_init__(self) -> None:
        zero = dict.fromkeys((*powers(self.name), "d", "e"), 0.0)
        object.__setattr__(self, "all_coefficients", zero | dict(self.coefficients))

    @property
    def unit_px(self) -> float:
        """Pixels to a normalised radius of 1."""
        if self.name in IN_FOCAL_LENGTHS:
            assert self.focal_px
            return self.focal_px
        return min(self.size[0] * self.aspect, self.size[1]) / 2

    @property
    def corner(self) -> float:
        """Normalised radius of the photo's corner."""
        return float(np.hypot(self.size[0] * self.aspect, self.size[1])) / 2 / self.unit_px

    def undistort(self, points_px: ArrayLike) -> Array:
        """Observed points to ideal ones, pixels."""
        return self._mapped(points_px, observed_in=True)

    def distort(self, points_px: ArrayLike) -> Array:
        """Ideal points to observed ones, pixels."""
        return self._mapped(points_px, observed_in=False)

    def _mapped(self, points_px: ArrayLike, *, observed_in: bool) -> Array:
        c, middle = self.all_coefficients, (np.array(self.size) - 1) / 2
        offset = np.array([c["d"], c["e"]])
        square = np.array([self.aspect, 1.0]) / self.unit_px
        start, end = (offset, 0.0) if observed_in else (0.0, offset)
        points = (np.asarray(points_px, dtype=np.float64) - middle - start) * square
        own_way = (self.name in IDEAL_TO_OBSERVED) != observed_in
        mapped = (forward if own_way else backward)(self.name, c, points)
        return mapped / square + middle + end

    def inside(self, points_px: Array) -> NDArray[np.bool_]:
        """Which points lie between the centres of the outermost pixels."""
        return np.all((points_px >= 0) & (points_px <= np.array(self.size) - 1.0), axis=-1)

    def lines(
        self, n_lines: int = 16, n_points: int = 12, *, noise_px: float = 0.0, seed: int = 0
    ) -> list[Array]:
        """Straight ideal lines across the photo, as the lens shows them.

        Lines run upright, level and (every fourth) slanted, spread over the whole photo.

        Args:
            n_lines: Number of lines.
            n_points: Points on each.
            noise_px: Standard deviation of picking errors, in x and in y.
            seed: Of the lines' places and of the noise.
        """
        places = np.random.default_rng(1000 + seed)
        picks = np.random.default_rng(seed)
        return [
            self._line(index, n_lines, n_points, places)
            + noise_px * picks.standard_normal((n_points, 2))
            for index in range(n_lines)
        ]

    def _line(self, index: int, n_lines: int, n_points: int, places: np.random.Generator) -> Array:
        long, wide = np.array(self.size) - 1.0
        at = 0.03 + 0.94 * (index + 0.5) / n_lines
        tilt = places.uniform(-0.03, 0.03) + (0.3 if index % 4 == 3 else 0.0)
        ends = np.array([[0.04, at - tilt], [0.96, at + tilt]]).clip(0.02, 0.98)
        ends = ends[:, ::-1] if index % 2 else ends
        first, last = self.undistort(ends * (long, wide))
        share = np.linspace(0.0, 1.0, 400)[:, None]
        seen = self.distort(first * (1 - share) + last * share)
        seen = seen[self.inside(seen)]
        chosen = np.linspace(0, len(seen) - 1, n_points).round().astype(int)
        return seen[chosen]


def grid_px(size: tuple[int, int], n: int = 21) -> Array:
    """Points all over a photo, corners included, shape (n², 2)."""
    x, y = np.meshgrid(np.linspace(0, size[0] - 1, n), np.linspace(0, size[1] - 1, n))
    return np.stack((x.ravel(), y.ravel()), axis=-1)


def unlike_px(ideal: Array, other: Array, *, perspective: bool = False) -> float:
    """Largest distance between two sets of ideal points that straight lines can tell apart.

    `other` is first brought onto `ideal` by the best common scale and translation, or by the
    best homography where tangential terms are free: straight lines see none of these.
    """
    if perspective:
        moved = _by_homography(other, ideal)
    else:
        a, b = other - other.mean(axis=0), ideal - ideal.mean(axis=0)
        moved = a * (np.sum(a * b) / np.sum(a * a)) + ideal.mean(axis=0)
    return float(np.max(np.hypot(*(moved - ideal).T)))


def _by_homography(points: Array, target: Array) -> Array:
    middle, spread = target.mean(axis=0), target.std()
    p, q = (points - middle) / spread, (target - middle) / spread
    one, zero = np.ones((len(p), 1)), np.zeros((len(p), 3))
    h = np.array([1.0, 0, 0, 0, 1, 0, 0, 0])
    full = np.hstack((p, one))
    moved = p
    for _ in range(30):
        below = (p @ h[6:] + 1)[:, None]
        moved = np.stack((full @ h[:3], full @ h[3:6]), axis=-1) / below
        rows_x = np.hstack((full, zero, -moved[:, :1] * p)) / below
        rows_y = np.hstack((zero, full, -moved[:, 1:] * p)) / below
        h = h + np.linalg.lstsq(np.vstack((rows_x, rows_y)), (q - moved).T.ravel())[0]
    return moved * spread + middle


def distances_px(lens: TrueLens, lines: list[Array], *, in_photo: bool) -> list[Array]:
    """Signed distances of undistorted points from their total least-squares lines, by SVD.

    Args:
        lens: The lens that undistorts.
        lines: Observed points, pixels.
        in_photo: Divide each by its numerically differentiated derivative by the observed
            point, which gives the distance in the photograph's own pixels to first order.
    """
    square, step = np.array([lens.aspect, 1.0]), 0.05
    kernel = np.array([1.0, -8.0, 8.0, -1.0]) / 12 / step  # fourth order
    found: list[Array] = []
    for points in lines:
        ideal = lens.undistort(points) * square
        middle = ideal.mean(axis=0)
        normal = np.linalg.svd(ideal - middle)[2][1]
        normal = normal * (1.0 if normal[np.argmax(np.abs(normal))] > 0 else -1.0)
        distances = (ideal - middle) @ normal
        if in_photo:
            slopes: list[Array] = []
            for axis in ([1.0, 0.0], [0.0, 1.0]):
                moved = [
                    (lens.undistort(points + share * step * np.array(axis)) * square) @ normal
                    for share in (-2.0, -1.0, 1.0, 2.0)
                ]
                slopes.append(kernel @ np.array(moved))
            distances = distances / np.hypot(*slopes)
        found.append(distances)
    return found

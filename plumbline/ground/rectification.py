"""A photograph of a plane, rectified: photo to ground and back, with errors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from plumbline.errors import OptionError
from plumbline.frame import Array
from plumbline.ground.camera import Camera, Seen
from plumbline.ground.findings import Findings
from plumbline.ground.measure import Kind, Measurement, measured, refuse_number


@dataclass(frozen=True)
class Rectification:
    """The camera over a plane, the points on it, and how sure they are.

    Attributes:
        camera: The camera with its lens.
        names: Names of the points.
        picks_px: Where they were picked, shape (n, 2).
        places_m: Where they lie, adjusted, shape (n, 2).
        covariance: Of the camera's steps (see `ground.camera`), of the lens's coefficients and
            of X and Y of the points, in this order, shape (9 + k + 2 n,) squared.
        shares: What each kind of observation adds to the covariance of camera and lens, each of
            shape (9 + k, 9 + k); they sum to that part of `covariance`.
        sigma_pick_px: Standard error of a pick.
        flatness_m: Standard deviation of the plane's unevenness.
        widening: Factor by which contradictions widened all standard errors, 1 without.
        findings: What there is to say of the adjustment.
    """

    camera: Camera
    names: tuple[str, ...]
    picks_px: Array
    places_m: Array
    covariance: Array
    shares: Mapping[str, Array]
    sigma_pick_px: float
    flatness_m: float
    widening: float = 1.0
    findings: Findings = field(default_factory=Findings)

    def to_ground(self, points_px: ArrayLike) -> Array:
        """Places on the plane of observed points.

        Args:
            points_px: Points as picked in the photo, pixels, shape (n, 2).

        Returns:
            X and Y in metres, shape (n, 2); NaN on and above the horizon and beyond the fold.
        """
        return self.camera.ground(_points(points_px))

    def to_photo(self, places_m: ArrayLike) -> Array:
        """Where places on the plane are seen.

        Args:
            places_m: X and Y in metres, shape (n, 2).

        Returns:
            Observed pixels, shape (n, 2); NaN behind the camera and beyond the fold.
        """
        places = _points(places_m)
        return self.camera.project(np.column_stack((places, np.zeros(len(places)))))

    def covariances(self, points_px: ArrayLike) -> Array:
        """Covariance of each picked point's place on the plane, m², shape (n, 2, 2).

        It holds the pick's own error, the plane's unevenness there, and the errors of camera,
        lens and points.
        """
        seen = self._seen(_points(points_px))
        gain = _gain(seen)
        size = gain.shape[-1]
        return gain @ self.covariance[:size, :size] @ gain.transpose(0, 2, 1) + self._own(seen)

    def joint(self, names: Sequence[str], picks: Mapping[str, ArrayLike]) -> tuple[Array, Array]:
        """Places of named points and picks, with the covariance of all of them together.

        Args:
            names: Which, each a key of `picks` or a point of the adjustment.
            picks: Further picks, pixels.

        Returns:
            Places, shape (m, 2), and the covariance of x₁, y₁, x₂, …, shape (2 m, 2 m).

        Raises:
            OptionError: a name is unknown, or a pick lies on or beyond the horizon.
        """
        size = len(self.covariance)
        places, gains = np.empty((len(names), 2)), np.zeros((len(names), 2, size))
        own = np.zeros((2 * len(names), 2 * len(names)))
        for index, name in enumerate(names):
            if name in picks:
                pick = np.asarray(picks[name], dtype=np.float64).reshape(1, 2)
                places[index] = self.to_ground(pick)[0]
                if not np.isfinite(places[index]).all():
                    raise OptionError(
                        f"{name} lies on or beyond the horizon", hint="pick points on the ground"
                    )
                seen = self._seen(pick)
                gain = _gain(seen)[0]
                gains[index, :, : gain.shape[1]] = gain
                block = slice(2 * index, 2 * index + 2)
                own[block, block] = self._own(seen)[0]
            elif name in self.names:
                point = self.names.index(name)
                places[index] = self.places_m[point]
                start = size - 2 * (len(self.names) - point)
                gains[index, :, start : start + 2] = np.eye(2)
            else:
                raise OptionError(f"no point is named {name}", hint="name a pick or a match point")
        flat = gains.reshape(-1, size)
        return places, flat @ self.covariance @ flat.T + own

    def measure(
        self, kind: Kind, names: Sequence[str], picks: Mapping[str, ArrayLike] | None = None
    ) -> Measurement:
        """Measure one quantity on the plane.

        Args:
            kind: "place", "distance", "angle" (at the second of three) or "area" (of a polygon).
            names: The points, keys of `picks` or points of the adjustment.
            picks: Further picks in the photo by name, pixels.

        Raises:
            OptionError: a name is unknown, too few or too many are given, a pick lies on or
                beyond the horizon, or the polygon crosses itself.
        """
        refuse_number(kind, names)
        return measured(kind, names, *self.joint(names, picks or {}))

    def budget(self, point_px: ArrayLike) -> dict[str, Array]:
        """Where the covariance of a pick's place comes from, each share of shape (2, 2).

        The kinds of observations of the adjustment, "pick" for the pick itself and "unevenness"
        for the plane's there.
        """
        seen = self._seen(np.asarray(point_px, dtype=np.float64).reshape(1, 2))
        gain = _gain(seen)[0]
        shares = {kind: gain @ share @ gain.T for kind, share in self.shares.items()}
        inverse, lift = _inverse_and_lift(seen)
        shares["pick"] = self.sigma_pick_px**2 * (inverse @ inverse.transpose(0, 2, 1))[0]
        shares["unevenness"] = self.flatness_m**2 * np.outer(lift[0], lift[0])
        return shares

    def _seen(self, points_px: Array) -> Seen:
        ground = self.camera.ground(points_px)
        with np.errstate(all="ignore"):
            return self.camera.see(np.column_stack((ground, np.zeros(len(ground)))))

    def _own(self, seen: Seen) -> Array:
        """Covariance that a pick has for itself, shape (n, 2, 2)."""
        inverse, lift = _inverse_and_lift(seen)
        picked = self.sigma_pick_px**2 * inverse @ inverse.transpose(0, 2, 1)
        return picked + self.flatness_m**2 * lift[:, :, None] * lift[:, None, :]


def gains(camera: Camera, places_m: Array) -> Array:
    """Derivative of places on the plane by the camera's steps and coefficients, (n, 2, 9 + k)."""
    return _gain(camera.see(np.column_stack((places_m, np.zeros(len(places_m))))))


def _gain(seen: Seen) -> Array:
    """Derivative of places by camera steps and coefficients, shape (n, 2, 9 + k)."""
    inverse, _ = _inverse_and_lift(seen)
    by_all = np.concatenate((seen.by_camera, seen.by_lens), axis=-1)
    return -inverse @ by_all


def _inverse_and_lift(seen: Seen) -> tuple[Array, Array]:
    """Derivative of places by picks, (n, 2, 2), and by a point's height off the plane, (n, 2)."""
    plane = seen.by_place[:, :, :2]
    lost = np.isnan(plane.sum(axis=(1, 2)))
    inverse = np.linalg.inv(np.where(lost[:, None, None], np.eye(2), plane))
    inverse[lost] = np.nan
    return inverse, -np.einsum("nij,nj->ni", inverse, seen.by_place[:, :, 2])


def _points(points: ArrayLike) -> Array:
    array = np.asarray(points, dtype=np.float64)
    if array.ndim != 2 or array.shape[1] != 2:
        raise OptionError(f"points of shape {array.shape} were given", hint="give shape (n, 2)")
    return array

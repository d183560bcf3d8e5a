"""What was observed of a photographed plane, each with its own standard error."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from plumbline.frame import Array, Indices

SIGMA_PICK_PX = 0.5
"""Standard error of a pick where none is given: chosen, a sharp mark picked by hand."""
SIGMA_GROUND_M = 0.01
"""Of a coordinate on the ground: chosen, a point surveyed with a total station or RTK."""
FLATNESS_M = 0.02
"""Standard deviation of the plane's unevenness: chosen, ruts and camber of a paved road."""
SIGMA_TAPE_M = 0.01
"""Of a tape: chosen, it is read as well as a point is surveyed."""

SIGMA_ANGLE_RAD = 0.005
"""Of a right angle: chosen, because corners are laid out to about a centimetre in two metres."""

SIGMA_FOCAL = 0.02
"""Relative, of EXIF's focal length: chosen, because lenses are named after rounded ones."""

SIGMA_CENTRE = 0.015
"""Of the lens's centre, in half shorter sides: the scatter of specimens, about 1.5 %."""

SIGMA_SLOPE = 0.01
"""Slope of the road against the horizon: chosen, because few roads are level to 1 %."""

SIGMA_SQUARE_RAD = 0.02
"""Of a camera held square to the plane by eye: chosen, about one degree."""


@dataclass(frozen=True)
class Tape:
    """A measured distance between two points.

    Attributes:
        first: Index of a point.
        second: Index of another.
        metres: Their distance.
        sigma_m: Its standard error.
    """

    first: int
    second: int
    metres: float
    sigma_m: float = SIGMA_TAPE_M


@dataclass(frozen=True)
class RightAngle:
    """A right angle at the second of three points, by index."""

    first: int
    corner: int
    last: int
    sigma_rad: float = SIGMA_ANGLE_RAD


@dataclass(frozen=True)
class GroundLine:
    """A straight line on the plane, traced in the photo.

    Attributes:
        name: Its label.
        picks_px: Observed points, shape (n, 2).
        group: Number of the set of parallel lines that it belongs to.
    """

    name: str
    picks_px: Array
    group: int


@dataclass(frozen=True)
class Focal:
    """An observed focal length, ideal pixels of square height, with its relative error."""

    px: float
    sigma: float = SIGMA_FOCAL


@dataclass(frozen=True)
class Network:
    """All that was observed.

    Attributes:
        names: Names of the points.
        picks_px: Where they are seen, shape (n, 2).
        places_m: Where they lie, shape (n, 2); NaN where that was not measured.
        sigma_places_m: Standard error of each coordinate, shape (n,).
        sigma_pick_px: Standard error of a pick in each direction.
        flatness_m: Standard deviation of the plane's unevenness, of points above or below it.
        sigma_line_m: Sideways standard error of a point of a line on the plane.
        tapes: Measured distances.
        right_angles: Right angles.
        lines: Lines on the plane, in parallel sets.
        straight: Other straight lines in the photo, each (m, 2); they tell of the lens only.
        horizon_px: Points of the horizon, shape (m, 2).
        focal: The focal length, where it is known.
        sigma_centre_px: Standard error of the lens's centre; 0 holds it, infinity frees it.
        sigma_square_rad: How square the camera was held to the plane; None if it was not.
        refined: Coefficients of the lens that are adjusted.
        lens_covariance: Covariance of all of the lens's coefficients from its source, shape
            (k, k), zero where one is taken as exact; of refined ones infinite on the diagonal
            where the source knows nothing.
    """

    names: tuple[str, ...]
    picks_px: Array
    places_m: Array
    sigma_places_m: Array
    sigma_pick_px: float = SIGMA_PICK_PX
    flatness_m: float = FLATNESS_M
    sigma_line_m: float = SIGMA_GROUND_M
    tapes: tuple[Tape, ...] = ()
    right_angles: tuple[RightAngle, ...] = ()
    lines: tuple[GroundLine, ...] = ()
    straight: tuple[Array, ...] = ()
    horizon_px: Array = field(default_factory=lambda: np.empty((0, 2)))
    focal: Focal | None = None
    sigma_centre_px: float = 0.0
    sigma_square_rad: float | None = None
    refined: tuple[str, ...] = ()
    lens_covariance: Array | None = None

    @property
    def n_points(self) -> int:
        """Number of points."""
        return len(self.names)

    @property
    def n_groups(self) -> int:
        """Number of sets of parallel lines."""
        return max((line.group for line in self.lines), default=-1) + 1

    @property
    def known(self) -> Indices:
        """Indices of the points whose places were measured."""
        return np.flatnonzero(np.isfinite(self.places_m).all(axis=1)).astype(np.int64)

    @property
    def ground_picks_px(self) -> Array:
        """Every pick on the plane, which all lie below the horizon."""
        return np.concatenate((self.picks_px, *(line.picks_px for line in self.lines)))

    def without(self, index: int) -> Network:
        """The same observations without a point, and without what is measured to it."""
        kept = [at for at in range(self.n_points) if at != index]
        new = {old: at for at, old in enumerate(kept)}
        tapes = tuple(
            replace(t, first=new[t.first], second=new[t.second])
            for t in self.tapes
            if index not in (t.first, t.second)
        )
        angles = tuple(
            replace(a, first=new[a.first], corner=new[a.corner], last=new[a.last])
            for a in self.right_angles
            if index not in (a.first, a.corner, a.last)
        )
        return replace(
            self,
            names=tuple(self.names[at] for at in kept),
            picks_px=self.picks_px[kept],
            places_m=self.places_m[kept],
            sigma_places_m=self.sigma_places_m[kept],
            tapes=tapes,
            right_angles=angles,
        )

    def distances(self) -> tuple[Indices, Array]:
        """All known distances between points: pairs of indices (m, 2), metres (m,)."""
        known = self.known
        first, second = np.triu_indices(len(known), 1)
        apart = self.places_m[known[first]] - self.places_m[known[second]]
        taped = np.array([(t.first, t.second) for t in self.tapes], dtype=np.int64).reshape(-1, 2)
        pairs = np.concatenate((np.stack((known[first], known[second]), axis=1), taped))
        lengths = np.array([t.metres for t in self.tapes])
        return pairs, np.concatenate((np.hypot(*apart.T), lengths))

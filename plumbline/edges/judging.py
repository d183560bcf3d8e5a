"""How far edges that nobody looked at can be trusted, and where the photo shows any."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from plumbline.edges.rough_lens import RoughLens, one_coefficient, polynomial
from plumbline.frame import Array, Frame
from plumbline.geometry.lens import Lens
from plumbline.wording import joined, px

Border = Literal["top", "bottom", "left", "right"]

VOUCHED = 1e-3
"""Error over the photo's diagonal up to which lines are vouched for: what LensFun's contributors
hold to be good."""

_LEAST_LINES = 5
"""Lines below which there is nothing to compare (chosen: three coefficients and two to spare)."""

_CLUSTER = 0.07
"""Distance of parallel lines over R within which they are of one structure and bend together."""

_PARALLEL = 0.03
"""Radians between lines of one structure."""

_AGREE = 2.0
"""Times its standard error that the difference of two families may be."""

_FAMILY = 4
"""Lines of one direction that a lens can be fitted to by themselves."""

_GRID = 9
_MISSING = 3
"""Borders without a long edge from which nothing is vouched for (chosen, because edges near two of
them show the bend at all radii of the lens)."""

_NEAR = 0.6
"""Distance from the photo's middle over half its side from which a line is near a border."""

_LONG = 0.4
"""Length over the side of the photo that it runs along from which a line near a border counts."""


@dataclass(frozen=True)
class Verdict:
    """Whether lines are vouched for.

    Attributes:
        error_px: Standard error of the correction over the photo, where it is worst; infinite
            where too few lines tell it.
        reason: Why they are not vouched for; empty where they are.
    """

    error_px: float
    reason: str = ""

    @property
    def vouched(self) -> bool:
        """Whether they are."""
        return not self.reason


def judged(lines: Sequence[Array], frame: Frame) -> Verdict:
    """Judge lines by what lenses fitted to parts of them say.

    The error is the jackknife's over clusters of parallel neighbours, which bend together (both
    sides of a joint, rows of one sheet); where lines of two directions disagree by more than
    that, half their disagreement.

    Args:
        lines: Points of each line in pixels, shape (n, 2).
        frame: The photo's.
    """
    if len(lines) < _LEAST_LINES:
        return Verdict(np.inf, _few(len(lines)))
    start = one_coefficient(lines, frame)
    cluster = clusters(lines, start.lens)
    error = _jackknife(lines, start, cluster)
    apart = _between_families(lines, start)
    worst = float(np.max(error)) if error is not None else np.inf
    worst = max(worst, apart)
    missing = borders_missing(lines, frame)
    if len(missing) >= _MISSING:
        return Verdict(worst, f"no long edge runs near the {joined(missing)} of the photo")
    limit = VOUCHED * 2 * frame.corner_radius * frame.radius_px
    if not np.isfinite(worst):
        return Verdict(worst, "its edges are of too few structures to be compared")
    if worst > limit:
        return Verdict(
            worst,
            f"parts of its edges disagree: the correction is uncertain by \
{px(worst)}",
        )
    return Verdict(worst)


def borders_missing(lines: Sequence[Array], frame: Frame) -> list[Border]:
    """Borders of a photo that no long line runs near to."""
    half = np.array([frame.width, frame.height]) / 2
    seen: set[Border] = set()
    names: tuple[tuple[Border, Border], ...] = (("left", "right"), ("top", "bottom"))
    for points in lines:
        span = np.ptp(points, axis=0)
        across = int(span[1] < span[0])  # a level line is near the top or the bottom
        place = float((points[:, across].mean() - half[across]) / half[across])
        if span[1 - across] >= _LONG * 2 * half[1 - across] and abs(place) >= _NEAR:
            seen.add(names[across][int(place > 0)])
    return [name for pair in (names[1], names[0]) for name in pair if name not in seen]


def clusters(lines: Sequence[Array], lens: Lens) -> NDArray[np.int64]:
    """Which lines are parallel neighbours of one structure: the cluster of each, shape (l,)."""
    described = np.array([_described(points, lens) for points in lines])
    number = np.arange(len(lines))
    near = _CLUSTER * lens.frame.radius_px
    for one in range(len(lines)):
        for other in range(one):
            turn = abs((described[one, 0] - described[other, 0] + np.pi / 2) % np.pi - np.pi / 2)
            if turn < _PARALLEL and _apart(described[one], described[other]) < near:
                number[number == number[one]] = number[other]
    return np.unique(number, return_inverse=True)[1].astype(np.int64)


def _described(points: Array, lens: Lens) -> Array:
    """Direction and middle of a line after correction."""
    ideal = lens.undistort_or_nan(points)
    ideal = ideal[np.isfinite(ideal).all(axis=1)]
    middle = ideal.mean(axis=0)
    direction = np.linalg.svd(ideal - middle, full_matrices=False)[2][0]
    return np.array([np.arctan2(direction[1], direction[0]), *middle])


def _apart(one: Array, other: Array) -> float:
    """Distance of two parallel lines across."""
    normal = np.array([-np.sin(one[0]), np.cos(one[0])])
    return abs(float((one[1:] - other[1:]) @ normal))


def _jackknife(
    lines: Sequence[Array], start: RoughLens, cluster: NDArray[np.int64]
) -> Array | None:
    """Standard error of the correction over the photo, shape (m,)."""
    number = int(cluster.max()) + 1
    if number < _LEAST_LINES:
        return None
    fields = np.array(
        [_field(lines, start, np.where(cluster == left, 0.0, 1.0)) for left in range(number)]
    )
    gap = fields - fields.mean(axis=0)
    return np.sqrt((number - 1) / number * np.sum(gap**2, axis=(0, 2)))


def _between_families(lines: Sequence[Array], start: RoughLens) -> float:
    """Half of what level and upright lines disagree by, where their own errors allow less."""
    level = np.array([np.ptp(points[:, 0]) > np.ptp(points[:, 1]) for points in lines])
    families = [np.where(level, 1.0, 0.0), np.where(level, 0.0, 1.0)]
    fields: list[Array] = []
    errors: list[Array] = []
    for family in families:
        chosen = [points for points, each in zip(lines, family, strict=True) if each]
        if len(chosen) < _FAMILY:
            return 0.0
        own = _jackknife(chosen, start, clusters(chosen, start.lens))
        if own is None:
            return 0.0
        fields.append(_field(lines, start, family))
        errors.append(own)
    gap = np.hypot(*(fields[0] - fields[1]).T)
    allowed = _AGREE * np.hypot(errors[0], errors[1])
    return float(np.max(np.where(gap > allowed, gap / 2, 0.0)))


def _field(lines: Sequence[Array], start: RoughLens, weights: Array) -> Array:
    """Where a lens fitted to weighted lines puts points of the photo, shape (m, 2).

    After the best common scale and translation onto the first lens, which lines cannot see.
    """
    frame = start.lens.frame
    x, y = (np.linspace(0, side - 1, _GRID) for side in frame.size)
    grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    ideal = polynomial(lines, start, weights=weights).lens.undistort_or_nan(grid)
    to = start.lens.undistort_or_nan(grid)
    known = np.isfinite(ideal).all(axis=1) & np.isfinite(to).all(axis=1)
    a, b = ideal - ideal[known].mean(axis=0), to - to[known].mean(axis=0)
    scale = np.sum(a[known] * b[known]) / np.sum(a[known] ** 2)
    return np.nan_to_num(a * scale, nan=1e6)


def _few(number: int) -> str:
    if number == 0:
        return "it shows no long straight edge"
    return f"it shows only {number} long edges"

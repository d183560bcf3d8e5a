"""Ways in which picks go wrong: strays, picks given to the line beside, edges that are bent."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tests.benchmarks.simulated import Group
from tests.truth import Array

_NEAREST_PX, _FURTHEST_PX = 8.0, 100.0
_LIKE_DIRECTION = np.cos(np.radians(30.0))


class Spoiled(NamedTuple):
    """Picks of which some are bad.

    Attributes:
        points_px: All picks, shape (n, 2).
        bad: Which are bad, shape (n,).
    """

    points_px: Array
    bad: NDArray[np.bool_]


def chosen(n: int, share: float, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Which of n picks are spoiled: exactly that share of them, to the next whole pick."""
    bad = np.zeros(n, dtype=bool)
    bad[rng.choice(n, round(share * n), replace=False)] = True
    return bad


def moved(group: Group, points_px: Array, share: float, rng: np.random.Generator) -> Spoiled:
    """Move picks by 8 to 100 px in any direction that stays in the photo."""
    points = points_px.copy()
    bad = chosen(len(points), share, rng)
    upper = np.array(group.lens.size) - 1.0
    waiting = np.flatnonzero(bad)
    while len(waiting):
        angle = rng.uniform(0, 2 * np.pi, len(waiting))
        far = rng.uniform(_NEAREST_PX, _FURTHEST_PX, len(waiting))
        step = far[:, None] * np.stack((np.cos(angle), np.sin(angle)), axis=-1)
        points[waiting] = points_px[waiting] + step
        outside = np.any((points[waiting] < 0) | (points[waiting] > upper), axis=-1)
        waiting = waiting[outside]
    return Spoiled(points, bad)


def misplaced(group: Group, points_px: Array, share: float, rng: np.random.Generator) -> Spoiled:
    """Give picks to the neighbouring line: they lie on it, but keep their own line's label.

    They lie opposite to where they belong, as far as the neighbour's own picks reach.
    """
    bad = chosen(len(points_px), share, rng)
    ideal = np.concatenate([line.ideal_px for line in group.lines])
    targets: list[Array] = []
    for index in np.flatnonzero(bad).tolist():
        beside = group.lines[neighbour(group, int(group.line_of[index]))]
        place = (ideal[index] - beside.origin_px) @ beside.along
        place = np.clip(place, beside.places_px[0], beside.places_px[-1])
        targets.append(beside.origin_px + place * beside.along)
    points = points_px.copy()
    noise = group.noise_px * rng.standard_normal((len(targets), 2))
    points[bad] = group.lens.distort(np.array(targets)) + noise
    return Spoiled(points, bad)


def neighbour(group: Group, line: int) -> int:
    """The line of like direction whose picks' middle is nearest to a line's own."""
    middles = [one.ideal_px.mean(axis=0) for one in group.lines]
    own = group.lines[line]
    normal = own.along[::-1] * np.array([-1.0, 1.0])
    distances = np.full(len(middles), np.inf)
    for other, (one, middle) in enumerate(zip(group.lines, middles, strict=True)):
        if other != line and abs(float(one.along @ own.along)) > _LIKE_DIRECTION:
            distances[other] = abs(float((middle - middles[line]) @ normal))
    return int(np.argmin(distances))


SPOILERS = {"moved": moved, "on the line beside": misplaced}


def across_px(group: Group, points_px: Array) -> Array:
    """Distances in the photo from the true curves of the picks' own lines, to first order.

    Args:
        group: The group.
        points_px: Picks of all lines, shape (..., n, 2).
    """
    origins = np.array([line.origin_px for line in group.lines])[group.line_of]
    normals = np.array([line.along for line in group.lines])[group.line_of][:, ::-1]
    normals = normals * np.array([-1.0, 1.0])

    def distance(moved_by: tuple[float, float]) -> Array:
        ideal = group.lens.undistort(points_px + np.array(moved_by))
        return np.sum((ideal - origins) * normals, axis=-1)

    step = 0.05
    slopes = [
        (distance((step * x, step * y)) - distance((-step * x, -step * y))) / (2 * step)
        for x, y in ((1.0, 0.0), (0.0, 1.0))
    ]
    return np.abs(distance((0.0, 0.0))) / np.hypot(*slopes)


def bent(group: Group, picks_px: Array, amplitude_px: float = 0.5) -> Array:
    """Bend every edge of every trial across itself, smoothly and by the same amplitude.

    Each is half a sine, a whole one, a parabola or a cubic along its line, to either side; an edge
    bends anew in every trial.

    Args:
        group: The group.
        picks_px: Picks of all trials, shape (trials, n, 2).
        amplitude_px: Largest displacement in the photo.
    """
    rng = group.rng("bends", 0)
    shape = len(picks_px), len(group.lines)
    kinds = rng.integers(0, 4, shape)[:, group.line_of]
    sides = rng.choice([-1.0, 1.0], shape)[:, group.line_of]
    share = np.concatenate(
        [(line.places_px - line.places_px[0]) / np.ptp(line.places_px) for line in group.lines]
    )
    middle = 2 * share - 1
    curves = np.stack(
        (
            np.sin(np.pi * share),
            np.sin(2 * np.pi * share),
            2 * middle**2 - 1,
            1.5 * np.sqrt(3) * (middle**3 - middle),
        )
    )
    bends = amplitude_px * sides * np.take_along_axis(curves, kinds, axis=0)
    return picks_px + bends[..., None] * group.across

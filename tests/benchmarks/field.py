"""How far off a fit is over the photo, and how far off it must be: the Cramér-Rao bound.

Written with `tests.truth` alone. Straight lines see neither the scale nor the place of the
corrected photo (nor, with tangential terms, its perspective), so every difference is taken after
the best common scale and translation (or homography) over a grid of the whole photo.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from tests.benchmarks.simulated import Group
from tests.truth import (
    IDEAL_TO_OBSERVED,
    TANGENTIAL,
    Array,
    TrueLens,
    forward,
    grid_px,
    powers,
    scale,
)

GRID = 9
_HALVINGS = 60
_BEYOND = 1.5
_LOST_PX = 1e-4


def undistorted(like: TrueLens, fitted: Mapping[str, Array], model: str, points_px: Array) -> Array:
    """Undistort the same points by many lenses at once.

    Args:
        like: A lens of the photo's size, near the others: no ideal radius is looked for beyond
            1.5 times its largest.
        fitted: Each coefficient of the model, and `d` and `e`, shape (trials,).
        model: Its name.
        points_px: Observed points, shape (n, 2).

    Returns:
        Ideal points, shape (trials, n, 2); NaN where a lens does not reach a point.
    """
    names = (*powers(model), "d", "e")
    c = {name: fitted[name][:, None] for name in names}
    middle = (np.array(like.size) - 1) / 2
    offset = np.stack((fitted["d"], fitted["e"]), axis=-1)[:, None, :]
    points = (points_px - middle - offset) / like.unit_px
    if model not in IDEAL_TO_OBSERVED:
        return forward(model, c, points) * like.unit_px + middle
    assert model not in TANGENTIAL
    furthest = np.max(np.hypot(*(like.undistort(points_px) - middle).T)) / like.unit_px
    target = np.hypot(points[..., 0], points[..., 1])
    low, high = np.zeros_like(target), np.full_like(target, _BEYOND * furthest)
    for _ in range(_HALVINGS):
        half = (low + high) / 2
        below = half * scale(model, c, half) < target
        low, high = np.where(below, half, low), np.where(below, high, half)
    lost = np.abs(low * scale(model, c, low) - target) * like.unit_px > _LOST_PX
    ratio = np.where(target > 0, low / np.where(target > 0, target, 1.0), 1 / scale(model, c, low))
    ratio = np.where(lost, np.nan, ratio)
    return points * ratio[..., None] * like.unit_px + middle


def field_px(
    truth: TrueLens, fitted: Mapping[str, Array], model: str, *, perspective: bool = False
) -> Array:
    """Errors of the corrected photo that straight lines can see, at the grid's points.

    Args:
        truth: The true lens.
        fitted: Coefficients of many fits, see `undistorted`.
        model: The fitted model.
        perspective: Whether the fits leave the photo's perspective open.

    Returns:
        Shape (trials, GRID², 2), pixels.
    """
    points = grid_px(truth.size, GRID)
    want = truth.undistort(points)
    want = want - want.mean(axis=0)
    found = undistorted(truth, fitted, model, points)
    found = found - found.mean(axis=1, keepdims=True)
    size = np.sum(found * want, axis=(1, 2)) / np.sum(found**2, axis=(1, 2))
    gap = found * size[:, None, None] - want
    if not perspective:
        return gap
    unseen = np.linalg.qr(_motions(want / truth.unit_px))[0]
    flat = gap.reshape(len(gap), -1)
    return (flat - flat @ unseen @ unseen.T).reshape(gap.shape)


def _motions(points: Array) -> Array:
    """Small perspective motions of points, shape (2n, 8)."""
    x, y = points.T
    one, none = np.ones_like(x), np.zeros_like(x)
    moved = [(one, none), (none, one), (x, none), (y, none), (none, x), (none, y)]
    moved += [(x * x, x * y), (x * y, y * y)]
    return np.stack([np.stack(each, axis=-1).ravel() for each in moved], axis=-1)


def coefficients(fits: Sequence[Mapping[str, float]]) -> dict[str, Array]:
    """The coefficients of many fits, each of shape (trials,)."""
    return {name: np.array([fit[name] for fit in fits]) for name in fits[0]}


class Bound(NamedTuple):
    """The least that any unbiased fit can be uncertain.

    Attributes:
        covariance: Of the free coefficients, shape (k, k).
        field_px2: Covariance of the field at every point of the grid, shape (GRID², 2, 2).
    """

    covariance: Array
    field_px2: Array

    @property
    def rms_px(self) -> float:
        """Root mean square of the field's error over the grid."""
        return float(np.sqrt(np.mean(np.trace(self.field_px2, axis1=1, axis2=2))))


def names_of(group: Group) -> tuple[str, ...]:
    """The coefficients that the group's fit finds."""
    return group.free or tuple(powers(group.model))


def leaves_perspective(group: Group) -> bool:
    """Whether the group's fit leaves the photo's perspective open."""
    return bool(set(TANGENTIAL.get(group.model, ())) & set(names_of(group)))


def bound(group: Group) -> Bound:
    """The Cramér-Rao bound of a group whose truth is of the fitted family.

    Unknown are the coefficients, both parameters of every line, and the place of every pick on
    its line. A pick tells nothing of the last along the curve and so nothing of anything else
    there: what counts are the derivatives of the observed points across their curves. Those by
    the line parameters are projected out (Fisher information by Schur complement).
    """
    assert group.true_family
    lens, names = group.lens, names_of(group)
    ideal = np.concatenate([line.ideal_px for line in group.lines])
    along = np.repeat([line.along for line in group.lines], _sizes(group), axis=0)
    normal = along[:, ::-1] * np.array([-1.0, 1.0])
    places = np.concatenate([line.places_px for line in group.lines])[:, None]
    across = group.across
    turned = normal * places / lens.unit_px
    of_lines = np.stack(
        [
            np.sum(across * _difference(lambda h, m=m: lens.distort(ideal + h * m), 0.05), axis=1)
            for m in (normal, turned)
        ],
        axis=-1,
    )
    of_lens = np.stack(
        [
            np.sum(across * _difference(lambda h, n=n: _changed(lens, n, h).distort(ideal), s), 1)
            for n, s in ((n, _step(n)) for n in names)
        ],
        axis=-1,
    )
    rest: list[Array] = []
    for line in range(len(group.lines)):
        rows = group.line_of == line
        basis = np.linalg.qr(of_lines[rows])[0]
        rest.append(of_lens[rows] - basis @ (basis.T @ of_lens[rows]))
    seen = np.concatenate(rest)
    covariance: Array = group.noise_px**2 * np.linalg.inv(seen.T @ seen).astype(np.float64)
    slopes = _field_slopes(group, names)
    return Bound(covariance, np.einsum("pxi,ij,pyj->pxy", slopes, covariance, slopes))


def _field_slopes(group: Group, names: tuple[str, ...]) -> Array:
    """Derivatives of the field by the coefficients, shape (GRID², 2, k)."""
    perspective = leaves_perspective(group)

    def field(name: str, step: float) -> Array:
        changed = _changed(group.lens, name, step).all_coefficients
        return field_px(group.lens, coefficients([changed]), group.model, perspective=perspective)[
            0
        ]

    return np.stack(
        [_difference(lambda h, n=n: field(n, h), _step(n)) for n in names],
        axis=-1,
    )


def _sizes(group: Group) -> list[int]:
    return [len(line.places_px) for line in group.lines]


def _step(name: str) -> float:
    return 0.05 if name in ("d", "e") else 1e-5


def _changed(lens: TrueLens, name: str, step: float) -> TrueLens:
    return replace(
        lens, coefficients=lens.all_coefficients | {name: lens.all_coefficients[name] + step}
    )


def _difference(of: Callable[[float], Array], step: float) -> Array:
    """Derivative at 0, by central differences of fourth order."""
    near, far = of(step) - of(-step), of(2 * step) - of(-2 * step)
    return (8 * near - far) / (12 * step)

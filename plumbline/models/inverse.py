"""Run a model against its own direction: solve m(q) = p for q.

The radius is solved first, by Newton steps kept inside a bracket [0, limit], where `limit` is
the first radius at which the model folds (its slope vanishes) or the end of the range looked
at. Tangential terms, if any, are then taken in by Newton steps in the plane. The single steps
are shared with the fit, which loops over them in its own way.
"""

from __future__ import annotations

from typing import Any, ClassVar, Protocol

import numpy as np

from plumbline.frame import Array
from plumbline.models.polynomials import radius

REACH = 8.0
"""How far beyond the photo's corner an ideal point is looked for, in corner radii."""

_SAMPLES = 512
"""Radii at which a fold is looked for: chosen, since between two of them, a thousandth of the
reach near the photo's corner, a slope of these polynomials does not fall and rise again."""

_MOST_STEPS = 100
"""Newton steps; ten do, and bisection alone needs 60 for all digits."""

_ABSURD = 1e9
"""Normalised radius at which the search for a larger range stops: no photo is so wide."""

_OFF_POLE = 1e-6
"""Share of the range by which Newton's start keeps off a pole: each step doubles the distance to
it, and from the pole itself, where the slope is infinite, no step leads away."""


class Forward(Protocol):
    """What is inverted: a model's map in its own direction, see `plumbline.models.base.Model`."""

    tangential: ClassVar[tuple[str, ...]]

    def factor(self, r: Any, c: Any) -> Any:
        """Radius out over radius in."""
        ...

    def slope(self, r: Any, c: Any) -> Any:
        """Derivative of the radius out by the radius in."""
        ...

    def apply(self, x: Any, y: Any, c: Any) -> tuple[Any, Any]:
        """Map a point."""
        ...

    def jacobian(self, x: Any, y: Any, c: Any) -> tuple[Any, Any, Any, Any]:
        """Derivative of `apply` by the point."""
        ...


def limit_candidates(reach: Any, number: int, xp: Any) -> Any:
    """Radii, closer together near the centre, at which the slope is looked at for a fold."""
    return reach * (xp.arange(1.0, number + 1) / number) ** 2


def first_fold(model: Forward, c: Any, reach: float) -> float | None:
    """The first radius in (0, reach] at which the model folds, or None.

    The slope's sign is looked at on a grid, then its zero is bisected.
    """
    grid = limit_candidates(reach, _SAMPLES, np)
    with np.errstate(all="ignore"):
        bad = ~(model.slope(grid, c) > 0)
        if not np.any(bad):
            return None
        index = int(np.argmax(bad))
        low, high = (float(grid[index - 1]) if index else 0.0), float(grid[index])
        for _ in range(60):
            middle = (low + high) / 2
            if model.slope(np.float64(middle), c) > 0:
                low = middle
            else:
                high = middle
    return low


def radius_step(
    model: Forward, c: Any, target: Any, state: tuple[Any, Any, Any]
) -> tuple[Any, Any, Any]:
    """One Newton step for r f(r) = target, kept inside the bracket that it narrows.

    Args:
        model: The model.
        c: Its coefficients.
        target: The radii to reach.
        state: Current radii, lower and upper ends of their brackets.
    """
    r, low, high = state
    xp = r.__array_namespace__()
    gap = r * model.factor(r, c) - target
    low, high = xp.where(gap < 0, r, low), xp.where(gap < 0, high, r)
    step = r - gap / model.slope(r, c)
    return xp.where((step >= low) & (step <= high), step, (low + high) / 2), low, high


def plane_step(model: Forward, c: Any, x: Any, y: Any, u: Any, v: Any) -> tuple[Any, Any]:
    """One Newton step for m(u, v) = (x, y) from (u, v)."""
    mx, my = model.apply(u, v, c)
    xx, xy, yx, yy = model.jacobian(u, v, c)
    gx, gy, determinant = x - mx, y - my, xx * yy - xy * yx
    return u + (yy * gx - xy * gy) / determinant, v + (xx * gy - yx * gx) / determinant


def invert(model: Forward, c: Any, points: Array, reach: float) -> Array:
    """Solve m(q) = p.

    Args:
        model: The model.
        c: Its coefficients, in order.
        points: p, shape (..., 2), normalised, from the distortion centre.
        reach: The largest radius of q that is looked at.

    Returns:
        q, same shape, to a few units in the last place; NaN where the model folds before it
        reaches p, so that no q exists.
    """
    x, y = points[..., 0], points[..., 1]
    target = radius(x, y)
    top = np.float64(_range(model, c, target, reach))
    with np.errstate(divide="ignore"):  # the division model's pole may be hit exactly
        lost = target > top * model.factor(top, c)
    r = _inverse_radius(model, c, target, np.minimum(target, (1 - _OFF_POLE) * top), top)
    ratio = np.where(target > 0, r / np.where(target > 0, target, 1.0), 1.0)
    ratio = np.where(lost, np.nan, ratio)
    u, v = x * ratio, y * ratio
    if model.tangential:
        u, v, found = _settle(model, c, x, y, u, v)
        u, v = np.where(found, u, np.nan), np.where(found, v, np.nan)
    return np.stack((u, v), axis=-1)


def _range(model: Forward, c: Any, target: Array, reach: float) -> float:
    """The radius up to which the inverse is looked for: the fold, or beyond the last target."""
    farthest = float(np.max(target, initial=0.0, where=np.isfinite(target)))
    while True:
        fold = first_fold(model, c, reach)
        if fold is not None:
            return fold
        if reach * float(model.factor(np.float64(reach), c)) >= farthest or reach > _ABSURD:
            return reach
        reach *= 2


def _inverse_radius(model: Forward, c: Any, target: Array, r: Array, top: np.float64) -> Array:
    state = (r, np.zeros_like(r), np.full_like(r, top))
    with np.errstate(divide="ignore", invalid="ignore"):
        for _ in range(_MOST_STEPS):
            before = state[0]
            state = radius_step(model, c, target, state)
            if np.all(np.abs(state[0] - before) <= 4e-16 * state[0]):
                break
    return state[0]


def _settle(
    model: Forward, c: Any, x: Array, y: Array, u: Array, v: Array
) -> tuple[Array, Array, Array]:
    with np.errstate(all="ignore"):
        for _ in range(_MOST_STEPS):
            before = u, v
            u, v = plane_step(model, c, x, y, u, v)
            move = np.hypot(u - before[0], v - before[1])
            if not np.any(move > 4e-16 * np.hypot(u, v)):
                break
        xx, xy, yx, yy = model.jacobian(u, v, c)
        back = model.apply(u, v, c)
        found = (np.hypot(back[0] - x, back[1] - y) <= 1e-12 * (1 + np.hypot(x, y))) & (
            xx * yy - xy * yx > 0
        )
    return u, v, found

"""A start vector close enough for the solver, from nothing but the picks.

Plain Levenberg–Marquardt from zero ends in wrong minima for strong barrel distortion. The
division model with one coefficient undistorts in closed form and does not fold over the picks
between −1 and 1, so its single coefficient is found by looking at that whole range; its curve is
then written in the wanted model's coefficients by linear least squares on the radius.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jax import lax

from plumbline.fit.program.blocks import Block
from plumbline.fit.program.residual import line_sums
from plumbline.models.base import Model

_TRIALS = 24
"""Chosen, because the best curve is then close enough for all 4,215 ptlens lenses of LensFun."""
_CURVE_POINTS = 64
"""Radii at which curves are compared: chosen, far more than there are coefficients."""


def staged_start(
    model: Model,
    block: Block,
    held: jax.Array,
    free: jax.Array,
    gauge_radius: jax.Array,
) -> jax.Array:
    """Coefficients of `model` that follow the best one-coefficient division curve.

    Args:
        model: The wanted model.
        block: The points.
        held: Values of the held coefficients, the distortion centre last, shape (k + 2,).
        free: Which coefficients are free, shape (k + 2,).
        gauge_radius: The radius, in the same units, at which the model's scale is 1.
    """
    x, y = block.xy[..., 0] - held[-2], block.xy[..., 1] - held[-1]
    reach = jnp.sqrt(jnp.max((x * x + y * y) * block.weight))
    bend = _division(block, x, y, reach)
    return _translated(model, bend, held, free, reach, gauge_radius)


def _division(block: Block, x: jax.Array, y: jax.Array, reach: jax.Array) -> jax.Array:
    """l1 of the division model that straightens best.

    A line's sum of squared distances is the smaller eigenvalue of its second moments; divided by
    the larger one it does not depend on the scale of the corrected photo.
    """
    lengths = _moments(block, x, y)[1]
    r2 = (x * x + y * y) / reach**2

    def cost(bend: jax.Array) -> jax.Array:
        scale = 1 / (1 + bend * r2)
        across, along = _moments(block, x * scale, y * scale)
        return jnp.sum(jnp.where(along > 0, across * lengths / jnp.where(along > 0, along, 1.0), 0))

    trials = jnp.linspace(-0.97, 0.9, _TRIALS)
    costs = lax.map(cost, trials)
    best = jnp.clip(jnp.argmin(costs), 1, _TRIALS - 2)
    left, middle, right = costs[best - 1], costs[best], costs[best + 1]
    curvature = left - 2 * middle + right
    shift = jnp.where(curvature > 0, 0.5 * (left - right) / curvature, 0.0)
    step = trials[1] - trials[0]
    return (trials[best] + jnp.clip(shift, -1.0, 1.0) * step) / reach**2


def _moments(block: Block, u: jax.Array, v: jax.Array) -> tuple[jax.Array, jax.Array]:
    """The smaller and the larger eigenvalue of the second moments of every line."""
    values = jnp.stack((jnp.ones_like(u), u, v, u * u, u * v, v * v), axis=-1)
    n, su, sv, uu, uv, vv = line_sums(block, values).T
    n = jnp.maximum(n, 1.0)
    uu, uv, vv = uu - su * su / n, uv - su * sv / n, vv - sv * sv / n
    half, spread = (uu + vv) / 2, jnp.sqrt(((uu - vv) / 2) ** 2 + uv * uv)
    return jnp.maximum(half - spread, 0.0), half + spread


def _translated(
    model: Model,
    bend: jax.Array,
    held: jax.Array,
    free: jax.Array,
    reach: jax.Array,
    gauge_radius: jax.Array,
) -> jax.Array:
    observed = reach * jnp.arange(1.0, _CURVE_POINTS + 1) / _CURVE_POINTS
    # The division curve is true to scale at the centre; a model whose scale is 1 at the gauge
    # radius sees the same curve with its ideal radii divided by the curve's scale there.
    ideal = observed / (1 + bend * observed**2) * jnp.maximum(1 + bend * gauge_radius**2, 0.05)

    def miss(c: jax.Array) -> jax.Array:
        return model.curve_miss(observed, ideal, c)

    radial = jnp.array([name not in model.tangential for name in model.coefficients])
    fitted = free[:-2] & radial
    base = jnp.where(fitted, 0.0, held[:-2])
    design = jnp.where(fitted, jax.jacfwd(miss)(base), 0.0)
    ridge = 1e-9 * jnp.sum(design**2) + jnp.finfo(design.dtype).tiny
    normal = design.T @ design + ridge * jnp.eye(design.shape[1])
    solution = jnp.linalg.solve(normal, -design.T @ miss(base))
    return jnp.concatenate((jnp.where(fitted, solution, held[:-2]), held[-2:]))

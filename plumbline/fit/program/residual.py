"""The residual: how far undistorted points are from being straight, in pixels.

For each line the points are undistorted and a line is fitted to them by orthogonal least
squares, in closed form: its direction θ is half the angle of the second moments,
tan 2θ = 2 S_xy / (S_xx − S_yy) (Pearson 1901). The signed distance of each point is the
"corrected" residual; divided by its derivative by the observed point it becomes the "image"
residual, the first-order distance in the photograph's own pixels, where the picking noise
lives (Sampson 1982).
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import lax

from plumbline.fit.program.blocks import Block
from plumbline.fit.program.task import Residuals
from plumbline.models.base import Model
from plumbline.models.inverse import limit_candidates, plane_step, radius_step
from plumbline.models.polynomials import radius

_MOST_STEPS = 60
"""Newton steps for the radius: bisection alone needs 53 for all digits."""
_PLANE_STEPS = 8
"""Newton steps in the plane: each doubles the digits, and tangential terms are small."""
_CLOSE = 1e-8
"""Relative change of a radius after which one more Newton step is exact."""
_SLOPES = 64
"""Radii at which a fold is looked for: chosen, because the fit needs it to a thousandth only."""


class Undistorted(NamedTuple):
    """Ideal points and how the undistortion stretches there.

    Attributes:
        u: Ideal x, any shape.
        v: Ideal y.
        jacobian: ∂u/∂x, ∂u/∂y, ∂v/∂x, ∂v/∂y.
        excess: How far beyond the fold of the model a point lies; 0 for all good points.
    """

    u: jax.Array
    v: jax.Array
    jacobian: tuple[jax.Array, jax.Array, jax.Array, jax.Array]
    excess: jax.Array


def undistort(
    model: Model, c: jax.Array, x: jax.Array, y: jax.Array, reach: jax.Array
) -> Undistorted:
    """Undistort points measured from the distortion centre.

    Args:
        model: The model.
        c: Its coefficients.
        x: Observed x; any shape.
        y: Observed y.
        reach: The largest ideal radius that is looked at.
    """
    if model.takes_observed:
        u, v = model.apply(x, y, c)
        return Undistorted(u, v, model.jacobian(x, y, c), jnp.zeros_like(x))
    u, v, excess = _invert(model, c, x, y, reach)
    good = excess == 0
    xx, xy, yx, yy = model.jacobian(u, v, c)
    determinant = jnp.where(good, xx * yy - xy * yx, 1.0)
    jacobian = yy / determinant, -xy / determinant, -yx / determinant, xx / determinant
    return Undistorted(u, v, jacobian, excess)


@partial(jax.custom_jvp, nondiff_argnums=(0,))
def _invert(
    model: Model, c: jax.Array, x: jax.Array, y: jax.Array, reach: jax.Array
) -> tuple[jax.Array, jax.Array, jax.Array]:
    """Solve m(u, v) = (x, y); how far beyond the fold a point lies comes third."""
    target = radius(x, y)
    top = _limit(model, c, reach)
    excess = jnp.maximum(target - top * model.factor(top, c), 0.0)
    aim = jnp.where(excess > 0, 0.0, target)

    def unsettled(carry: tuple[jax.Array, ...]) -> jax.Array:
        step, before, r, *_ = carry
        return (step < _MOST_STEPS) & jnp.any(jnp.abs(r - before) > _CLOSE * r)

    def improve(carry: tuple[jax.Array, ...]) -> tuple[jax.Array, ...]:
        step, _, r, low, high = carry
        return (step + 1, r, *radius_step(model, c, aim, (r, low, high)))

    def closer(_: int, uv: tuple[jax.Array, jax.Array]) -> tuple[jax.Array, jax.Array]:
        return plane_step(model, c, x, y, *uv)

    start = jnp.minimum(aim, top)
    carry = (jnp.array(0), start - 1, start, jnp.zeros_like(r0 := aim), jnp.full_like(r0, top))
    r = lax.while_loop(unsettled, improve, carry)[2]
    r = jnp.where(excess > 0, top, r)
    ratio = jnp.where(target > 0, r / jnp.where(target > 0, target, 1.0), 1.0)
    u, v = x * ratio, y * ratio
    if model.tangential:
        u, v = lax.fori_loop(0, _PLANE_STEPS, closer, (u, v))
    closest = plane_step(model, c, x, y, u, v)
    good = excess == 0
    return jnp.where(good, closest[0], u), jnp.where(good, closest[1], v), excess


@_invert.defjvp
def _invert_jvp(
    model: Model, primals: tuple[jax.Array, ...], tangents: tuple[jax.Array, ...]
) -> tuple[tuple[jax.Array, ...], tuple[jax.Array, ...]]:
    """Differentiate the implicit function, not the iterations that solve it."""
    c, x, y, reach = primals
    u, v, excess = _invert(model, c, x, y, reach)
    moved = jax.jvp(partial(model.apply, u, v), (c,), (tangents[0],))[1]
    xx, xy, yx, yy = model.jacobian(u, v, c)
    good = excess == 0
    determinant = jnp.where(good, xx * yy - xy * yx, 1.0)
    gx, gy = (jnp.where(good, t - m, 0.0) for t, m in zip(tangents[1:3], moved, strict=True))
    du, dv = (yy * gx - xy * gy) / determinant, (xx * gy - yx * gx) / determinant
    return (u, v, excess), (du, dv, jnp.zeros_like(excess))


def _limit(model: Model, c: jax.Array, reach: jax.Array) -> jax.Array:
    """The first radius up to `reach` at which the model folds, to a thousandth or so; else it."""
    radii = limit_candidates(reach, _SLOPES, jnp)
    slopes = model.slope(radii, c)
    folds = ~(slopes > 0)
    first = jnp.argmax(folds)
    before = jnp.maximum(first - 1, 0)
    share = jnp.clip(slopes[before] / (slopes[before] - slopes[first]), 0.0, 1.0)
    between = radii[before] + jnp.nan_to_num(share) * (radii[first] - radii[before])
    return jnp.where(jnp.any(folds), between, reach)


def residuals(
    model: Model,
    coefficients: jax.Array,
    block: Block,
    unit_px: jax.Array,
    reach: jax.Array,
    aspect: jax.Array | float = 1.0,
) -> Residuals:
    """Residuals of all points of a block.

    Args:
        model: The distortion model.
        coefficients: The model's, then the distortion centre in normalised units.
        block: The points.
        unit_px: Pixels to a normalised radius of 1.
        reach: The largest ideal radius that is looked at.
        aspect: Width of one of the photo's pixels over its height.
    """
    x = block.xy[..., 0] - coefficients[-2]
    y = block.xy[..., 1] - coefficients[-1]
    u, v, (xx, xy, yx, yy), excess = undistort(model, coefficients[:-2], x, y, reach)
    from_u, from_v, nx, ny = _line_frame(block, u, v)
    distance = nx * from_u + ny * from_v
    across_x, across_y = (nx * xx + ny * yx) * aspect, nx * xy + ny * yy
    stretch = jnp.sqrt(across_x * across_x + across_y * across_y)
    corrected = (distance + excess) * unit_px * block.weight
    image = (distance / stretch + excess) * unit_px * block.weight
    return Residuals(image, corrected, xx * yy - xy * yx, excess, u, v)


def _line_frame(
    block: Block, u: jax.Array, v: jax.Array
) -> tuple[jax.Array, jax.Array, jax.Array, jax.Array]:
    """Points relative to the centroid of their line, and the line's unit normal, per row."""

    def of_line(*values: jax.Array) -> list[jax.Array]:
        totals = line_sums(block, jnp.stack(values, axis=-1))
        return [total[:, None] for total in totals[block.row_line].T]

    n, sum_u, sum_v = of_line(jnp.ones_like(u), u, v)
    u, v = u - sum_u / jnp.maximum(n, 1.0), v - sum_v / jnp.maximum(n, 1.0)
    cross, spread = of_line(2 * u * v, u * u - v * v)
    spread = jnp.where((cross == 0) & (spread == 0), 1.0, spread)
    whole = jnp.sqrt(cross * cross + spread * spread)
    # Half an angle without trigonometry, by the form that does not cancel.
    flat = spread >= 0
    along_x = jnp.where(flat, whole + spread, cross)
    along_y = jnp.where(flat, cross, whole - spread)
    length = jnp.sqrt(along_x * along_x + along_y * along_y)
    return u, v, -along_y / length, along_x / length


def line_sums(block: Block, values: jax.Array) -> jax.Array:
    """Sums over the points of every line.

    Args:
        block: The points.
        values: Shape (rows, width, m).

    Returns:
        Shape (rows, m); lines beyond the last are 0.
    """
    sums = jnp.einsum("rw,rwm->rm", block.weight, values)
    return jax.ops.segment_sum(
        sums, block.row_line, num_segments=block.row_line.shape[0], indices_are_sorted=True
    )

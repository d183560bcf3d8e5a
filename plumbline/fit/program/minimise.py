"""The fit as JAX traces it: staged start, then Levenberg–Marquardt on all points.

One program serves every problem of one model and one block shape: which coefficients are free,
the start vector and the kind of residual are run-time arguments. Only whether the distortion
centre may be free is fixed, since nearly always it is not and two derivatives in five are saved.
"""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import optimistix as optx
from jax import lax

from plumbline.fit.program.levenberg import PreciseLevenbergMarquardt
from plumbline.fit.program.residual import residuals
from plumbline.fit.program.start import staged_start
from plumbline.fit.program.task import FitTask, Solution
from plumbline.models import CENTRE
from plumbline.models.base import Model
from plumbline.models.inverse import REACH

_TOLERANCE = 1e-10
"""Chosen a hundred times finer than what `is_settled` asks for."""
_SMALL_STEP_PX = 1.0
"""Change of all residuals together below which the last step is taken untried: chosen, since the
search only ends where far less is left, or after its last step."""
_MOST_STEPS = 200
"""Chosen, because a staged start takes 5 to 20; what takes more does not converge."""


def minimise(model: Model, centre: bool, task: FitTask) -> Solution:
    """Fit one problem.

    Args:
        model: The distortion model.
        centre: Whether the distortion centre may be free.
        task: The problem, as arrays of JAX.
    """
    task = jax.tree.map(jnp.asarray, task)
    found = staged_start(model, task.block, task.start, task.free, task.gauge_radius)
    y0 = jnp.where(task.staged & task.free, found, task.start)
    scale = _scale(model, centre, y0, task)
    solver = PreciseLevenbergMarquardt(rtol=_TOLERANCE, atol=_TOLERANCE)
    solution = optx.least_squares(
        partial(_condensed, model, centre),
        solver,
        y0 / scale,
        (task, scale),
        has_aux=True,
        max_steps=_MOST_STEPS,
        throw=False,
    )
    products = solution.aux
    step = -jax.scipy.linalg.cho_solve(
        (jnp.linalg.cholesky(products.normal), True), products.gradient
    )
    # One more Gauss–Newton step, for which the derivative is at hand already.
    last = jnp.sqrt(jnp.maximum(step @ products.normal @ step, 0.0)) * task.unit_px
    step = jnp.where(task.free & (last < _SMALL_STEP_PX), step * scale, 0.0)
    final = jnp.where(task.free, solution.value * scale + step, task.start)
    at = residuals(model, final, task.block, task.unit_px, REACH * task.corner, task.aspect)
    counts = task.block.weight > 0
    beyond = at.excess > 0
    folded = counts & (beyond | ~(at.determinant > 0))
    scales = jnp.where(counts & ~folded, jnp.sqrt(jnp.abs(at.determinant)), 0.0)
    return Solution(
        final,
        jnp.where(task.image, at.image, at.corrected),
        jnp.where(beyond, jnp.nan, at.u),
        jnp.where(beyond, jnp.nan, at.v),
        jnp.sum(at.corrected**2),
        jnp.sum(scales) / jnp.sum(counts.astype(scales.dtype)),
        jnp.sum(folded),
        products.normal * task.unit_px**2 / (scale[:, None] * scale),
        last,
        solution.stats["num_steps"],
    )


def _scale(model: Model, centre: bool, y: jax.Array, task: FitTask) -> jax.Array:
    """What each coefficient is measured in, so that all move the residuals alike.

    A coefficient of r⁶ in focal lengths of a long lens is worth a millionth of one of r².
    """
    slopes = jnp.sqrt(jnp.diag(_products(model, centre, y, task, jnp.ones_like(y)).normal))
    known = jnp.isfinite(slopes) & (slopes > 0)
    return jnp.where(known, 1 / jnp.where(known, slopes, 1.0), 1.0)


class _Products(NamedTuple):
    """JᵀJ, Jᵀr and rᵀr of the residuals r in normalised units, by scaled coefficients.

    Held coefficients have a one on the diagonal of JᵀJ, which keeps its full rank.
    """

    normal: jax.Array
    gradient: jax.Array
    cost: jax.Array


@partial(jax.jit, static_argnums=(0, 1))
def _products(
    model: Model, centre: bool, y: jax.Array, task: FitTask, scale: jax.Array
) -> _Products:
    def fitted(y: jax.Array) -> jax.Array:
        held = jnp.where(task.free, y * scale, task.start)
        at = residuals(model, held, task.block, task.unit_px, REACH * task.corner, task.aspect)
        return jnp.where(task.image, at.image, at.corrected) / task.unit_px

    value, slope = jax.linearize(fitted, y)
    size = y.shape[0]
    moving = size if centre else size - len(CENTRE)
    jacobian = lax.map(slope, jnp.eye(size)[:moving])
    jacobian = jnp.where(task.free[:moving, None, None], jacobian, 0.0)
    rest = size - moving
    normal = jnp.pad(jnp.einsum("irw,jrw->ij", jacobian, jacobian), (0, rest))
    normal = normal + jnp.diag(jnp.where(task.free, 0.0, 1.0))
    gradient = jnp.pad(jnp.einsum("irw,rw->i", jacobian, value), (0, rest))
    return _Products(normal, gradient, jnp.sum(value * value))


@partial(jax.custom_jvp, nondiff_argnums=(0, 1))
def _condensed(
    model: Model, centre: bool, y: jax.Array, args: tuple[FitTask, jax.Array]
) -> tuple[jax.Array, _Products]:
    """A residual of k + 1 numbers that the solver cannot tell from that of all points.

    Levenberg–Marquardt sees a residual r and its derivative J only through rᵀr, Jᵀr and JᵀJ.
    The Cholesky factor of [J r]ᵀ[J r] gives k + 1 numbers with the same three products, however
    many points there are. The products come along as the second value.
    """
    value, _, products = _condense(model, centre, y, *args)
    return value, products


@_condensed.defjvp
def _condensed_jvp(
    model: Model,
    centre: bool,
    primals: tuple[jax.Array, tuple[FitTask, jax.Array]],
    tangents: tuple[jax.Array, tuple[FitTask, jax.Array]],
) -> tuple[Any, Any]:
    y, args = primals
    value, jacobian, products = _condense(model, centre, y, *args)
    return (value, products), (jacobian @ tangents[0], jax.tree.map(jnp.zeros_like, products))


def _condense(
    model: Model, centre: bool, y: jax.Array, task: FitTask, scale: jax.Array
) -> tuple[jax.Array, jax.Array, _Products]:
    products = _products(model, centre, y, task, scale)
    lower = jnp.linalg.cholesky(products.normal)
    top = jax.scipy.linalg.solve_triangular(lower, products.gradient, lower=True)
    rest = jnp.sqrt(jnp.maximum(products.cost - top @ top, 0.0))
    value = jnp.concatenate((top, rest[None]))
    jacobian = jnp.concatenate((lower.T, jnp.zeros((1, y.shape[0]))))
    return value, jacobian, products

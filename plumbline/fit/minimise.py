"""The fit as JAX traces it: staged start, then Levenberg–Marquardt on all points.

One program serves every problem of one model and one block shape: which coefficients are free,
the start vector and the kind of residual are run-time arguments.
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import optimistix as optx

from plumbline.fit.levenberg import PreciseLevenbergMarquardt
from plumbline.fit.residual import residuals
from plumbline.fit.start import staged_start
from plumbline.fit.task import Residuals, Solution, Task
from plumbline.models.base import Model
from plumbline.models.inverse import REACH

_TOLERANCE = 1e-10
_SMALL_STEP = 1e-4
_MOST_STEPS = 200


def minimise(model: Model, task: Task) -> Solution:
    """Fit one problem.

    Args:
        model: The distortion model.
        task: The problem, as arrays of JAX.
    """
    task = jax.tree.map(jnp.asarray, task)
    found = staged_start(model, task.block, task.start, task.free, task.unit_px, task.gauge_radius)
    y0 = jnp.where(task.staged & task.free, found, task.start)
    solver = PreciseLevenbergMarquardt(rtol=_TOLERANCE, atol=_TOLERANCE)
    solution = optx.least_squares(
        partial(_condensed, model),
        solver,
        y0,
        task,
        has_aux=True,
        max_steps=_MOST_STEPS,
        throw=False,
    )
    at = solution.aux
    normal, gradient, _ = _products(at, task)
    step = -jax.scipy.linalg.cho_solve((jnp.linalg.cholesky(normal), True), gradient)
    # One more Gauss–Newton step, for which the derivative is at hand already.
    last = jnp.max(jnp.abs(step))
    step = jnp.where(task.free & (last < _SMALL_STEP), step, 0.0)
    return Solution(
        jnp.where(task.free, solution.value + step, task.start),
        (at.value + jnp.einsum("irw,i->rw", at.jacobian, step)) * task.unit_px,
        at.residuals,
        at.jacobian * task.unit_px,
        last,
        solution.stats["num_steps"],
    )


class _Linear(NamedTuple):
    """The fitted kind of residual, in normalised units, and its derivative by the coefficients.

    `jacobian` has the shape (k + 2, rows, width).
    """

    value: jax.Array
    jacobian: jax.Array
    residuals: Residuals


@partial(jax.jit, static_argnums=0)
def _linearised(model: Model, y: jax.Array, task: Task) -> _Linear:
    def fitted(y: jax.Array) -> tuple[jax.Array, Residuals]:
        held = jnp.where(task.free, y, task.start)
        at = residuals(model, held, task.block, task.unit_px, REACH * task.corner)
        return jnp.where(task.image, at.image, at.corrected) / task.unit_px, at

    def along(direction: jax.Array) -> tuple[jax.Array, jax.Array, Residuals]:
        return jax.jvp(fitted, (y,), (direction,), has_aux=True)

    value, jacobian, at = jax.vmap(along, out_axes=(None, 0, None))(jnp.eye(y.shape[0]))
    return _Linear(value, jnp.where(task.free[:, None, None], jacobian, 0.0), at)


@partial(jax.custom_jvp, nondiff_argnums=(0,))
def _condensed(model: Model, y: jax.Array, task: Task) -> tuple[jax.Array, _Linear]:
    """A residual of k + 1 numbers that the solver cannot tell from that of all points.

    Levenberg–Marquardt sees a residual r and its derivative J only through rᵀr, Jᵀr and JᵀJ.
    The Cholesky factor of [J r]ᵀ[J r] gives k + 1 numbers with the same three products, however
    many points there are. What it stands for comes along as the second value.
    """
    value, _, at = _condense(model, y, task)
    return value, at


@_condensed.defjvp
def _condensed_jvp(
    model: Model, primals: tuple[jax.Array, Task], tangents: tuple[jax.Array, Task]
) -> tuple[tuple[jax.Array, _Linear], tuple[jax.Array, _Linear]]:
    value, jacobian, at = _condense(model, *primals)
    return (value, at), (jacobian @ tangents[0], jax.tree.map(jnp.zeros_like, at))


def _condense(model: Model, y: jax.Array, task: Task) -> tuple[jax.Array, jax.Array, _Linear]:
    at = _linearised(model, y, task)
    normal, gradient, cost = _products(at, task)
    lower = jnp.linalg.cholesky(normal)
    top = jax.scipy.linalg.solve_triangular(lower, gradient, lower=True)
    rest = jnp.sqrt(jnp.maximum(cost - top @ top, 0.0))
    value = jnp.concatenate((top, rest[None]))
    return value, jnp.concatenate((lower.T, jnp.zeros((1, y.shape[0])))), at


def _products(at: _Linear, task: Task) -> tuple[jax.Array, jax.Array, jax.Array]:
    """JᵀJ, Jᵀr and rᵀr; held coefficients get a one on the diagonal, to keep full rank."""
    normal = jnp.einsum("irw,jrw->ij", at.jacobian, at.jacobian)
    normal = normal + jnp.diag(jnp.where(task.free, 0.0, 1.0))
    gradient = jnp.einsum("irw,rw->i", at.jacobian, at.value)
    return normal, gradient, jnp.sum(at.value * at.value)

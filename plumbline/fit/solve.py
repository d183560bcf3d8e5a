"""The compiled fit: staged start, Levenberg–Marquardt, and what the summary needs after it.

One program serves every problem of one model and one block shape: which coefficients are
free, the start vector and the kind of residual are run-time arguments. `solve_many` runs a
batch of equally shaped problems in one program.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx
from jax import lax
from numpy.typing import NDArray

from plumbline.fit import cache
from plumbline.fit.blocks import Block
from plumbline.fit.residual import Residuals, residuals
from plumbline.fit.start import staged_start
from plumbline.frame import Array
from plumbline.models.base import Model
from plumbline.models.inverse import REACH

BATCH = 64
"""Problems that `solve_many` takes in one program."""

_TOLERANCE = 1e-7
_MOST_STEPS = 200
_POLISHING_STEPS = 4
_SMALL_STEP = 1e-3


class Task(NamedTuple):
    """One fit, as arrays.

    Attributes:
        block: The points.
        start: Start and held values, the distortion centre last and normalised, (k + 2,).
        free: Which coefficients are free, (k + 2,).
        staged: Whether free coefficients are found from nothing; else `start` is taken.
        image: Whether the residual is that in the photograph, else in the corrected one.
        unit_px: Square pixels to a normalised radius of 1.
        gauge_radius: Normalised radius at which the model's scale is 1.
        corner: Normalised radius of the photo's corner.
    """

    block: Block
    start: Array
    free: NDArray[np.bool_]
    staged: bool
    image: bool
    unit_px: float
    gauge_radius: float
    corner: float


class Solution(NamedTuple):
    """What a fit found; arrays as in `Task` and `Residuals`.

    Attributes:
        coefficients: Fitted and held values, (k + 2,).
        residuals: Residuals at the solution.
        jacobian: Derivative of the fitted kind of residual by the coefficients,
            (rows, width, k + 2), in pixels; 0 for held coefficients.
        last_step: The largest change of a coefficient that one more Gauss–Newton step asks
            for; close to 0 at a minimum.
        steps: Steps the solver took.
    """

    coefficients: Array
    residuals: Residuals
    jacobian: Array
    last_step: float
    steps: int


def solve(model: Model, task: Task) -> Solution:
    """Fit one problem.

    Args:
        model: The distortion model.
        task: The problem.
    """
    cache.enable()
    with jax.enable_x64(True):
        return jax.tree.map(np.asarray, _program(model, _as_arrays(task)))


def solve_many(model: Model, tasks: Sequence[Task]) -> list[Solution]:
    """Fit at most `BATCH` problems whose blocks have one shape, in one program.

    The batch is filled up with repetitions, so that every batch of that shape shares it.
    """
    cache.enable()
    filled = [*tasks, *[tasks[-1]] * (BATCH - len(tasks))]
    with jax.enable_x64(True):
        stacked = jax.tree.map(lambda *leaves: np.stack(leaves), *map(_as_arrays, filled))
        solved = jax.tree.map(np.asarray, _batch_program(model, stacked))
    return [jax.tree.map(lambda leaf, i=i: leaf[i], solved) for i in range(len(tasks))]


def reach_of(corner: float) -> float:
    """The largest ideal radius that is looked at, for a corner at that radius."""
    return REACH * corner


def _as_arrays(task: Task) -> Task:
    return jax.tree.map(np.asarray, task)


@partial(jax.jit, static_argnums=0)
def _program(model: Model, task: Task) -> Solution:
    return _fit(model, task)


@partial(jax.jit, static_argnums=0)
def _batch_program(model: Model, tasks: Task) -> Solution:
    return jax.vmap(partial(_fit, model))(tasks)


def _fit(model: Model, task: Task) -> Solution:
    block, unit_px, free = task.block, jnp.asarray(task.unit_px), jnp.asarray(task.free)
    start, reach = jnp.asarray(task.start), jnp.asarray(reach_of(task.corner))
    found = staged_start(model, block, start, free, unit_px, jnp.asarray(task.gauge_radius))
    y0 = jnp.where(jnp.asarray(task.staged), jnp.where(free, found, start), start)

    def every(y: jax.Array) -> tuple[jax.Array, Residuals]:
        at = residuals(model, jnp.where(free, y, start), block, unit_px, reach)
        return jnp.where(task.image, at.image, at.corrected), at

    def objective(y: jax.Array, _: None) -> jax.Array:
        # Held coefficients get a residual of their own, so that the system keeps full rank.
        return jnp.concatenate((every(y)[0].ravel(), jnp.where(free, 0.0, y - start)))

    solver = optx.LevenbergMarquardt(rtol=_TOLERANCE, atol=_TOLERANCE)
    solution = optx.least_squares(
        eqx.Partial(objective), solver, y0, max_steps=_MOST_STEPS, throw=False
    )
    final, jacobian, at, last_step = _polished(every, solution.value, free)
    steps = solution.stats["num_steps"]
    return Solution(jnp.where(free, final, start), at, jacobian, last_step, steps)


def _polished(
    every: Callable[[jax.Array], tuple[jax.Array, Residuals]], y: jax.Array, free: jax.Array
) -> tuple[jax.Array, jax.Array, Residuals, jax.Array]:
    """A few undamped Gauss–Newton steps from the solver's end, and the derivative there.

    The solver compares sums of squares, which stop changing at the square root of the
    precision; the steps themselves go on shrinking. A step that does not, or that is no
    small correction, is not taken.
    """
    shape = jax.eval_shape(every, y)[1]
    zeros = jax.tree.map(lambda leaf: jnp.zeros(leaf.shape, leaf.dtype), shape)

    def linearised(y: jax.Array) -> tuple[jax.Array, jax.Array, Residuals]:
        def twice(y: jax.Array) -> tuple[jax.Array, tuple[jax.Array, Residuals]]:
            value, at = every(y)
            return value, (value, at)

        jacobian, (value, at) = jax.jacfwd(twice, has_aux=True)(y)
        return jnp.where(free, jacobian, 0.0), value, at

    def body(_: int, carry: tuple[Any, ...]) -> tuple[Any, ...]:
        y, step, *_ = carry
        y = y + jnp.where(jnp.max(jnp.abs(step)) < _SMALL_STEP, step, 0.0)
        jacobian, value, at = linearised(y)
        normal = jnp.einsum("rwi,rwj->ij", jacobian, jacobian) + jnp.diag(jnp.where(free, 0.0, 1.0))
        step = -jnp.linalg.solve(normal, jnp.einsum("rwi,rw->i", jacobian, value))
        return y, step, jacobian, at

    no_jacobian = jnp.zeros((*zeros.image.shape, y.shape[0]))
    carry = (y, jnp.zeros_like(y), no_jacobian, zeros)
    y, step, jacobian, at = lax.fori_loop(0, _POLISHING_STEPS, body, carry)
    return y, jacobian, at, jnp.max(jnp.abs(step))

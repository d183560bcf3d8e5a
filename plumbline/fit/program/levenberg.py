"""Levenberg–Marquardt that converges to the precision of the numbers.

optimistix's own accepts a step if it lowers the sum of squares. Near the minimum the sum stops
changing at the square root of the precision, and steps that are right are refused from there on.
The search here takes a step that is too small for the sum to judge, so that the last steps are
those of Gauss and Newton.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import optimistix as optx

_FIRST_STEP_SIZE = 1e8
"""Next to no damping: chosen, because the staged start is close."""
_UNJUDGEABLE = 1e-12
"""Change of the sum of squares below which it is rounding: a few thousand units of 2⁻⁵²."""


class SmallDescent(optx.AbstractDescent[Any, Any, Any]):
    """The damped step −(JᵀJ + λ)⁻¹ Jᵀr of a few coefficients; λ is the inverse of the step size.

    optimistix's own goes through a general linear solver, which takes longer to trace and to
    compile. The state is Jᵀr and JᵀJ.
    """

    def init(self, y: jax.Array, f_info_struct: Any) -> tuple[jax.Array, jax.Array]:  # noqa: ARG002
        """Zeros of the right shape."""
        return jnp.zeros_like(y), jnp.zeros((y.shape[0], y.shape[0]), y.dtype)

    def query(
        self,
        y: jax.Array,  # noqa: ARG002
        f_info: Any,
        state: tuple[jax.Array, jax.Array],  # noqa: ARG002
    ) -> tuple[jax.Array, jax.Array]:
        """Take the products from the last accepted point."""
        jacobian = f_info.jac.as_matrix()
        return jacobian.T @ f_info.residual, jacobian.T @ jacobian

    def step(
        self, step_size: jax.Array, state: tuple[jax.Array, jax.Array]
    ) -> tuple[jax.Array, optx.RESULTS]:
        """The step for that step size."""
        gradient, normal = state
        damped = normal + jnp.eye(gradient.shape[0]) / step_size
        step = -jax.scipy.linalg.cho_solve((jnp.linalg.cholesky(damped), True), gradient)
        return step, optx.RESULTS.successful


class PreciseTrustRegion(optx.AbstractSearch[Any, Any, Any, Any]):
    """The classical trust region, but for steps below the rounding of the sum of squares.

    The constants are those of N. Gould et al., "Sensitivity of trust-region algorithms to
    their parameters", 2005. The state is the step size, the inverse of the damping.
    """

    def init(self, y: Any, f_info_struct: Any) -> jax.Array:  # noqa: ARG002
        """Start with little damping: the staged start is close."""
        return jnp.array(_FIRST_STEP_SIZE)

    def step(
        self,
        first_step: jax.Array,
        y: jax.Array,
        y_eval: jax.Array,
        f_info: Any,
        f_eval_info: Any,
        state: jax.Array,
    ) -> tuple[jax.Array, jax.Array, optx.RESULTS, jax.Array]:
        """Judge the step from `y` to `y_eval`, and choose the next step size."""
        moved = f_info.jac.mv(y_eval - y) + f_info.residual
        before, after = f_info.as_min(), f_eval_info.as_min()
        predicted = 0.5 * jnp.sum(moved**2) - before
        small = jnp.abs(predicted) <= _UNJUDGEABLE * before
        accept = (after - before <= 0.01 * predicted) | small | first_step
        good = ((after - before < 0.99 * predicted) | small) & ~first_step
        size = state * jnp.where(good, 3.5, jnp.where(accept, 1.0, 0.25))
        return size, accept, optx.RESULTS.successful, size


def _silent(**_: Any) -> None:
    """Report nothing."""


class PreciseLevenbergMarquardt(optx.AbstractGaussNewton[Any, Any, Any]):
    """Levenberg–Marquardt (D. Marquardt 1963) with `PreciseTrustRegion`.

    Attributes:
        rtol: Relative tolerance on coefficients and residuals.
        atol: Absolute tolerance on them.
    """

    rtol: float
    atol: float
    norm: Callable[[Any], Any] = optx.max_norm
    descent: Any = SmallDescent()
    search: Any = PreciseTrustRegion()
    verbose: Callable[..., None] = _silent

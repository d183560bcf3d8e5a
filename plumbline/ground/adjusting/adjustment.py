"""The adjustment: least squares over all observations at once, and its covariance.

Steps by Levenberg and Marquardt on the weighted equations (K. Levenberg 1944, D. Marquardt 1963).
The covariance of the unknowns is C = (JᵀJ)⁻¹, J being whitened by the stated errors; where all
observations together disagree more than these allow, C is multiplied by the variance of unit
weight. A kind k of observations adds C J_kᵀ J_k C to it: that is its share in the budget. What the
lens's source says of coefficients that are not adjusted is added as K Σ Kᵀ, K = −C Jᵀ J_lens.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from statistics import NormalDist

import numpy as np

from plumbline.errors import OptionError
from plumbline.frame import Array
from plumbline.ground.adjusting.block import Block
from plumbline.ground.adjusting.equations import blocks
from plumbline.ground.adjusting.network import Network
from plumbline.ground.adjusting.start import starts
from plumbline.ground.adjusting.state import Layout, State
from plumbline.ground.camera import FOCAL, HEIGHT, TURN
from plumbline.ground.optics import Optics

_MOST_STEPS = 200
"""Chosen: adjustments take five to fifty."""
_FIRST_DAMPING, _LEAST_DAMPING, _MOST_DAMPING = 1e-3, 1e-12, 1e12
"""As Levenberg–Marquardt is usually begun, and given up; chosen."""
_SETTLED = 1e-5
"""Largest step over its standard error at which the adjustment ends: chosen, far below any use."""

_SLACK = 1e-3
"""By how much a step may raise the sum of squared residuals over their standard errors: weights of
lines follow the state, so that the last steps raise it a little. Chosen, far below the 1 of an
error: without it simulated roads with lane edges took 45 steps, with it 7."""

_LONGEST = 0.7
"""Longest step of a turn in radians, and of the logarithms of height and focal length: chosen, a
factor of two."""

_RANK = 1e-9
"""Singular value, of columns of length 1, below which a direction is not determined: chosen, far
above rounding, 1e-15, and far below the weakest direction of any scene in the tests, 1e-5."""

_LEVEL = 0.01
"""Probability at which the observations count as contradicting each other; chosen."""


@dataclass(frozen=True)
class Adjustment:
    """An adjusted network.

    Attributes:
        network: What was observed.
        layout: Order of the unknowns.
        start: The state it started from, with the lens as its source has it.
        state: The most likely state.
        blocks: The observation equations there.
        converged: Whether the steps settled.
    """

    network: Network
    layout: Layout
    start: State
    state: State
    blocks: tuple[Block, ...]
    converged: bool

    @cached_property
    def derivative(self) -> Array:
        """J of all observations, shape (observations, unknowns)."""
        return np.concatenate([block.derivative for block in self.blocks])

    @cached_property
    def residuals(self) -> Array:
        """All residuals over their standard errors."""
        return np.concatenate([block.residuals for block in self.blocks])

    @property
    def cost(self) -> float:
        """Sum of the squared residuals."""
        return float(self.residuals @ self.residuals)

    @cached_property
    def _singular(self) -> tuple[Array, Array, Array]:
        """Column lengths, singular values and right vectors of J with columns of length 1."""
        lengths = np.linalg.norm(self.derivative, axis=0)
        lengths = np.where(lengths > 0, lengths, 1.0)
        _, values, right = np.linalg.svd(self.derivative / lengths, full_matrices=True)
        padded = np.zeros(len(right))
        padded[: len(values)] = values
        return lengths, padded, right

    @cached_property
    def undetermined(self) -> Array:
        """Directions of the unknowns that no observation tells, shape (m, unknowns)."""
        lengths, values, right = self._singular
        return right[values < _RANK * values[0]] / lengths

    @property
    def redundancy(self) -> int:
        """Observations beyond what the unknowns need."""
        return len(self.residuals) - self.layout.size + len(self.undetermined)

    @cached_property
    def cofactor(self) -> Array:
        """C before any widening, shape (unknowns, unknowns)."""
        lengths, values, right = self._singular
        good = values >= _RANK * values[0]
        half = right[good] / values[good, None] / lengths
        return half.T @ half

    @cached_property
    def widening(self) -> float:
        """Factor of all standard errors: 1, or what the contradictions ask for."""
        if not self.contradictory:
            return 1.0
        return float(np.sqrt(self.cost / self.redundancy))

    @property
    def contradictory(self) -> bool:
        """Whether the observations disagree more than their stated errors allow."""
        limit = chi_square_limit(self.redundancy, _LEVEL) if self.redundancy > 0 else math.inf
        return self.cost > limit

    @cached_property
    def lens_gain(self) -> Array:
        """How the unknowns follow the lens's own coefficients, shape (unknowns, k)."""
        optics = self.state.camera.optics
        return -self.cofactor @ (self.derivative.T @ self._by_lens(len(optics.names)))

    def _by_lens(self, count: int) -> Array:
        """Derivative of all residuals by the coefficients, numerically, shape (m, k)."""
        camera = self.state.camera
        values = np.array(camera.optics.lens.coefficients)
        derivatives = np.zeros((len(self.residuals), count))
        for index in range(count):
            ends: list[Array] = []
            for sign in (1.0, -1.0):
                step = values.copy()
                step[index] += sign * _COEFFICIENT_STEP
                state = _with_lens(self.state, step)
                found = blocks(self.network, self.layout, self.start, state)
                ends.append(np.concatenate([block.residuals for block in found]))
            derivatives[:, index] = (ends[0] - ends[1]) / (2 * _COEFFICIENT_STEP)
        return derivatives


_COEFFICIENT_STEP = 1e-5
"""Of derivatives by coefficients: chosen, the cube root of rounding."""


def adjust(network: Network, optics: Optics) -> Adjustment:
    """Adjust a network seen by a lens, from the best of several starts.

    Raises:
        OptionError: no start reaches a camera over the plane.
    """
    layout = Layout.of(network, optics.names)
    best: Adjustment | None = None
    for start in starts(network, optics):
        found = settle(network, layout, start, start)
        if found is None:
            continue
        if best is None or found.cost < best.cost:
            best = found
        if best.converged and not best.contradictory:
            break
    if best is None:
        raise OptionError(
            "no camera over a plane sees these points so",
            hint="check the picks and the order of the points",
        )
    return best


def settle(network: Network, layout: Layout, start: State, state: State) -> Adjustment | None:
    """Step from a state to the minimum near it; None where the start shows nothing."""
    damping, converged = _FIRST_DAMPING, False
    now = blocks(network, layout, start, state)
    residuals, derivative = _joined(now)
    if not np.isfinite(residuals).all():
        return None
    for _ in range(_MOST_STEPS):
        normal, slope = derivative.T @ derivative, derivative.T @ residuals
        lengths = np.sqrt(np.maximum(np.diag(normal), 1e-30))
        scaled = normal / np.outer(lengths, lengths)
        step = -np.linalg.solve(scaled + damping * np.eye(len(scaled)), slope / lengths)
        moved = state.stepped(_limited(step / lengths), layout)
        with np.errstate(all="ignore"):
            trial = blocks(network, layout, start, moved)
        tried, its_derivative = _joined(trial)
        before, after = float(residuals @ residuals), float(tried @ tried)
        if np.isfinite(after) and after <= before + _SLACK:
            state, now, residuals, derivative = moved, trial, tried, its_derivative
            damping = max(damping / 10, _LEAST_DAMPING)
            if np.max(np.abs(step)) < _SETTLED:
                converged = True
                break
        else:  # a tiny step that rounding keeps from helping ends it; a damped one proves nothing
            converged = damping <= _FIRST_DAMPING and bool(np.max(np.abs(step)) < _SETTLED)
            damping *= 10
            if converged or damping > _MOST_DAMPING:
                break
    return Adjustment(network, layout, start, state, tuple(now), converged)


def _limited(step: Array) -> Array:
    """A step that turns and scales the camera by no more than its linear equations bear."""
    scaled = max(abs(step[HEIGHT]), abs(step[FOCAL]), float(np.max(np.abs(step[TURN]))))
    return step * min(1.0, _LONGEST / scaled) if scaled > 0 else step


def chi_square_limit(dof: int, level: float) -> float:
    """The value that chi square exceeds with this probability.

    E. Wilson and M. Hilferty (1931); within 1 % from one degree of freedom on.
    """
    z = NormalDist().inv_cdf(1 - level)
    return dof * (1 - 2 / (9 * dof) + z * math.sqrt(2 / (9 * dof))) ** 3


def _joined(blocks: Sequence[Block]) -> tuple[Array, Array]:
    return (
        np.concatenate([block.residuals for block in blocks]),
        np.concatenate([block.derivative for block in blocks]),
    )


def _with_lens(state: State, values: Array) -> State:
    camera = state.camera
    return replace(state, camera=replace(camera, optics=camera.optics.with_coefficients(values)))

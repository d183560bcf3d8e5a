"""A zoom lens: calibrations at several focal lengths joined by curves.

Calibrations at one focal length, also from several specimens of a camera, are pooled by their
covariances Cᵢ:

    x = C Σ Cᵢ⁻¹ xᵢ,   C = (Σ Cᵢ⁻¹)⁻¹,   χ² = Σ (xᵢ − x)ᵀ Cᵢ⁻¹ (xᵢ − x)

Where they differ by more than their errors tell, C is widened by χ² over its degrees of freedom
(Birge 1932). Coefficients are in units of half the shorter side, the centre `d`, `e` too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plumbline.errors import OptionError
from plumbline.frame import Array
from plumbline.lenses.zoom.curves import (
    Method,
    hermite_weights,
    linear_weights,
    polynomial,
    polynomial_weights,
)
from plumbline.models import CENTRE, Model, get_model
from plumbline.observations.facts import LensFacts

_HELD_ALIKE = 1e-9  # relative; values that were held are copied, rounding apart


@dataclass(frozen=True)
class Node:
    """The lens at one focal length, pooled from one or more calibrations.

    Attributes:
        focal_mm: Focal length.
        values: Coefficients in the order of `ZoomLens.names`.
        covariance: Of the values; zero where they were held.
        scatter: Standard deviation of the values among the calibrations; zero for one.
        centre_spread: Largest distance of two distortion centres, in half shorter sides.
        birge: Factor by which the errors were widened; 1 where the calibrations agree.
        sources: Names of the calibrations.
    """

    focal_mm: float
    values: Array
    covariance: Array
    scatter: Array
    centre_spread: float = 0.0
    birge: float = 1.0
    sources: tuple[str, ...] = ()

    @property
    def errors(self) -> Array:
        """Standard errors of the values."""
        return np.sqrt(np.diag(self.covariance))


@dataclass(frozen=True)
class ZoomLens:
    """A lens over focal length.

    Attributes:
        model: The distortion model.
        free: Names of the coefficients that were fitted.
        nodes: The calibrated focal lengths, ascending.
        method: How coefficients run between them.
        degree: Of the polynomial.
        size: Width and height of the first calibration's picture.
        pixel_aspect: Width of one pixel over its height.
        facts: What is known of the lens.
    """

    model: Model
    free: tuple[str, ...]
    nodes: tuple[Node, ...]
    method: Method
    degree: int
    size: tuple[int, int]
    pixel_aspect: float
    facts: LensFacts

    @property
    def names(self) -> tuple[str, ...]:
        """All coefficients, the centre included."""
        return (*self.model.coefficients, *CENTRE)

    @property
    def focals_mm(self) -> Array:
        """The calibrated focal lengths."""
        return np.array([node.focal_mm for node in self.nodes])

    @property
    def range_mm(self) -> tuple[float, float]:
        """Shortest and longest calibrated focal length."""
        return self.nodes[0].focal_mm, self.nodes[-1].focal_mm

    def at(self, focal_mm: float, method: Method | None = None) -> Array:
        """Coefficients at a focal length, in the order of `names`."""
        weights = self._weights(focal_mm, method or self.method)
        return np.sum(weights * np.stack([node.values for node in self.nodes]), axis=0)

    def covariance_at(self, focal_mm: float) -> Array:
        """Covariance of the coefficients at a focal length, from the calibrations' own."""
        weights = self._weights(focal_mm, self.method)
        parts = [
            weight[:, None] * node.covariance * weight[None, :]
            for weight, node in zip(weights, self.nodes, strict=True)
        ]
        return np.sum(parts, axis=0)

    def polynomials(self) -> dict[str, Array]:
        """For each free coefficient its polynomial in millimetres, the highest power first."""
        errors = self._errors()
        return {
            name: polynomial(
                self.focals_mm,
                np.array([node.values[index] for node in self.nodes]),
                self.degree,
                errors[:, index],
            )
            for index, name in enumerate(self.names)
            if name in self.free
        }

    def _weights(self, focal_mm: float, method: Method) -> Array:
        """Weights of the nodes for each coefficient, shape (nodes, coefficients)."""
        focals = self.focals_mm
        if method == "polynomial":
            errors = self._errors()
            columns = [
                polynomial_weights(focals, focal_mm, self.degree, errors[:, index])
                for index in range(len(self.names))
            ]
            return np.stack(columns, axis=1)
        single = linear_weights if method == "linear" else hermite_weights
        return np.repeat(single(focals, focal_mm)[:, None], len(self.names), axis=1)

    def _errors(self) -> Array:
        """Standard errors for weighting: equal where any of a coefficient's is zero."""
        errors = np.stack([node.errors for node in self.nodes])
        return np.where(np.all(errors > 0, axis=0), errors, 1.0)


def pool(focal_mm: float, values: Sequence[Array], covariances: Sequence[Array]) -> Node:
    """Join calibrations at one focal length.

    Args:
        focal_mm: The focal length.
        values: Coefficients of each calibration, the centre last.
        covariances: Their covariances; zero rows for what was held.

    Raises:
        OptionError: they do not hold the same coefficients at the same values.
    """
    stack = np.stack(values)
    free = np.diag(covariances[0]) > 0
    for covariance in covariances[1:]:
        if np.any((np.diag(covariance) > 0) != free):
            raise OptionError(
                f"the calibrations at {focal_mm:g} mm do not free the same coefficients",
                hint="fit them all with the same --free",
            )
    if np.any(np.ptp(stack[:, ~free], axis=0) > _HELD_ALIKE):
        raise OptionError(
            f"the calibrations at {focal_mm:g} mm hold a coefficient at different values",
            hint="fit them all with the same --hold and --start",
        )
    n = len(stack)
    mean = stack.mean(axis=0)
    covariance = np.zeros_like(covariances[0])
    birge = 1.0
    if np.any(free):
        inner = np.ix_(free, free)
        weights = [np.linalg.pinv(c[inner], rcond=1e-14, hermitian=True) for c in covariances]
        joint = np.linalg.pinv(np.sum(weights, axis=0), rcond=1e-14, hermitian=True)
        found = joint @ sum(w @ x[free] for w, x in zip(weights, stack, strict=True))
        off = stack[:, free] - found
        chi2 = float(sum(x @ w @ x for x, w in zip(off, weights, strict=True)))
        if n > 1:
            birge = max(1.0, (chi2 / ((n - 1) * len(found))) ** 0.5)
        mean[free] = found
        covariance[inner] = joint * birge**2
    centres = stack[:, -2:]
    spread = float(np.max(np.hypot(*np.moveaxis(centres[:, None] - centres[None], -1, 0))))
    scatter = stack.std(axis=0, ddof=1) if n > 1 else np.zeros_like(mean)
    return Node(focal_mm, mean, covariance, scatter, spread, birge)


def model_of(label: str) -> Model:
    """The model of a zoom lens.

    Raises:
        OptionError: it measures in focal lengths, which change over the zoom.
    """
    model = get_model(label)
    if model.unit == "focal length":
        raise OptionError(
            f"the model {label} measures in focal lengths, which change as the lens zooms",
            hint="fit with --model ptlens",
        )
    return model

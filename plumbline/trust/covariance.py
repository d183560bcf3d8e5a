"""Covariance of fitted coefficients, for one fit or many at a time.

The line parameters are eliminated (variable projection; Golub and Pereyra 1973), so that the
covariance is σ̂² (JᵀJ)⁻¹ with J the derivative of the residuals by the coefficients alone and
σ̂² = Σ residual² / (points − 2 · lines − free coefficients).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array
from plumbline.trust.linearised import Linearised


class Unit(NamedTuple):
    """Covariances for picks with σ = 1 px.

    Attributes:
        covariance: Shape (m, k, k); rows and columns of held coefficients are 0.
        unseen: Where some free coefficient moves no residual, shape (m,).
        mixed: Where some combination of them does not, shape (m,).
    """

    covariance: Array
    unseen: NDArray[np.bool_]
    mixed: NDArray[np.bool_]


def unit_covariances(normal: Array, free: NDArray[np.bool_]) -> Unit:
    """(JᵀJ)⁻¹ of the free coefficients of many fits.

    Args:
        normal: JᵀJ, shape (m, k, k).
        free: Which coefficients are free, shape (m, k).
    """
    scale = np.sqrt(np.where(free, np.einsum("mii->mi", normal), 0.0))
    least = 1e-9 * np.maximum(1.0, scale.max(axis=1, keepdims=True))
    known = np.isfinite(normal).all(axis=(1, 2))
    unseen = ~known | np.any(free & ~(scale > least), axis=1)
    usable = free & ~unseen[:, None]
    scale = np.where(usable, scale, 1.0)
    pairs = usable[:, :, None] & usable[:, None, :]
    # A one on the diagonal for what is held keeps the eigenvalues of the others as they are.
    balanced = np.where(pairs, normal / (scale[:, :, None] * scale[:, None]), np.eye(free.shape[1]))
    values, vectors = np.linalg.eigh(balanced)
    mixed = values[:, 0] <= 1e-13
    values = np.where(mixed[:, None], 1.0, values)
    inverse = (vectors / values[:, None]) @ vectors.transpose(0, 2, 1)
    covariance = np.where(pairs, inverse / (scale[:, :, None] * scale[:, None]), 0.0)
    return Unit(covariance, unseen, mixed)


def sandwich(linear: Linearised, dof: int) -> tuple[Array, float]:
    """Covariance and σ̂ where residuals are measured in the corrected photo.

    A pick's error σ in the photograph is s σ there, s the local stretch, so that the covariance is
    σ̂² N⁻¹ (Σ s² J Jᵀ) N⁻¹ with N = JᵀJ (P. Huber 1967, H. White 1980), and σ̂ is taken from the
    residuals in the photograph.

    Returns:
        Covariance, shape (k, k), and σ̂ in pixels of the photograph.
    """
    jacobian, stretch = linear.jacobian[linear.kept], linear.stretch[linear.kept]
    sigma_px = sigma_of(linear, dof)
    every = np.ones((1, jacobian.shape[1]), dtype=np.bool_)
    unit = unit_covariances(linear.normal[None], every).covariance[0]
    meat = (jacobian * stretch[:, None] ** 2).T @ jacobian
    return sigma_px**2 * unit @ meat @ unit, sigma_px


def covariance_of(linear: Linearised, dof: int) -> tuple[Array, float]:
    """Covariance and σ̂ of a fit, whichever kind of residual it minimised.

    Returns:
        Covariance, shape (k, k), and σ̂ in pixels of the photograph.
    """
    if not linear.image:
        return sandwich(linear, dof)
    sigma_px = sigma_of(linear, dof)
    every = np.ones((1, linear.jacobian.shape[1]), dtype=np.bool_)
    return sigma_px**2 * unit_covariances(linear.normal[None], every).covariance[0], sigma_px


def sigma_of(linear: Linearised, dof: int) -> float:
    """σ̂ of a fit from its residuals in the photograph."""
    return float(np.sqrt(np.sum(linear.image_px[linear.kept] ** 2) / dof))

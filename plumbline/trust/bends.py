"""Edges that bend by themselves: noise and a smooth random bend on every line.

Thousands of samples of an edge are not thousands of independent picks: no edge is quite straight,
and neighbours share its bend. The residuals of a line are white noise of σ and a smooth process of
τ with a Matérn covariance of order ν and length ℓ (B. Matérn 1960), taken at the
nodes of the line and interpolated (A. Wilson and H. Nickisch 2015), so that whitening takes time
linear in the samples. Least squares on whitened residuals are generalised least squares.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from plumbline.frame import Array
from plumbline.trust.linearised import Linearised

NODES = 33
"""Places along a line between which its bend is interpolated: chosen, bends over less than a
thirtieth of the line are as good as noise to a lens."""


ORDERS = (0.5, 1.5, 3.5)
"""Orders ν that are known: chosen, rough, smooth and very smooth; with 3/2 alone, errors of lenses
on very smooth bends were 1.7 times those stated."""


@dataclass(frozen=True, eq=False)
class Bends:
    """How edges bend by themselves.

    Attributes:
        length: ℓ, over which bends forget themselves, as a share of the line.
        order: ν: 1/2 for a walk with kinks, 3/2, 7/2 for a curve that is smooth throughout.
        tau_px: τ of each line, one standard deviation of its bend in the photograph, (l,); its
            offset and slope included, which the line takes up.
    """

    length: float
    order: float
    tau_px: Array

    @property
    def typical_px(self) -> float:
        """τ of a usual line: the geometric mean."""
        return float(np.exp(np.mean(np.log(self.tau_px))))


def hats(along: Array) -> Array:
    """What each node of a line weighs at positions along it, linear in between, (n, NODES).

    Args:
        along: Positions in any unit, shape (n,).
    """
    low, high = np.min(along), np.max(along)
    share = (along - low) / (high - low) if high > low else np.zeros_like(along)
    return np.maximum(1 - np.abs(share[:, None] * (NODES - 1) - np.arange(NODES)), 0.0)


@lru_cache(maxsize=64)
def root(length: float, order: float) -> Array:
    """A square root R of the covariance R Rᵀ of a bend of τ = 1 at the nodes, (NODES, NODES).

    Args:
        length: ℓ as a share of the line.
        order: ν, one of 1/2, 3/2 and 7/2.
    """
    place = np.arange(NODES) / (NODES - 1)
    d = np.sqrt(2 * order) / length * np.abs(place[:, None] - place)
    polynomial = {0.5: 1.0, 1.5: 1 + d, 3.5: 1 + d + 2 * d**2 / 5 + d**3 / 15}[order]
    values, vectors = np.linalg.eigh(polynomial * np.exp(-d))
    return vectors * np.sqrt(np.maximum(values, 0.0))


def weighed(linear: Linearised, bends: Bends, sigma_px: float) -> Linearised:
    """The same fit with residuals whitened, so that neighbours no longer share a bend.

    Args:
        linear: The fit; residuals in the photograph.
        bends: How its edges bend.
        sigma_px: The noise, σ̂; 0 where there is none.

    Returns:
        Residuals and derivatives as if all kept picks erred independently by σ̂; positions and
        picks left out are as they were.
    """
    columns = np.column_stack(
        (linear.image_px, linear.jacobian, linear.extra, linear.besides),
    )
    ratios = (bends.tau_px / max(sigma_px, 1e-12)) ** 2
    own = line_columns(linear)
    leverage = linear.line_leverage.copy()
    shape = root(bends.length, bends.order)
    starts = np.searchsorted(linear.line, np.arange(linear.n_lines + 1))
    for line, ratio in enumerate(ratios.tolist()):
        rows = starts[line] + np.flatnonzero(linear.kept[starts[line] : starts[line + 1]])
        if len(rows) < 2:
            continue
        bend = hats(linear.along_px[rows]) @ (np.sqrt(ratio) * shape)
        basis = np.linalg.qr(_whitened(bend, own[rows]))[0]
        values = _whitened(bend, columns[rows])
        columns[rows] = values - basis @ (basis.T @ values)
        leverage[rows] = np.sum(basis**2, axis=1)
    k, m = linear.jacobian.shape[1], linear.extra.shape[1]
    return replace(
        linear,
        residual_px=columns[:, 0],
        image_px=columns[:, 0],
        jacobian=columns[:, 1 : 1 + k],
        extra=columns[:, 1 + k : 1 + k + m],
        besides=columns[:, 1 + k + m :],
        line_leverage=leverage,
    )


def line_columns(linear: Linearised) -> Array:
    """How a line's own offset and slope move residuals in the photograph, shape (n, 2)."""
    return (
        np.column_stack((np.ones_like(linear.along_px), linear.along_px))
        / (linear.stretch[:, None])
    )


def _whitened(basis: Array, values: Array) -> Array:
    """W v with WᵀW = Ω⁻¹ of Ω = I + B Bᵀ, shape (n, k).

    With the Cholesky factor L of A = I + BᵀB, W = I − B (A + L)⁻¹ Bᵀ: Lᵀ is a square root of A, and
    WᵀW = I − B A⁻¹ Bᵀ by multiplying out.

    Args:
        basis: B, shape (n, m).
        values: v, shape (n, k).
    """
    inner = np.eye(basis.shape[1]) + basis.T @ basis
    lower = np.linalg.cholesky(inner)
    return values - basis @ np.linalg.solve(inner + lower, basis.T @ values)

"""How edges bend, estimated from what a fit leaves of them.

Restricted maximum likelihood (D. Patterson and R. Thompson 1971): the likelihood of what neither
the lens nor the lines' own offset and slope can take up. Everything is computed from products of
columns, one set a line, so that only their sums run over the samples.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array
from plumbline.trust.bends import NODES, ORDERS, hats, line_columns, root
from plumbline.trust.linearised import Linearised

_LENGTHS = (0.03, 0.06, 0.1, 0.17, 0.3, 0.5, 0.9, 1.5)
"""Lengths that are tried, as shares of a line: bends traced on photographs have 0.03 to 1."""

_STEP = 0.125
_RATIOS = 10.0 ** np.arange(-2.0, 5.01, _STEP)
"""τ²/σ² that are tried: bends from a tenth of the noise, which nobody sees, to 300 times."""

_COARSE = 6
"""Step of the first look at them."""

_RIDGE = 1e-13
"""Keeps a line through the centre, which does not see the lens, from a root of less than nothing;
columns of the lens have length 1."""

_SCATTER = 1.0
"""Scale of ln τ²/σ² of lines about the common one (of a Laplace distribution, so that one wavy
sheet among true edges is let go): chosen, τ of two lines then differs by 1.6 as a rule."""

_PASSES = 4
"""Times that lines and what is common to them are found in turn: chosen, three hardly change."""

_LINES = 120
"""Lines that what is common is estimated from: chosen, more tell three numbers no better."""


class Estimate(NamedTuple):
    """What the residuals of a fit say.

    Attributes:
        length: ℓ as a share of the line.
        order: ν.
        ratios: τ²/σ² of each line, shape (l,).
        gain: Twice the logarithm by which bends are likelier than none; what is common to lines
            only.
    """

    length: float
    order: float
    ratios: Array
    gain: float


def estimated(linear: Linearised, shape: tuple[float, float] | None = None) -> Estimate:
    """Estimate σ, τ and ℓ of a fit's residuals in the photograph.

    Args:
        linear: The fit.
        shape: ℓ and ν, where they are known already.
    """
    sums = _Sums.of(linear)
    shapes = list(product(_LENGTHS, ORDERS)) if shape is None else [shape]
    found = _swept(sums, np.ones(len(sums.number)), shapes)
    gain = found.gain
    if shape is None:  # again: one wavy line does not choose the shape for all
        common = float(np.exp(np.mean(np.log(found.ratios))))
        found = _swept(sums, found.ratios / common, shapes)
    every = np.full(linear.n_lines, float(np.exp(np.mean(np.log(found.ratios)))))
    every[sums.number] = found.ratios
    return found._replace(ratios=every, gain=gain)


def _swept(sums: _Sums, uneven: Array, shapes: Sequence[tuple[float, float]]) -> Estimate:
    """The likeliest shape, then lines and what is common to them in turn.

    Args:
        sums: The lines.
        uneven: τ² of each over what is common, to begin with, shape (l,).
        shapes: ℓ and ν that are tried.
    """
    which = np.unique(np.linspace(0, len(sums.number) - 1, _LINES).astype(np.int64))
    gain, common, length, order = _likeliest(sums.only(which), uneven[which], shapes)
    lines = _Lines.of(sums.over(length, order))
    ratios = common * uneven
    for _ in range(_PASSES):
        ratios = lines.ratios(common, lines.variance(ratios))
        common = float(np.exp(np.mean(np.log(ratios))))
    return Estimate(length, order, ratios, gain)


def _likeliest(
    sums: _Sums, uneven: Array, shapes: Sequence[tuple[float, float]]
) -> tuple[float, float, float, float]:
    """What bends gain over none, common τ²/σ², ℓ and ν that are likeliest.

    Args:
        sums: Lines.
        uneven: τ² of each over what is common, shape (l,).
        shapes: ℓ and ν that are tried.
    """
    coarse = _RATIOS[::_COARSE].tolist()
    rough = [(sums.over(*each).likelihood(q * uneven), q, *each) for each in shapes for q in coarse]
    _, near, length, order = max(rough)
    spread = sums.over(length, order)
    fine = _RATIOS[np.abs(np.log10(_RATIOS / near)) < _COARSE * _STEP].tolist()
    best, common = max((spread.likelihood(q * uneven), q) for q in fine)
    return 2 * (best - spread.likelihood(0 * uneven)), common, length, order


@dataclass(frozen=True, eq=False)
class _Sums:
    """Products of columns of each line: nodes B, and C of offset, slope, lens and residual.

    Attributes:
        number: The lines.
        size: Samples of each, shape (l,).
        nodes: BᵀB, shape (l, NODES, NODES).
        mixed: BᵀC, shape (l, NODES, c).
        columns: CᵀC, shape (l, c, c).
    """

    number: NDArray[np.int64]
    size: NDArray[np.int64]
    nodes: Array
    mixed: Array
    columns: Array

    @staticmethod
    def of(linear: Linearised) -> _Sums:
        jacobian = linear.jacobian / np.maximum(
            np.linalg.norm(linear.jacobian[linear.kept], axis=0), 1e-300
        )
        own = line_columns(linear) / np.array([1.0, max(float(np.ptp(linear.along_px)), 1e-300)])
        every = np.column_stack((own, jacobian, np.where(linear.kept, linear.image_px, 0.0)))
        starts = np.searchsorted(linear.line, np.arange(linear.n_lines + 1))
        number, size, nodes, mixed, columns = [], [], [], [], []
        for line in range(linear.n_lines):
            rows = starts[line] + np.flatnonzero(linear.kept[starts[line] : starts[line + 1]])
            if len(rows) < 3:
                continue
            b, c = hats(linear.along_px[rows]), every[rows]
            number.append(line)
            size.append(len(rows))
            nodes.append(b.T @ b)
            mixed.append(b.T @ c)
            columns.append(c.T @ c)
        return _Sums(
            np.array(number), np.array(size), np.array(nodes), np.array(mixed), np.array(columns)
        )

    def only(self, which: NDArray[np.int64]) -> _Sums:
        """Some of the lines."""
        return _Sums(
            self.number[which],
            self.size[which],
            self.nodes[which],
            self.mixed[which],
            self.columns[which],
        )

    def over(self, length: float, order: float) -> _Spread:
        """The same for bends of one shape."""
        shape = root(length, order)
        m, c = NODES, self.columns.shape[1]
        every = np.empty((len(self.size), m + c, m + c))
        every[:, :m, :m] = shape.T @ self.nodes @ shape
        every[:, :m, m:] = shape.T @ self.mixed
        every[:, m:, :m] = every[:, :m, m:].transpose(0, 2, 1)
        every[:, m:, m:] = self.columns
        return _Spread(every, self.size)


@dataclass(frozen=True, eq=False)
class _Spread:
    """Lines whose bends have one shape.

    With Ω = I + q A Aᵀ of a line and q = τ²/σ², the Cholesky factor of the products of √q A and C,
    an identity added to those of the first, has ln|Ω| on the diagonal of its first block and the
    factor of CᵀΩ⁻¹C for its last.

    Attributes:
        products: [A C]ᵀ[A C] of each line, shape (l, NODES + c, NODES + c).
        size: Samples of each, shape (l,).
    """

    products: Array
    size: NDArray[np.int64]

    @property
    def columns(self) -> int:
        """Columns of C: offset, slope, lens and residual."""
        return int(self.products.shape[1]) - NODES

    @property
    def free(self) -> int:
        """Contrasts that neither lines nor lens take up."""
        return int(self.size.sum()) - 2 * len(self.size) - (self.columns - 3)

    def likelihood(self, ratios: Array) -> float:
        """The logarithm of the restricted likelihood at its best σ, constants left out."""
        left, spread = self.left(ratios)
        square, of_lens = _last_alone(left.sum(axis=0))
        return -0.5 * (self.free * np.log(square / self.free) + float(np.sum(spread)) + of_lens)

    def left(self, ratios: Array) -> tuple[Array, Array]:
        """CᵀΩ⁻¹C of lens and residual without the lines' own columns, and ln|Ω| + ln|those'|."""
        scale = np.ones((len(self.size), NODES + self.columns))
        scale[:, :NODES] = np.sqrt(ratios)[:, None]
        whole = self.products * (scale[:, :, None] * scale[:, None, :])
        ridge = np.full(NODES + self.columns, _RIDGE)
        ridge[:NODES] = 1.0
        factor = np.linalg.cholesky(whole + np.diag(ridge))
        diagonal = np.diagonal(factor, axis1=1, axis2=2)[:, : NODES + 2]
        last = factor[:, NODES + 2 :, NODES + 2 :]
        return last @ last.transpose(0, 2, 1), 2 * np.sum(np.log(diagonal), axis=1)


class _Lines(NamedTuple):
    """What every line says of every ratio that is tried.

    Attributes:
        left: As `_Spread.left`, shape (ratios, l, k + 1, k + 1).
        spread: The same, shape (ratios, l).
        free: As `_Spread.free`.
    """

    left: Array
    spread: Array
    free: int

    @staticmethod
    def of(spread: _Spread) -> _Lines:
        one = np.ones(len(spread.size))
        tried = [spread.left(q * one) for q in _RATIOS.tolist()]
        left, spreads = (np.array([each[part] for each in tried]) for part in (0, 1))
        return _Lines(left, spreads, spread.free)

    def variance(self, ratios: Array) -> float:
        """σ² that is likeliest."""
        place = np.argmin(np.abs(np.log(_RATIOS[:, None] / ratios)), axis=0)
        chosen = self.left[place, np.arange(len(ratios))]
        return _last_alone(chosen.sum(axis=0))[0] / self.free

    def ratios(self, common: float, variance: float) -> Array:
        """τ²/σ² of each line at a lens and σ² known, shrunk towards what is common."""
        likely = -0.5 * (self.spread + self.left[..., -1, -1] / variance)
        likely -= np.abs(np.log(_RATIOS / common))[:, None] / _SCATTER
        return _RATIOS[np.argmax(likely, axis=0)]


def _last_alone(normal: Array) -> tuple[float, float]:
    """The last column's square without the others, and ln|the others|."""
    k = len(normal) - 1
    factor = np.linalg.cholesky(normal + _RIDGE * np.eye(k + 1))
    return float(factor[-1, -1]) ** 2, 2 * float(np.sum(np.log(np.diag(factor)[:k])))

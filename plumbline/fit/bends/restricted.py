"""How edges bend, estimated from what a fit leaves of them.

Restricted maximum likelihood (D. Patterson and R. Thompson 1971): the likelihood of what neither
the lens nor the lines' own offset and slope can take up. Everything is computed from products of
columns, one set a line, so that only their sums run over the samples.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array
from plumbline.trust.bends import ORDERS, hats, line_columns, root
from plumbline.trust.linearised import Linearised

_LENGTHS = (0.03, 0.06, 0.1, 0.17, 0.3, 0.5, 0.9, 1.5)
"""Lengths that are tried, as shares of a line: bends traced on photographs have 0.03 to 1."""

_RATIOS = 10.0 ** np.arange(-2.0, 5.01, 0.125)
"""τ²/σ² that are tried: bends from a tenth of the noise, which nobody sees, to 300 times."""

_COARSE = 6
"""Step of the first look at them."""

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
    some = sums.only(np.unique(np.linspace(0, len(sums.number) - 1, _LINES).astype(np.int64)))
    shapes = product(_LENGTHS, ORDERS) if shape is None else [shape]
    best, common, length, order = max((*some.over(*each).likeliest(), *each) for each in shapes)
    none = some.over(length, order).likelihood(0.0)
    spread = sums.over(length, order)
    ratios = np.full(len(sums.number), common)
    for _ in range(_PASSES):
        ratios = spread.of_lines(common, spread.variance(ratios))
        common = float(np.exp(np.mean(np.log(ratios))))
    every = np.full(linear.n_lines, common)
    every[sums.number] = ratios
    return Estimate(length, order, every, 2 * (best - none))


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
        values, vectors = np.linalg.eigh(shape.T @ self.nodes @ shape)
        turned = vectors.transpose(0, 2, 1) @ (shape.T @ self.mixed)
        return _Spread(np.maximum(values, 0.0), turned, self.columns, self.size)


@dataclass(frozen=True, eq=False)
class _Spread:
    """Lines whose bends have one shape, in the axes in which their bends are independent.

    With Ω = I + q B R Rᵀ Bᵀ of a line and q = τ²/σ²: ln|Ω| = Σ ln(1 + q e), and
    CᵀΩ⁻¹C = CᵀC − Zᵀ (q / (1 + q e)) Z.
    """

    e: Array
    z: Array
    columns: Array
    size: NDArray[np.int64]

    def likeliest(self) -> tuple[float, float]:
        """The largest restricted likelihood, and τ²/σ², common to all lines, that has it."""
        places = range(0, len(_RATIOS), _COARSE)
        known = {place: self.likelihood(float(_RATIOS[place])) for place in places}
        middle = max(known, key=lambda place: known[place])
        for place in range(max(middle - _COARSE, 0), min(middle + _COARSE + 1, len(_RATIOS))):
            if place not in known:
                known[place] = self.likelihood(float(_RATIOS[place]))
        best = max(known, key=lambda place: known[place])
        return known[best], float(_RATIOS[best])

    def likelihood(self, ratio: float) -> float:
        """The logarithm of the restricted likelihood at its best σ, constants left out."""
        left, own = self._left(np.full(len(self.size), ratio))
        whole = left.sum(axis=0)
        square, of_lens = _last_alone(whole)
        free = self._free(whole)
        spread = float(np.sum(np.log1p(ratio * self.e)))
        return -0.5 * (free * np.log(square / free) + spread + float(np.sum(own)) + of_lens)

    def variance(self, ratios: Array) -> float:
        """σ² that is likeliest."""
        whole = self._left(ratios)[0].sum(axis=0)
        return _last_alone(whole)[0] / self._free(whole)

    def _free(self, whole: Array) -> int:
        return int(self.size.sum()) - 2 * len(self.size) - (len(whole) - 1)

    def of_lines(self, common: float, variance: float) -> Array:
        """τ²/σ² of each line at a lens and σ² known, shrunk towards what is common."""
        found = np.empty((len(_RATIOS), len(self.size)))
        for place, ratio in enumerate(_RATIOS.tolist()):
            left, own = self._left(np.full(len(self.size), ratio))
            spread = np.sum(np.log1p(ratio * self.e), axis=1)
            found[place] = -0.5 * (spread + own + left[:, -1, -1] / variance)
            found[place] -= abs(np.log(ratio / common)) / _SCATTER
        return _RATIOS[np.argmax(found, axis=0)]

    def _left(self, ratios: Array) -> tuple[Array, Array]:
        """CᵀΩ⁻¹C of lens and residual without the lines' own columns, and ln|those'|, per line."""
        q = ratios[:, None]
        weighted = (q / (1 + q * self.e))[..., None] * self.z
        m = self.columns - self.z.transpose(0, 2, 1) @ weighted
        own, cross = m[:, :2, :2], m[:, :2, 2:]
        left = m[:, 2:, 2:] - cross.transpose(0, 2, 1) @ np.linalg.solve(own, cross)
        return left, np.linalg.slogdet(own)[1]


def _last_alone(normal: Array) -> tuple[float, float]:
    """The last column's square without the others, and ln|the others|."""
    rest, cross = normal[:-1, :-1], normal[:-1, -1]
    return float(normal[-1, -1] - cross @ np.linalg.solve(rest, cross)), float(
        np.linalg.slogdet(rest)[1]
    )

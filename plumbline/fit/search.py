"""Where a robust fit begins: which picks may be believed, before any lens is known.

Lenses of the division model with two coefficients are tried over the whole range in which they
neither fold nor have a pole; for each the least-median lines are drawn, and what counts is how far
picks lie from them, wrong ones hardly more than others (Σ log distance). The best of the grid are
refined by steps that are halved.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from plumbline.fit.problem import Problem, pixels_of_centre
from plumbline.fit.screening import Picks, closest, distances, least_median_lines, picks_at
from plumbline.fit.task import Solution
from plumbline.ideal import Ideal, stretch
from plumbline.models import CENTRE, get_model
from plumbline.straightness import line_numbers

_STARTS = 3
_STEPS, _FINEST_STEP = (0.03, 0.0375), 5e-4
_MOST_LINES = 64
_LEAST_PX, _FAR_PX = 0.3, 1e6


def _bends() -> tuple[tuple[float, float], ...]:
    """l1 and l2 of the division model, at a reach of 1, that neither fold nor have a pole."""
    s = np.linspace(0.0, 1.0, 33)
    return tuple(
        (one, two)
        for one in np.linspace(-0.96, 0.96, 33).tolist()
        for two in np.linspace(-0.3, 0.3, 9).tolist()
        if np.all(1 + one * s + two * s**2 > 0.03) and np.all(1 - one * s - 3 * two * s**2 > 0.03)
    )


_BENDS = _bends()


def beliefs(problem: Problem, plain: Solution) -> list[NDArray[np.bool_]]:
    """Which picks lie on straight lines under the best of many lenses, and under the plain one."""
    telling, every = _telling_lines(problem), np.arange(len(problem.packed.sizes))
    costs = [_cost(_bent(problem, bend, telling)) for bend in _BENDS]
    rough = [_BENDS[number] for number in np.argsort(costs)[: 2 * _STARTS].tolist()]
    fine = sorted(_refined(problem, bend, telling) for bend in rough)
    lenses = [_bent(problem, bend, every) for _, bend in fine[:_STARTS]]
    if not int(plain.folded):
        lenses.append(picks_at([problem], [plain]))
    return [closest(lens) for lens in lenses]


def _refined(
    problem: Problem, bend: tuple[float, float], lines: NDArray[np.int64]
) -> tuple[float, tuple[float, float]]:
    """The lowest cost beside a lens of the grid, and the lens, by steps that are halved."""
    steps, best = _STEPS, (_cost(_bent(problem, bend, lines)), bend)
    while steps[0] > _FINEST_STEP:
        around = [
            (best[1][0] + i * steps[0], best[1][1] + j * steps[1])
            for i in (-1, 0, 1)
            for j in (-1, 0, 1)
            if i or j
        ]
        lowest = min((_cost(_bent(problem, each, lines)), each) for each in around)
        if lowest[0] < best[0]:
            best = lowest
        else:
            steps = steps[0] / 2, steps[1] / 2
    return best


def _bent(problem: Problem, bend: tuple[float, float], lines: NDArray[np.int64]) -> Picks:
    """The picks of some lines under a lens of the division model."""
    packed, unit_px = problem.packed, problem.blank.unit_px
    held = np.array([problem.plan.start[name] for name in CENTRE])
    observed = packed.unpack(packed.block.xy) - held / pixels_of_centre(problem.blank)[-2:]
    far2 = float(np.max(np.sum(observed**2, axis=1)))
    c = bend[0] / far2, bend[1] / far2**2
    observed = observed[np.isin(line_numbers(packed.sizes), lines)]
    sizes = packed.sizes[lines]
    r2 = np.sum(observed**2, axis=1)
    ideal = observed / (1 + c[0] * r2 + c[1] * r2**2)[:, None]
    slopes = stretch(get_model("division"), c, observed, ideal)
    one = np.zeros(len(observed), dtype=np.int64)
    return Picks(Ideal(ideal * unit_px, slopes), sizes, line_numbers(sizes), one, np.array([1]))


def _telling_lines(problem: Problem) -> NDArray[np.int64]:
    """The lines that a lens bends most; all, unless they are many."""
    sizes = problem.packed.sizes
    if len(sizes) <= _MOST_LINES:
        return np.arange(len(sizes))
    points = problem.packed.unpack(problem.packed.block.xy)
    first, last = points[np.cumsum(sizes) - sizes], points[np.cumsum(sizes) - 1]
    length = np.hypot(*(last - first).T)
    area = np.abs(first[:, 0] * last[:, 1] - first[:, 1] * last[:, 0])
    return np.sort(np.argsort(-area * length)[:_MOST_LINES])


def _cost(picks: Picks) -> float:
    """How far picks lie from their least-median lines, wrong ones hardly more than others."""
    lines, _ = least_median_lines(picks.ideal, picks.sizes)
    away_px = np.minimum(np.abs(distances(picks, lines)), _FAR_PX)
    return float(np.sum(np.log(away_px + _LEAST_PX)))

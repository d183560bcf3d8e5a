"""Where a robust fit begins: which picks may be believed, before any lens is known.

Lenses of the division model with two coefficients are tried over the whole range in which they
neither fold nor have a pole; for each the least-median lines are drawn, and what counts is how far
picks lie from them, wrong ones hardly more than others (Σ log distance). The best of the grid are
refined by steps that are halved.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from plumbline.fit.problem import Problem
from plumbline.fit.screening import Picks, closest, distances, least_median_lines, picks_at
from plumbline.fit.task import Solution
from plumbline.frame import Array
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


class _Seen(NamedTuple):
    """Observed picks of some lines from the distortion centre, normalised.

    Attributes:
        observed: The picks, line after line, shape (n, 2).
        sizes: Number of picks of each line.
        far2: Square of the largest radius of all lines.
        unit_px: Square pixels to a normalised radius of 1.
    """

    observed: Array
    sizes: NDArray[np.int64]
    far2: float
    unit_px: float


def beliefs(problem: Problem, plain: Solution) -> list[NDArray[np.bool_]]:
    """Which picks lie on straight lines under the best of many lenses, and under the plain one."""
    every = _seen(problem)
    telling = _telling(every)
    costs = [_cost(_bent(telling, bend)) for bend in _BENDS]
    rough = [_BENDS[number] for number in np.argsort(costs)[: 2 * _STARTS].tolist()]
    fine = sorted(_refined(telling, bend) for bend in rough)
    lenses = [_bent(every, bend) for _, bend in fine[:_STARTS]]
    if not int(plain.folded):
        lenses.append(picks_at([problem], [plain]))
    return [closest(lens) for lens in lenses]


def _seen(problem: Problem) -> _Seen:
    packed = problem.packed
    held = np.array([problem.plan.start[name] for name in CENTRE])
    observed = packed.unpack(packed.block.xy) - held / problem.to_px[-2:]
    far2 = float(np.max(np.sum(observed**2, axis=1)))
    return _Seen(observed, packed.sizes, far2, problem.blank.unit_px)


def _telling(seen: _Seen) -> _Seen:
    """The lines that a lens bends most; all, unless they are many."""
    sizes = seen.sizes
    if len(sizes) <= _MOST_LINES:
        return seen
    first, last = seen.observed[np.cumsum(sizes) - sizes], seen.observed[np.cumsum(sizes) - 1]
    length = np.hypot(*(last - first).T)
    area = np.abs(first[:, 0] * last[:, 1] - first[:, 1] * last[:, 0])
    chosen = np.zeros(len(sizes), dtype=np.bool_)
    chosen[np.argsort(-area * length)[:_MOST_LINES]] = True
    return seen._replace(observed=seen.observed[np.repeat(chosen, sizes)], sizes=sizes[chosen])


def _refined(seen: _Seen, bend: tuple[float, float]) -> tuple[float, tuple[float, float]]:
    """The lowest cost beside a lens of the grid, and the lens, by steps that are halved."""
    steps, best = _STEPS, (_cost(_bent(seen, bend)), bend)
    while steps[0] > _FINEST_STEP:
        around = [
            (best[1][0] + i * steps[0], best[1][1] + j * steps[1])
            for i in (-1, 0, 1)
            for j in (-1, 0, 1)
            if i or j
        ]
        lowest = min((_cost(_bent(seen, each)), each) for each in around)
        if lowest[0] < best[0]:
            best = lowest
        else:
            steps = steps[0] / 2, steps[1] / 2
    return best


def _bent(seen: _Seen, bend: tuple[float, float]) -> Picks:
    """The picks under a lens of the division model."""
    c = bend[0] / seen.far2, bend[1] / seen.far2**2
    r2 = np.sum(seen.observed**2, axis=1)
    ideal = seen.observed / (1 + c[0] * r2 + c[1] * r2**2)[:, None]
    slopes = stretch(get_model("division"), c, seen.observed, ideal)
    one, line = np.zeros(len(r2), dtype=np.int64), line_numbers(seen.sizes)
    return Picks(Ideal(ideal * seen.unit_px, slopes), seen.sizes, line, one, np.array([1]))


def _cost(picks: Picks) -> float:
    """How far picks lie from their least-median lines, wrong ones hardly more than others."""
    lines, _ = least_median_lines(picks.ideal, picks.sizes)
    away_px = np.minimum(np.abs(distances(picks, lines)), _FAR_PX)
    return float(np.sum(np.log(away_px + _LEAST_PX)))

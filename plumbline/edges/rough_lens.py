"""A lens good enough to predict where edges run, in milliseconds and without compiling anything.

Lines of points are made straight by one coefficient of the division model, then by a radial
polynomial that starts from its curve. Bad lines count less: a line is weighed by how straight
it is among the others. The result is a guide for the eye, not a calibration.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array, Frame
from plumbline.geometry.lens import Lens
from plumbline.geometry.lines import fit_lines, line_numbers
from plumbline.models import get_model

Whole = NDArray[np.int64]

STRONGEST = 0.45
"""Largest l1 of the division model that is tried: a fisheye's, 20 % at the corner and more."""

_TRIED = 61
_POWERS = (1, 2, 3, 4)
_PRIOR = 0.3
"""Standard deviation that is expected of a coefficient: keeps lines near the centre, which say
nothing of the corner, from inventing a lens."""

_CENTRE = 0.03
"""Standard deviation of the distortion centre over R: specimens scatter by 1.5 %."""

_STEPS = 12
"""Gauss–Newton steps; from the division model's curve five reach the end (chosen, twice that)."""

_USUAL = 3.0
"""Times the median rms of lines from which a line counts less."""


@dataclass(frozen=True)
class RoughLens:
    """A lens found from lines of points, and how straight it makes them.

    Attributes:
        lens: The lens.
        line_rms_px: Root mean square residual of each line, pixels of the photo.
        scatter_px: Standard deviation of a point across its line, robust.
    """

    lens: Lens
    line_rms_px: tuple[float, ...]
    scatter_px: float


def one_coefficient(lines: Sequence[Array], frame: Frame) -> RoughLens:
    """The division model's l1 that makes lines of points straight.

    Args:
        lines: Points in pixels, shape (n, 2) each, n ≥ 3.
        frame: The photo's.
    """
    problem = _Problem.of(lines, frame)

    def cost(l1: float) -> float:
        return _robust_cost(problem.residuals(lambda r: 1 / (1 + l1 * r**2)), problem, l1)

    corner = frame.corner_radius
    # Beyond half of 1 / corner², the photo's corner comes near the model's pole or fold.
    low, high = max(-STRONGEST, -0.5 / corner**2), min(STRONGEST, 0.5 / corner**2)
    tried = np.linspace(low, high, _TRIED)
    best = int(np.argmin([cost(float(value)) for value in tried]))
    step = float(tried[1] - tried[0])
    l1 = float(tried[best])
    while step > 1e-6:
        step /= 2
        l1 = min((l1 - step, l1, l1 + step), key=cost)
    return _rated(
        division_lens(l1, frame), problem.residuals(lambda r: 1 / (1 + l1 * r**2)), problem, 1
    )


def division_lens(l1: float, frame: Frame) -> Lens:
    """The division model with one coefficient."""
    return Lens(get_model("division"), frame, {"l1": l1, "l2": 0.0, "d": 0.0, "e": 0.0})


def polynomial(
    lines: Sequence[Array], start: RoughLens, *, weights: Array | None = None, centre: bool = False
) -> RoughLens:
    """The radial polynomial that makes lines of points straight, from a first lens.

    The first lens is returned where the polynomial folds inside the photo.

    Args:
        lines: Points in pixels, shape (n, 2) each, n ≥ 3.
        start: The division model's lens of the same photo.
        weights: How much each line counts; by how straight it is among the others by default.
        centre: Find the distortion centre too.
    """
    frame = start.lens.frame
    problem = _Problem.of(lines, frame)
    l1 = start.lens.coefficients["l1"]
    radius = np.linspace(0.02, frame.corner_radius, 50)
    powers = np.stack([radius**power for power in _POWERS], axis=-1)
    solved = np.linalg.lstsq(powers, 1 / (1 + l1 * radius**2) - 1, rcond=None)[0]
    first: Array = np.concatenate((solved, np.zeros(2))).astype(np.float64)
    free = list(range(len(first) if centre else len(_POWERS)))
    tight = np.array([1 / _PRIOR**2] * len(_POWERS) + [1 / _CENTRE**2] * 2)[free]
    c = first.copy()
    for _ in range(_STEPS):
        values = problem.bent(c)
        heavy = np.sqrt((_weights(values, problem) if weights is None else weights)[problem.line])
        unit = max(_scatter(values, problem), 1e-3)
        slope = np.stack([_change(problem, c, k, values) for k in free], axis=-1)
        slope *= heavy[:, None] / unit
        normal = slope.T @ slope + np.diag(tight)
        gradient = slope.T @ (values * heavy / unit) + (c - first)[free] * tight
        c[free] -= np.linalg.solve(normal, gradient)
    lens = _polynomial_lens(c, frame)
    if lens.fold_radius_px() is not None:
        return start
    return _rated(lens, problem.bent(c), problem, len(free))


def _polynomial_lens(c: Array, frame: Frame) -> Lens:
    names = [f"a{power}" for power in _POWERS]
    d, e = (float(value) for value in c[len(names) :] / frame.per_px())
    model = get_model("radial:" + ",".join(map(str, _POWERS)))
    vector = dict(zip(names, map(float, c), strict=False)) | {"d": d, "e": e}
    return Lens(model, frame, vector)


@dataclass(frozen=True, eq=False)
class _Problem:
    """Points line after line, normalised; which line each is of, and pixels a unit."""

    points: Array
    sizes: Whole
    line: Whole
    unit_px: float

    @staticmethod
    def of(lines: Sequence[Array], frame: Frame) -> _Problem:
        sizes = np.array([len(points) for points in lines], dtype=np.int64)
        points = frame.normalise(np.concatenate(list(lines)))
        return _Problem(points, sizes, line_numbers(sizes), frame.radius_px)

    def bent(self, c: Array) -> Array:
        """Residuals of the polynomial with coefficients, then the centre."""
        return self.residuals(_factor(c), c[len(_POWERS) :])

    def residuals(self, factor: Callable[[Array], Array], centre: Array | None = None) -> Array:
        """Distances from straight lines in the photo's pixels: taken back by the local scale."""
        points = self.points if centre is None else self.points - centre
        scale = factor(np.hypot(points[:, 0], points[:, 1]))
        ideal = points * scale[:, None]
        fitted = fit_lines(ideal, self.sizes, np.ones(len(ideal)))
        return fitted.place(ideal, self.line)[1] / scale * self.unit_px


def _factor(c: Array) -> Callable[[Array], Array]:
    def factor(r: Array) -> Array:
        total = np.ones_like(r)
        for value, power in zip(c, _POWERS, strict=False):  # the centre comes after them
            total += value * r**power
        return total

    return factor


def _change(problem: _Problem, c: Array, which: int, values: Array) -> Array:
    """Derivative of the residuals by one coefficient, by a difference."""
    moved = c.copy()
    moved[which] += 1e-6
    return (problem.bent(moved) - values) / 1e-6


def _line_rms(values: Array, problem: _Problem) -> Array:
    total = np.bincount(problem.line, values**2, len(problem.sizes))
    return np.sqrt(total / np.maximum(problem.sizes - 2, 1))


def _scatter(values: Array, problem: _Problem) -> float:
    return float(np.median(_line_rms(values, problem)))


def _weights(values: Array, problem: _Problem) -> Array:
    each = _line_rms(values, problem)
    usual = max(_USUAL * float(np.median(each)), 1e-6)
    return 1 / (1 + (each / usual) ** 4)


def _robust_cost(values: Array, problem: _Problem, l1: float) -> float:
    """Lines count by the logarithm of their variance: a few wrong ones do not decide."""
    each = _line_rms(values, problem)
    floor = 0.1  # px: nobody picks better
    return float(np.sum(problem.sizes * np.log(each**2 + floor**2))) + (l1 / _PRIOR) ** 2


def _rated(lens: Lens, values: Array, problem: _Problem, free: int) -> RoughLens:
    each = _line_rms(values, problem)
    points = len(values) - 2 * len(each)
    share = np.sqrt(points / max(points - free, 1)) if points > free else 2.0
    return RoughLens(lens, tuple(map(float, each)), float(np.median(each) * share))

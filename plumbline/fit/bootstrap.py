"""Bootstrap: fit again to residuals resampled within their lines.

Every kept pick is put back onto its fitted line, then moved across it, in the photograph, by a
residual drawn from those of the same line (B. Efron, "Bootstrap methods: another look at the
jackknife", 1979). Residuals are first brought to the size of the errors they come from: divided
by √(1 − leverage), and by √(1 − 1/m) for the mean taken out of m of them.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from plumbline.errors import DegenerateLinesError, OptionError, refuse_other_type
from plumbline.fit.outcome import is_settled
from plumbline.fit.problem import Problem, prepare
from plumbline.fit.program.solve import BATCH, solve_many
from plumbline.fit.program.task import FitTask, Solution
from plumbline.frame import Array
from plumbline.geometry.derivatives import undistorted
from plumbline.geometry.lines import fit_lines
from plumbline.result.calibration import Calibration
from plumbline.trust.bootstrap import Bootstrap
from plumbline.trust.linearised import in_frame

_LEAST, _MOST = 50, 100_000
"""Chosen, because fewer fits give no 95 % interval, and more take hours."""


def bootstrap(
    calibration: Calibration, fits: int, done: Callable[[int], object] | None = None, seed: int = 0
) -> Calibration:
    """The same calibration with a bootstrap beside its standard errors.

    Args:
        calibration: A calibration.
        fits: How many fits, from 50 to 100,000.
        done: Called with the number of fits just done, for progress.
        seed: Of the resampling; the same seed gives the same result.

    Raises:
        OptionError: the number of fits makes no sense.
        DegenerateLinesError: hardly any of the fits reached a minimum.
    """
    refuse_other_type(calibration, Calibration, "a Calibration", "fit one with plumbline.calibrate")
    refuse_other_type(fits, int, "a whole number of fits", "1000 are usual")
    if not _LEAST <= fits <= _MOST:
        raise OptionError(
            f"a bootstrap of {fits:,} fits is out of range",
            hint=f"take from {_LEAST} to {_MOST:,}; 1,000 are usual",
        )
    problem = prepare(
        calibration.observations,
        calibration.lens.model,
        calibration.free,
        (),
        calibration.coefficients,
        calibration.residual,
    ).keeping(np.concatenate(calibration.kept))
    sizes = [min(BATCH, fits - first) for first in range(0, fits, BATCH)]
    draw = _resampling(calibration, problem)

    def solved(number: int) -> list[Solution]:
        rng = np.random.default_rng((seed, number))
        return solve_many(problem.model, [draw(rng) for _ in range(sizes[number])])

    found: list[Array] = []
    chosen = problem.task.free
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for solutions in pool.map(solved, range(len(sizes))):
            found += [
                (solution.coefficients * problem.to_px)[chosen]
                for solution in solutions
                if is_settled(solution, problem.dof)
            ]
            if done is not None:
                done(len(solutions))
    if 2 * len(found) < fits:
        raise DegenerateLinesError(
            f"only {len(found):,} of {fits:,} bootstrap fits reached a minimum",
            hint="the lines hardly determine the free coefficients; pick more lines",
        )
    values = np.stack(found)
    away = values - values.mean(axis=0)
    result = Bootstrap(
        len(found),
        fits - len(found),
        away.T @ away / (len(found) - 1),
        np.percentile(values, (2.5, 97.5), axis=0).T,
    )
    return replace(calibration, bootstrap=result)


def _resampling(
    calibration: Calibration, problem: Problem
) -> Callable[[np.random.Generator], FitTask]:
    """What draws tasks with residuals resampled within lines."""
    lens, linear = calibration.lens, calibration.linearised
    observed_px = np.concatenate(in_frame(calibration.observations, lens.frame))
    ideal = undistorted(lens, observed_px)
    lines = fit_lines(ideal.uv, problem.packed.sizes, linear.kept.astype(np.float64))
    across = np.einsum("nij,ni->nj", ideal.stretch, lines.across[linear.line])
    # One pixel of the photograph across the line, where picks err; then in normalised units.
    across = across * np.array((ideal.aspect, 1.0))
    across = across / np.hypot(*across.T)[:, None] * lens.frame.per_px(problem.blank.unit_px)
    block, cells = problem.packed.block, problem.packed.cells
    rows = np.flatnonzero(linear.kept)
    fitted = problem.packed.unpack(block.xy)
    fitted[rows] -= linear.image_px[rows, None] * across[rows]
    starts = np.searchsorted(linear.line[rows], np.arange(linear.n_lines))
    counts = np.bincount(linear.line[rows], minlength=linear.n_lines)
    of_line = linear.line[rows]
    errors = linear.image_px[rows] / np.sqrt(np.maximum(1 - linear.leverage[rows], 0.05))
    mean = np.bincount(of_line, errors, linear.n_lines) / np.maximum(counts, 1)
    errors = (errors - mean[of_line]) * np.sqrt(counts / np.maximum(counts - 1, 1))[of_line]

    def draw(rng: np.random.Generator) -> FitTask:
        drawn = starts[of_line] + (rng.random(len(rows)) * counts[of_line]).astype(np.int64)
        moved = fitted.copy()
        moved[rows] += errors[drawn][:, None] * across[rows]
        whole = np.zeros((block.weight.size, 2))
        whole[cells] = moved
        return problem.task._replace(
            block=problem.task.block._replace(xy=whole.reshape(*block.weight.shape, 2))
        )

    return draw

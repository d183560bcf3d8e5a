"""Run the compiled fit on NumPy arrays: one problem, or a batch of one shape."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import jax
import numpy as np

from plumbline.fit.program.compiled import program
from plumbline.fit.program.task import FitTask, Solution
from plumbline.models.base import Model

BATCH = 16
"""Problems that `solve_many` takes in one program."""

_FEW = 4
"""Problems that are quicker one by one than in a batch of 16: chosen."""


_ELSEWHERE = tuple((x, y) for x in (-0.4, 0.4) for y in (-0.3, 0.3))
"""Where else a free distortion centre is begun, in corner radii: chosen, because in a crop the
centre lies off the middle by a quarter of the photo and more, and from the middle alone 3 of 109
such fits ended in a wrong minimum."""

_SCALES = 0.6, 4.0
"""Mean scales of the corrected photo beyond which a fit has collapsed, as `refuse_collapsed`."""


def solve(model: Model, task: FitTask) -> Solution:
    """Fit one problem; where the distortion centre is free, from several places.

    Args:
        model: The distortion model.
        task: The problem.
    """
    return _best([_solved(model, each) for each in _beginnings(task)], task)


def _solved(model: Model, task: FitTask) -> Solution:
    arrays = jax.tree.map(np.asarray, task)
    with jax.enable_x64(True):
        return jax.tree.map(np.asarray, program(model, arrays, None)(arrays))


def _beginnings(task: FitTask) -> list[FitTask]:
    """The problem with all places where the centre is begun, as the user has it first."""
    free = np.asarray(task.free)[-2:]
    if not (task.staged and free.any()):
        return [task]
    first = np.asarray(task.start, dtype=np.float64)
    moved = [first]
    for place in _ELSEWHERE:
        start = first.copy()
        start[-2:] += np.where(free, np.array(place) * task.corner, 0.0)
        if not any(np.array_equal(start, other) for other in moved):
            moved.append(start)
    return [task._replace(start=start) for start in moved]


def _best(solutions: Sequence[Solution], task: FitTask) -> Solution:
    """The lowest minimum that makes sense; the first where none does."""

    def cost(solution: Solution) -> float:
        sound = (
            int(solution.folded) == 0
            and _SCALES[0] <= float(solution.scale) <= _SCALES[1]
            and float(np.hypot(*np.asarray(solution.coefficients)[-2:])) <= float(task.corner)
        )
        square = float(np.sum(np.square(solution.residual)))
        return square if sound and np.isfinite(square) else np.inf

    return min(solutions, key=cost)  # of equal ones the first


def solve_many(model: Model, tasks: Sequence[FitTask]) -> list[Solution]:
    """Fit problems whose blocks have one shape, `BATCH` at a time in one program.

    The last batch is filled up with repetitions, so that all of that shape share the program; a
    few problems are quicker one by one.
    """
    return launch(model, tasks)()


def launch(model: Model, tasks: Sequence[FitTask]) -> Callable[[], list[Solution]]:
    """Begin to fit problems as `solve_many` does; what is returned waits for the solutions.

    JAX computes in threads of its own meanwhile.
    """
    every = [_beginnings(task) for task in tasks]
    flat = [each for beginnings in every for each in beginnings]
    running = [
        _launched(model, flat[first : first + BATCH]) for first in range(0, len(flat), BATCH)
    ]

    def solutions() -> list[Solution]:
        found = iter([solution for batch in running for solution in batch()])
        return [
            _best([next(found) for _ in beginnings], task)
            for task, beginnings in zip(tasks, every, strict=True)
        ]

    return solutions


def _launched(model: Model, tasks: Sequence[FitTask]) -> Callable[[], list[Solution]]:
    if len(tasks) <= _FEW:
        return lambda: [_solved(model, task) for task in tasks]
    filled = [*tasks, *[tasks[-1]] * (BATCH - len(tasks))]
    stacked = jax.tree.map(lambda *leaves: np.stack(leaves), *filled)
    with jax.enable_x64(True):
        solved = program(model, stacked, BATCH)(stacked)

    def solutions() -> list[Solution]:
        leaves = [np.asarray(leaf)[: len(tasks)] for leaf in solved]
        return [Solution(*each) for each in zip(*leaves, strict=True)]

    return solutions

"""Run the compiled fit on NumPy arrays: one problem, or a batch of one shape."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import jax
import numpy as np

from plumbline.fit.program.compiled import program
from plumbline.fit.program.task import Solution, Task
from plumbline.models.base import Model

BATCH = 16
"""Problems that `solve_many` takes in one program."""

_FEW = 4


def solve(model: Model, task: Task) -> Solution:
    """Fit one problem.

    Args:
        model: The distortion model.
        task: The problem.
    """
    arrays = jax.tree.map(np.asarray, task)
    with jax.enable_x64(True):
        return jax.tree.map(np.asarray, program(model, arrays, None)(arrays))


def solve_many(model: Model, tasks: Sequence[Task]) -> list[Solution]:
    """Fit problems whose blocks have one shape, `BATCH` at a time in one program.

    The last batch is filled up with repetitions, so that all of that shape share the program; a
    few problems are quicker one by one.
    """
    return launch(model, tasks)()


def launch(model: Model, tasks: Sequence[Task]) -> Callable[[], list[Solution]]:
    """Begin to fit problems as `solve_many` does; what is returned waits for the solutions.

    JAX computes in threads of its own meanwhile.
    """
    running = [
        _launched(model, tasks[first : first + BATCH]) for first in range(0, len(tasks), BATCH)
    ]
    return lambda: [solution for batch in running for solution in batch()]


def _launched(model: Model, tasks: Sequence[Task]) -> Callable[[], list[Solution]]:
    if len(tasks) <= _FEW:
        return lambda: [solve(model, task) for task in tasks]
    filled = [*tasks, *[tasks[-1]] * (BATCH - len(tasks))]
    stacked = jax.tree.map(lambda *leaves: np.stack(leaves), *filled)
    with jax.enable_x64(True):
        solved = program(model, stacked, BATCH)(stacked)

    def solutions() -> list[Solution]:
        leaves = [np.asarray(leaf)[: len(tasks)] for leaf in solved]
        return [Solution(*each) for each in zip(*leaves, strict=True)]

    return solutions

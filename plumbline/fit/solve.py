"""Run the compiled fit on NumPy arrays: one problem, or a batch of one shape."""

from __future__ import annotations

from collections.abc import Sequence

import jax
import numpy as np

from plumbline.fit.blocks import AnyArray
from plumbline.fit.programs import program
from plumbline.fit.task import Solution, Task
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
    solved: list[Solution] = []
    for first in range(0, len(tasks), BATCH):
        solved += _solve_batch(model, tasks[first : first + BATCH])
    return solved


def _solve_batch(model: Model, tasks: Sequence[Task]) -> list[Solution]:
    if len(tasks) <= _FEW:
        return [solve(model, task) for task in tasks]
    filled = [*tasks, *[tasks[-1]] * (BATCH - len(tasks))]
    stacked = jax.tree.map(lambda *leaves: np.stack(leaves), *filled)
    with jax.enable_x64(True):
        solved = jax.tree.map(np.asarray, program(model, stacked, BATCH)(stacked))
    return [_one_of(solved, index) for index in range(len(tasks))]


def _one_of(solved: Solution, index: int) -> Solution:
    def take(leaf: AnyArray) -> AnyArray:
        return leaf[index]

    return jax.tree.map(take, solved)

"""Corners with their columns and rows, while a board grows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from plumbline.frame import Array

Cell = tuple[int, int]
"""Column and row."""

STEPS: tuple[Cell, ...] = ((1, 0), (0, 1), (-1, 0), (0, -1))
"""To the neighbours, turning as the edges of `Corners` do."""


@dataclass(frozen=True)
class Placed:
    """A corner in its cell.

    Attributes:
        x: Where it lies, pixels.
        y: The same, downwards.
        sign: 1 where brightness rises across its edge along `STEPS[0]` as the edges turn, else −1.
        contrast: Half the difference between light and dark around it.
    """

    x: float
    y: float
    sign: int
    contrast: float

    @property
    def xy(self) -> Array:
        """Where it lies, shape (2,)."""
        return np.array([self.x, self.y])


Lattice = dict[Cell, Placed]
"""Corners by cell."""


def beside(cell: Cell, step: Cell, times: int = 1) -> Cell:
    """The cell that many steps on."""
    return cell[0] + times * step[0], cell[1] + times * step[1]


def frontier(lattice: Lattice) -> list[Cell]:
    """Empty cells beside filled ones, in reading order."""
    around = {beside(cell, step) for cell in lattice for step in STEPS}
    return sorted(around - lattice.keys(), key=lambda cell: (cell[1], cell[0]))


def prediction(lattice: Lattice, cell: Cell) -> tuple[Array, float] | None:
    """Where a cell's corner should lie by its neighbours, and the side of a square there.

    Returns:
        The median of what each direction says (three corners in a row continued by their second
        difference, two straight on, and three corners of a square as a parallelogram) and the
        least distance to a neighbour; None where no direction says anything.
    """
    said = list(_said(lattice, cell))
    near = [beside(cell, step) for step in STEPS]
    known = [lattice[each].xy for each in near if each in lattice]
    if not said or not known:
        return None
    at: Array = np.median(np.array(said), axis=0)
    return at, min(float(np.hypot(*(at - other))) for other in known)


def _said(lattice: Lattice, cell: Cell) -> Iterator[Array]:
    for step in STEPS:
        row = [lattice.get(beside(cell, step, times)) for times in (1, 2, 3)]
        first, second, third = row
        if first and second:
            straight_on = 2 * first.xy - second.xy
            yield straight_on + (first.xy - 2 * second.xy + third.xy if third else 0.0)
    for step, across in zip(STEPS, (*STEPS[1:], STEPS[0]), strict=True):
        one, other = lattice.get(beside(cell, step)), lattice.get(beside(cell, across))
        opposite = lattice.get(beside(beside(cell, step), across))
        if one and other and opposite:
            yield one.xy + other.xy - opposite.xy

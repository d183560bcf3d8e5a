"""Which column of a table names the lines: told by its role, then by its name.

A column that names lines has few distinct values, each with several points that follow an edge.
A name settles what the values leave open; a column `line` always counts.
"""

from __future__ import annotations

import re
from array import array
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array

CERTAIN = "line"
"""The name of a column that is taken whatever it holds."""

_WORDS = re.compile(
    r"(poly)?lines?|edges?|curves?|groups?|labels?|series|segments?|strokes?|shapes?|"
    r"linien?|kanten?|gruppen?|strecken?|serien?|reihen?|"
    r"lignes?|linea|línea|linha|retta|recta|bord|arete|arête",
)
"""Words for a line in the languages of those who sent files, and their plurals."""

_FEWEST = 3
"""Points a value has on average in a column that names lines: fewer make no line."""

_LESS_SCATTER = 0.25
"""Scatter about each group's parabola over that about one of all points, at most.

Chosen: a column that names lines leaves far less scatter, others (visibility, quality, direction,
part of the building) about as much as none.
"""

_ALIKE = 1.5
"""Ratio of scatters below which two columns group alike, and the name decides. Chosen."""

_LOOKED_AT = 300
"""Groups of which the scatter is taken; chosen, because more do not change it by a tenth."""

_MANY = 10_000
"""Distinct values from which on a column is left if most of its values are new. Chosen."""


@dataclass
class Column:
    """The values of one column as numbers.

    Attributes:
        name: Its header; empty for blank rows between blocks.
        codes: The number of each row's value.
        values: The distinct values, in the order of their numbers.
        given_up: Whether it has too many distinct values to name lines.
    """

    name: str
    codes: array[int] = field(default_factory=lambda: array("l"))
    values: dict[str, int] = field(default_factory=dict[str, int])
    given_up: bool = False

    def add(self, value: str) -> None:
        """The value of the next row."""
        if self.given_up:
            return
        self.codes.append(self.values.setdefault(value, len(self.values)))
        if len(self.values) > max(_MANY, len(self.codes) // 2):
            self.given_up = True
            self.codes, self.values = array("l"), {}

    @property
    def numbers(self) -> NDArray[np.int64]:
        """The codes as an array."""
        return np.array(self.codes, dtype=np.int64)

    @property
    def rank(self) -> int:
        """0 for a column whose name says that it names lines, else 1."""
        words = re.split(r"[^a-zà-ÿ]+|(?<=[a-z])(?=id\b|nr\b|no\b|name\b)", self.name.lower())
        return 0 if any(_WORDS.fullmatch(word) for word in words if word) else 1


def chosen(
    columns: Sequence[Column], blocks: Column, xy: Array, photos: NDArray[np.int64]
) -> Column | None:
    """The column that names the lines, or `blocks` where blank rows part them.

    Args:
        columns: All columns that may.
        blocks: The number of the block between blank rows that each row stands in.
        xy: The points, shape (n, 2).
        photos: The number of each point's photo.

    Returns:
        None where nothing parts the points.
    """
    for column in columns:
        if column.name == CERTAIN:
            return column
    able = [each for each in (*columns, blocks) if _may_name_lines(each, len(xy))]
    whole = _scatter(xy, photos)
    scatters = {
        id(each): _scatter(xy, _within(photos, each.numbers)) / (whole or 1.0) for each in able
    }
    least = min(scatters.values(), default=np.inf)
    good = [each for each in able if scatters[id(each)] <= max(_ALIKE * least, 1e-6)]
    if least > _LESS_SCATTER:
        good = [each for each in able if each is blocks or each.rank == 0]
    if good:
        return min(good, key=lambda each: (each is not blocks and each.rank, len(each.values)))
    if len(blocks.values) > 1:
        return blocks
    alone = [each for each in columns if each.rank == 0 and len(each.values) == 1]
    return alone[0] if alone else None


def _may_name_lines(column: Column, n: int) -> bool:
    few = 1 < len(column.values) <= n / (_FEWEST if column.rank else 2)
    return few and not column.given_up and "" not in column.values


def _within(photos: NDArray[np.int64], codes: NDArray[np.int64]) -> NDArray[np.int64]:
    """The number of each point's group, where values of several photos are different groups."""
    return photos * (int(codes.max()) + 1) + codes


def _scatter(xy: Array, groups: NDArray[np.int64]) -> float:
    """Standard deviation of points about the best parabola of their group, in pixels."""
    order = np.argsort(groups, kind="stable")
    starts = np.flatnonzero(np.diff(groups[order], prepend=-1))
    parts = np.split(order, starts[1:])
    step = max(1, len(parts) // _LOOKED_AT)
    squares = freedom = 0.0
    for part in parts[::step]:
        parabola = len(part) >= 5  # a parabola through three points has no scatter
        if len(part) > 2:
            squares += _squares(xy[part], parabola=parabola)
            freedom += len(part) - (3 if parabola else 2)
    return float(np.sqrt(squares / freedom)) if freedom else np.inf


def _squares(points: Array, *, parabola: bool) -> float:
    centred = points - points.mean(axis=0)
    _, axes = np.linalg.eigh(centred.T @ centred)
    across, along = centred @ axes[:, 0], centred @ axes[:, 1]
    length = float(np.abs(along).max())
    if not parabola or length == 0.0:
        return float(np.sum(across**2))
    powers = np.vander(along / length, 3)
    return float(np.sum((across - powers @ np.linalg.lstsq(powers, across)[0]) ** 2))

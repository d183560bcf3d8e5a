"""Lines in the photo: which are parallel on the plane, which is the horizon, which only straight.

Any format of picked lines is read; a table may have a column `parallel` beside `line`, whose
value names the set of parallel lines that the line belongs to:

    line,x,y,parallel
    kerb,102.5,1401.0,lane
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plumbline.errors import OptionError
from plumbline.formats.base import Source, shown
from plumbline.formats.points.lines import clean_label
from plumbline.formats.points.table import Table
from plumbline.frame import Array
from plumbline.ground.adjusting.network import GroundLine
from plumbline.observations import Observations
from plumbline.wording import listed

MOST_PICKS = 2_000
"""Chosen, because the adjustment is dense."""


@dataclass(frozen=True)
class Lines:
    """Lines by what they tell.

    Attributes:
        ground: Those on the plane, in parallel sets of two at least.
        straight: Others.
        horizon_px: Points of the horizon, shape (m, 2).
    """

    ground: tuple[GroundLine, ...]
    straight: tuple[Array, ...]
    horizon_px: Array


def parallel_column(source: Source) -> dict[str, str]:
    """The set that each line of a table names in its column `parallel`; empty without one."""
    try:
        table = Table.of(source)
        rows = (cells for _, cells in table.rows() if any(map(str.strip, cells)))
        header = [cell.strip().lower() for cell in next(rows)]
    except (OptionError, StopIteration):
        return {}
    if "parallel" not in header or "line" not in header:
        return {}
    at, line = header.index("parallel"), header.index("line")
    return {
        clean_label(cells[line]): clean_label(cells[at])
        for cells in rows
        if len(cells) > max(at, line) and cells[at].strip()
    }


def sorted_lines(
    observations: Observations,
    column: dict[str, str],
    parallel: Sequence[Sequence[str]],
    horizon: str | None,
) -> Lines:
    """Sort the lines of one photo.

    Args:
        observations: The lines as picked.
        column: The set that a line belongs to by the file.
        parallel: Further sets, by names of lines.
        horizon: Name of the horizon.

    Raises:
        OptionError: a name is unknown, or a line stands in two sets or alone in one.
    """
    named = {line.label: line.points_px for line in observations.lines}
    if sum(map(len, named.values())) > MOST_PICKS:
        raise OptionError(
            f"the lines have more than {MOST_PICKS:,} picks", hint="thin them out to a few dozen"
        )
    sets: dict[str, str] = {}
    for number, names in enumerate(parallel):
        for name in names:
            sets[name] = _known(name, named, f"\0{number}", sets)
    for name, group in column.items():
        if name in named:
            sets.setdefault(name, group)
    if horizon is not None:
        _known(horizon, named, "", {})
        if horizon in sets:
            raise OptionError(f"{horizon} is the horizon and in a set of parallel lines")
    groups = sorted(set(sets.values()))
    for group in groups:
        members = [name for name, of in sets.items() if of == group]
        if len(members) < 2:
            raise OptionError(
                f"{members[0]} is the only line of its parallel set",
                hint="name two lines at least, as --parallel left,right",
            )
    ground = tuple(
        GroundLine(name, picks, groups.index(sets[name]))
        for name, picks in named.items()
        if name in sets
    )
    straight = tuple(p for name, p in named.items() if name not in sets and name != horizon)
    return Lines(ground, straight, named[horizon] if horizon else np.empty((0, 2)))


def _known(name: str, named: dict[str, Array], group: str, sets: dict[str, str]) -> str:
    if name not in named:
        raise OptionError(
            f"no line is named {shown(name)}", hint=f"there are {listed(list(named), 12)}"
        )
    if name in sets:
        raise OptionError(f"{name} stands in two parallel sets", hint="name it once")
    return group

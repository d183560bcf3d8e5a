"""Tape distances: `from,to,metres[,sigma]`, in all dialects of CSV.

from,to,metres,sigma
A,B,3.02,0.01
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from plumbline.errors import ReadError
from plumbline.files import read_bytes
from plumbline.formats.base import Source, shown
from plumbline.formats.points.lines import clean_label
from plumbline.formats.points.table import Table
from plumbline.ground.adjusting.network import Tape
from plumbline.wording import listed

MOST_TAPES = 2_000
"""Chosen, because the adjustment is dense."""

_HINT = "give the columns from,to,metres and perhaps sigma; names are those of the match points"


def read_tapes(path: str, names: Sequence[str], sigma_m: float) -> tuple[Tape, ...]:
    """Read tape distances between named points.

    Args:
        path: The file.
        names: Names of the points.
        sigma_m: Standard error where the file gives none.

    Raises:
        ReadError: the file is damaged, names an unknown point, or two tapes contradict a third.
    """
    source = Source(path, read_bytes(path))
    table = Table.of(source)
    number = table.number_reader()
    index = {name: at for at, name in enumerate(names)}
    tapes: list[Tape] = []
    rows: dict[tuple[int, int], int] = {}
    first = True
    for row, cells in table.rows():
        values = [cell.strip() for cell in cells]
        if not any(values):
            continue
        if first and values[0].lower() in ("from", "first", "a", "point") and not _number(values):
            first = False
            continue
        first = False
        if not 3 <= len(values) <= 4:
            raise source.error(f"the row has {len(values)} columns", row, _HINT)
        ends = [clean_label(value) for value in values[:2]]
        for end in ends:
            if end not in index:
                raise source.error(
                    f"no point is named {shown(end)}; there are {listed(list(names))}", row, _HINT
                )
        numbers = _numbers(table, [value for value in values[2:] if value], row, number)
        pair = (index[ends[0]], index[ends[1]])
        if pair[0] == pair[1]:
            raise source.error(f"this tape runs from {ends[0]} to itself", row, "correct it")
        rows.setdefault(pair, row)
        tapes.append(Tape(*pair, numbers[0], numbers[1] if len(numbers) > 1 else sigma_m))
    if not tapes:
        raise source.error("the file holds no tapes", hint=_HINT)
    if len(tapes) > MOST_TAPES:
        raise source.error(f"the file holds more than {MOST_TAPES:,} tapes", hint="leave some out")
    _refuse_broken_triangles(source, tapes, names)
    return tuple(tapes)


def _number(values: Sequence[str]) -> bool:
    try:
        float(values[2].replace(",", "."))
    except (ValueError, IndexError):
        return False
    return True


def _numbers(
    table: Table, texts: Sequence[str], row: int, number: Callable[[str], float]
) -> list[float]:
    try:
        values = [number(text) for text in texts]
    except ValueError:
        raise table.bad_number(texts, row) from None
    for value in values:
        if not (math.isfinite(value) and 0 < value < 1e6):
            raise table.source.error(
                f"{value:g} is not a length in metres", row, "correct or remove this row"
            )
    return values


def _refuse_broken_triangles(source: Source, tapes: Sequence[Tape], names: Sequence[str]) -> None:
    """Refuse three tapes that cannot close, whatever the places of their ends."""
    of: dict[frozenset[int], Tape] = {frozenset((t.first, t.second)): t for t in tapes}
    ends = sorted({end for tape in tapes for end in (tape.first, tape.second)})
    near: dict[int, set[int]] = {end: set() for end in ends}
    for tape in tapes:
        near[tape.first].add(tape.second)
        near[tape.second].add(tape.first)
    for a in ends:
        for b in near[a]:
            for c in near[a] & near[b]:
                if a < b < c:
                    trio = [of[frozenset(p)] for p in ((a, b), (b, c), (a, c))]
                    _refuse_open(source, trio, names)


def _refuse_open(source: Source, trio: Sequence[Tape], names: Sequence[str]) -> None:
    long = max(trio, key=lambda tape: tape.metres)
    short = [tape for tape in trio if tape is not long]
    gap = long.metres - sum(tape.metres for tape in short)
    if gap > 4 * math.hypot(*(tape.sigma_m for tape in trio)):
        raise _open(source, long, short, names)


def _open(source: Source, long: Tape, short: Sequence[Tape], names: Sequence[str]) -> ReadError:
    def told(tape: Tape) -> str:
        return f"{names[tape.first]}-{names[tape.second]} {tape.metres:g} m"

    return source.error(
        f"no triangle has the sides {told(long)}, {told(short[0])} and {told(short[1])}: the first "
        "is longer than the others together",
        hint="correct the tape that is wrong",
    )

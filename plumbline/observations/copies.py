"""Copies add no evidence: lines and picks that stand twice are found, to be counted once."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from plumbline.observations.picks import Line
from plumbline.wording import count, joined

_SAME_EDGE = 2
"""Picks that two lines of one photo may not share: two straight edges meet in one point."""

_FEWEST = 3
"""Points without which there is no line."""

_NAMED = 20
"""Copies of one line that a note names, chosen to name all that people make by hand."""

_MOST_LINES = 16
"""Lines that are remembered at a point.

Chosen, because a grid has four lines through a point (row, column, diagonals), and a bound keeps
a hundred thousand lines through one point from taking for ever.
"""


@dataclass(frozen=True)
class Copy:
    """Picks of one line that another one holds already.

    Attributes:
        line: Index of the line that repeats.
        original: Index of the line that is repeated.
        picks: How many picks are repeated.
        left: How many of its own the line keeps; with none it is left out.
    """

    line: int
    original: int
    picks: int
    left: int


def counted_once(
    lines: Sequence[Line], photos: Sequence[Hashable], frames: Sequence[Hashable]
) -> tuple[tuple[Line, ...], tuple[Copy, ...]]:
    """Lines without the picks that a longer or earlier line holds already.

    Lines of one photo that share two picks lie on one edge: what they share counts once. One
    shared pick is where two lines cross. A line of another photo of the same frame is a copy
    only if it is repeated as a whole.

    Args:
        lines: The lines.
        photos: For each line what tells its photo from others.
        frames: For each line what tells the kind of photo, its lens and size, from others.

    Returns:
        The lines that are left, and the copies that were found.
    """
    shared = _shared_points(lines, frames)
    if not shared:
        return tuple(lines), ()
    at_point: defaultdict[int, list[int]] = defaultdict(list)
    kept: dict[int, Line] = dict(enumerate(lines))
    copies: list[Copy] = []
    for index in sorted(shared, key=lambda each: (-len(lines[each].points_px), each)):
        points = shared[index]
        n = len(lines[index].points_px)
        common = Counter(other for group in points.values() for other in at_point[group])
        originals = {
            other: picks
            for other, picks in common.items()
            if picks >= (_SAME_EDGE if photos[other] == photos[index] else max(n, _FEWEST))
        }
        repeated = {
            place
            for place, group in points.items()
            if not originals.keys().isdisjoint(at_point[group])
        }
        if repeated:
            left = np.setdiff1d(np.arange(n), np.fromiter(repeated, np.int64))
            original = max(originals, key=lambda each: (originals[each], -each))
            stays = len(left) >= _FEWEST
            copies.append(Copy(index, original, len(repeated), len(left) if stays else 0))
            if not stays:
                del kept[index]
                continue
            kept[index] = _only(lines[index], left)
        for place, group in points.items():
            if place not in repeated and len(at_point[group]) < _MOST_LINES:
                at_point[group].append(index)
    return tuple(kept.values()), tuple(sorted(copies, key=lambda copy: copy.line))


def told(copies: Sequence[Copy], names: Sequence[str]) -> tuple[str, ...]:
    """What was repeated, in sentences that name the copies.

    Args:
        copies: What was found.
        names: The name of each line.
    """
    whole: defaultdict[int, list[str]] = defaultdict(list)
    for copy in copies:
        if not copy.left:
            whole[copy.original].append(names[copy.line])
    each = [
        f"{'line' if len(again) == 1 else 'lines'} {joined(_cut(again))} "
        f"{'repeats' if len(again) == 1 else 'repeat'} line {names[original]}"
        for original, again in whole.items()
    ]
    notes: list[str] = []
    if each:
        number = sum(map(len, whole.values()))
        copied = "the copy counts once" if number == 1 else f"these {number:,} copies count once"
        notes.append(f"{'; '.join(_cut(each))}: {copied}")
    parts = [
        f"line {names[copy.line]} repeats {count(copy.picks, 'pick')} of line "
        f"{names[copy.original]}"
        for copy in copies
        if copy.left
    ]
    if parts:
        notes.append(f"{'; '.join(_cut(parts))}: what two lines share counts once")
    return tuple(notes)


def _cut(items: Sequence[str]) -> list[str]:
    more = [f"{len(items) - _NAMED:,} more"] if len(items) > _NAMED else []
    return [*items[:_NAMED], *more]


def _shared_points(lines: Sequence[Line], frames: Sequence[Hashable]) -> dict[int, dict[int, int]]:
    """For each line that shares points with another, the number of each such point, by place."""
    if len(lines) < 2:
        return {}
    numbers: dict[Hashable, int] = {}
    frame_of = [numbers.setdefault(frame, len(numbers)) for frame in frames]
    sizes = [len(line.points_px) for line in lines]
    of_line = np.repeat(np.arange(len(lines)), sizes)
    place = np.concatenate([np.arange(size) for size in sizes])
    frame = np.array(frame_of)[of_line]
    x, y = np.concatenate([line.points_px for line in lines]).T
    order = np.lexsort((y, x, frame))
    same = (np.diff(x[order]) == 0) & (np.diff(y[order]) == 0) & (np.diff(frame[order]) == 0)
    if not same.any():
        return {}
    group = np.concatenate(([0], np.cumsum(~same)))
    several = np.bincount(group)[group] > 1
    found: dict[int, dict[int, int]] = {}
    chosen: NDArray[np.int64] = order[several]
    for number, index in zip(group[several].tolist(), chosen.tolist(), strict=True):
        found.setdefault(int(of_line[index]), {})[int(place[index])] = number
    return found


def _only(line: Line, places: NDArray[np.int64]) -> Line:
    rows = None if line.rows is None else line.rows[places]
    return replace(line, points_px=line.points_px[places], rows=rows)

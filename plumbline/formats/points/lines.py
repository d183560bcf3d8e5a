"""Gather points into labelled lines on photos, and say what was left aside."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from plumbline.formats.base import Source
from plumbline.observations import MAX_SIDE, Line, Observations, Photo
from plumbline.wording import count, listed

MAX_LABEL = 120
"""Characters; chosen, a longer name does not fit a table or message."""
MAX_PICKED_LINES = 200_000
"""Chosen: twice the 100,000 lines that the fit is measured with."""
FEWEST = 3
"""Points that make a line of one shape; fewer are single picks, gathered by their label."""
Size = tuple[int, int]


def clean_label(text: str, most: int = MAX_LABEL) -> str:
    """A name from a file as one short printable line."""
    printable = "".join(c if c.isprintable() else " " for c in text[: 8 * most])
    return " ".join(printable.split())[:most].rstrip()


class UniqueLabels:
    """Makes labels differ: "wall", "wall (2)", "wall (3)"; an empty one becomes a number."""

    def __init__(self) -> None:
        self._used: set[tuple[Hashable, str]] = set()
        self._times: Counter[tuple[Hashable, str]] = Counter()

    def __call__(self, label: str, scope: Hashable = 0) -> str:
        """A label not yet given out in this scope."""
        name = clean_label(label)
        wanted = name
        while not wanted or (scope, wanted) in self._used:
            self._times[scope, name] += 1
            times = self._times[scope, name]
            wanted = f"{name} ({times + 1})" if name else str(times)
        self._used.add((scope, wanted))
        return wanted


@dataclass
class _Picks:
    """Single picks of one line."""

    label: str
    photo: Hashable
    photo_name: str
    size: Size | None
    points: list[list[float]] = field(default_factory=list[list[float]])
    rows: list[int | None] = field(default_factory=list["int | None"])


class LineGatherer:
    """Collects the lines of one file and the photos they lie on.

    Args:
        source: The file, for messages.
        shift_px: Added to x and y: -0.5 where a program counts from the pixel's edge.
    """

    def __init__(self, source: Source, *, shift_px: float = 0.0) -> None:
        self.source = source
        self.notes: list[str] = []
        self._shift_px = shift_px
        self._photos: dict[Hashable, int] = {}
        self._gathered: list[Photo] = []
        self._lines: list[Line] = []
        self._labels = UniqueLabels()
        self._aside: Counter[str] = Counter()
        self._picks: dict[Hashable, _Picks] = {}

    def add(
        self,
        points: ArrayLike,
        label: str = "",
        *,
        photo: Hashable = "",
        photo_name: str = "",
        size: Size | None = None,
        rows: ArrayLike | None = None,
    ) -> None:
        """Add one line.

        Args:
            points: Shape (n, 2), as the program counts them.
            label: Its name; made unique on its photo.
            photo: What tells its photo from others.
            photo_name: The photo's file name.
            size: The photo's size as the file declares it.
            rows: Lines of the file where the points stand, or the one where all do.

        Raises:
            ReadError: a coordinate is not finite, or there are more lines than any real file
                has.
        """
        if len(self._lines) == MAX_PICKED_LINES:
            raise self.source.error(
                f"the file holds more than {MAX_PICKED_LINES:,} lines",
                hint="give the picks of one photo or a few at a time",
            )
        index = self._photo(photo, photo_name, size)
        given = np.asarray(points, dtype=np.float64).reshape(-1, 2)
        numbers = None
        if rows is not None:
            numbers = np.empty(len(given), dtype=np.int64)
            numbers[:] = rows
        finite = np.isfinite(given).all(axis=1)
        if not finite.all():
            worst = int(np.argmin(finite))
            line = None if numbers is None else int(numbers[worst])
            name = clean_label(label) or len(self._lines) + 1
            raise self.source.error(
                f"a point of line {name} is not a finite number",
                line,
                "correct or remove it",
            )
        name = self._labels(label, index)
        shifted = given + self._shift_px if self._shift_px else given  # keeps a negative zero
        self._lines.append(Line(shifted, index, name, numbers))

    def pick(
        self,
        points: ArrayLike,
        label: str,
        *,
        group: Hashable = None,
        photo: Hashable = "",
        photo_name: str = "",
        size: Size | None = None,
        row: int | None = None,
    ) -> None:
        """Add picks that stand by themselves; those of one group on one photo make a line.

        Args:
            points: Shape (n, 2) or (2,), as the program counts them.
            label: The name of the line.
            group: What tells its line from others; the label if None.
            photo: What tells its photo from others.
            photo_name: The photo's file name.
            size: The photo's size as the file declares it.
            row: The row of the file where the picks stand.
        """
        key = (photo, label if group is None else group)
        line = self._picks.setdefault(key, _Picks(label, photo, photo_name, size))
        for point in np.asarray(points, dtype=np.float64).reshape(-1, 2).tolist():
            line.points.append(point)
            line.rows.append(row)

    def leave_aside(self, kind: str) -> None:
        """Count a shape that is not read, by its kind."""
        self._aside[clean_label(kind)[:30] or "unnamed"] += 1

    def observations(self, read_kinds: str = "") -> Observations:
        """All that was gathered.

        Args:
            read_kinds: The shapes that are read, for the note about those left aside.

        Raises:
            ReadError: there is no line.
        """
        for line in self._picks.values():
            rows = [row for row in line.rows if row is not None]
            self.add(
                line.points,
                line.label,
                photo=line.photo,
                photo_name=line.photo_name,
                size=line.size,
                rows=rows if len(rows) == len(line.points) else None,
            )
        self._picks.clear()
        kinds = [f"{n:,} × {kind}" for kind, n in sorted(self._aside.items())]
        if kinds:
            total = count(self._aside.total(), "shape")
            self.notes.append(f"{total} left aside ({listed(kinds)}): only {read_kinds} are read")
        if not self._lines:
            raise self.source.error(
                "the file holds no line of points" + (f" but {listed(kinds)}" if kinds else ""),
                hint=f"draw each straight edge; only {read_kinds} are read" if read_kinds else "",
            )
        return Observations(tuple(self._gathered), tuple(self._lines), notes=tuple(self.notes))

    def _photo(self, key: Hashable, name: str, size: Size | None) -> int:
        index = self._photos.get(key)
        if index is None:
            index = self._photos[key] = len(self._gathered)
            self._gathered.append(Photo(size, clean_label(name)))
        return index


def declared_size(source: Source, width: float, height: float, line: int | None = None) -> Size:
    """The size of a photo as a file declares it.

    Raises:
        ReadError: it is not two whole numbers of pixels.
    """
    whole = width == int(width) and height == int(height)
    if not whole or not (0 < width <= MAX_SIDE and 0 < height <= MAX_SIDE):
        raise source.error(
            f"a photo of {width:g}x{height:g} pixels is impossible",
            line,
            "correct the width and height in the file",
        )
    return int(width), int(height)

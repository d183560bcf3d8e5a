"""Plain tables of points, as a spreadsheet or a script writes them.

    line,x,y                 10.5 20.5
    left,10.5,20.5           11.2 120
    left,11.2,120            (a blank line or a # comment starts the next line)
    roof,5,7                 5 7

With a header the columns may stand in any order: `line`, `x`, `y`, and `photo`, `image`, `file` or
`filename` where one lens took several photos. Without a column `line`, the one that tells the
lines apart by its values takes its place (`plumbline.formats.points.columns`), or else blank
lines and comments part the lines; a note names the columns that were ignored. Without a header,
three columns are line, x, y and two are x, y. Commas, semicolons, tabs or blanks part the
columns; with the latter three the decimal sign may be a comma. Rows of the same line need not
follow each other.

Coordinates are plumbline's own: pixels, (0, 0) the centre of the top-left pixel, y down.
Kept: lines, labels, photo names, row numbers. Dropped: other columns. A photo without lines,
and the sizes of photos, are not written. Source: plumbline's own format.
"""

from __future__ import annotations

import csv
import io
import re
from array import array
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import chain

import numpy as np

from plumbline.errors import OptionError, ReadError
from plumbline.formats.base import ReadOptions, Source
from plumbline.formats.points.columns import CERTAIN, Column, chosen
from plumbline.formats.points.imagej import is_results_header
from plumbline.formats.points.lines import MAX_PICKED_LINES, LineGatherer, UniqueLabels
from plumbline.formats.points.table import Row, Table
from plumbline.frame import Array
from plumbline.observations import Observations
from plumbline.wording import listed

_PHOTO = ("photo", "image", "filename", "file", "picture", "foto", "bild")
_UNIT = re.compile(r"[ _]*[\[(]?(px|pixels?)[\])]?$")
_AXIS = re.compile(r"(?:(?:pos|point|coord|image|pixel)[ _-]?)?([xy])(?:[ _-]?(?:pos|coord\w*))?")
_MOST_COLUMNS = 40
"""Columns that are looked at for names of lines; chosen, because no table at hand has more."""
_HINT = "start with the row 'line,x,y', then one row a point, such as 'roof,10.5,20'"


@dataclass(frozen=True)
class _Columns:
    """Where the columns stand; `photo` is -1 where there is none."""

    names: tuple[str, ...]
    x: int
    y: int
    photo: int = -1
    lines: tuple[int, ...] = ()
    header: bool = False


@dataclass(frozen=True)
class _Points:
    """The points row by row, and what may tell their lines and photos."""

    xy: array[float]
    rows: array[int]
    photos: Column
    blocks: Column
    columns: tuple[Column, ...]


def read(source: Source, _options: ReadOptions) -> Observations:
    """Points of a plain table, grouped by line and photo.

    Raises:
        ReadError: the text is not such a table.
    """
    table = Table.of(source)
    rows = table.rows()
    first = next((row for row in rows if any(map(str.strip, row[1]))), None)
    if first is None:
        raise source.error("the file holds no points", hint=_HINT)
    places = _columns(source, first[1], first[0])
    points = _points(table, places, rows if places.header else chain([first], rows))
    if not points.rows:
        raise source.error("the file holds a header but no points", hint=_HINT)
    xy = np.frombuffer(points.xy, dtype=np.float64).reshape(-1, 2)
    column = chosen(points.columns, points.blocks, xy, points.photos.numbers)
    gatherer = LineGatherer(source)
    gatherer.notes += _ignored(points, column)
    _gather(gatherer, points, column or points.blocks, xy)
    return gatherer.observations()


def _ignored(points: _Points, column: Column | None) -> list[str]:
    """A note on the columns that are not read."""
    others = [each.name for each in points.columns if each is not column and each.name]
    if not others:
        return []
    names = f"{'column' if len(others) == 1 else 'columns'} {listed(others)}"
    if column is None:
        return [f"no column names the lines ({names} ignored)"]
    chose = "" if column is points.blocks else f"column {column.name} names the lines; "
    return [f"{chose}{names} {'was' if len(others) == 1 else 'were'} ignored"]


def _gather(gatherer: LineGatherer, points: _Points, column: Column, xy: Array) -> None:
    at = np.frombuffer(points.rows, dtype=np.int64)
    lines, photos = column.numbers, points.photos.numbers
    for each, what in ((column, "line"), (points.photos, "photo")):
        if each.name and "" in each.values:
            row = int(at[int(np.argmax(each.numbers == each.values[""]))])
            raise gatherer.source.error(
                f"the row names no {what}", row, f"name the {what} in every row"
            )
    if len(column.values) * len(points.photos.values) > MAX_PICKED_LINES:
        raise gatherer.source.error(
            f"more than {MAX_PICKED_LINES:,} lines",
            hint="give the picks of one photo or a few at a time",
        )
    labels, names = list(column.values), list(points.photos.values)
    groups = photos * len(labels) + lines
    order = np.argsort(groups, kind="stable")
    starts = np.flatnonzero(np.diff(groups[order], prepend=-1))
    parts = np.split(order, starts[1:])
    for members in sorted(parts, key=lambda part: int(part[0])):
        photo = names[photos[members[0]]]
        label = labels[lines[members[0]]] if column.name else ""
        gatherer.add(xy[members], label, photo=photo, photo_name=photo, rows=at[members])


def recognises(source: Source) -> bool:
    """Whether the first row is a header with x and y, or two or three columns of points."""
    rows = Table.opening(source).first_rows(1)
    if not rows or is_results_header(rows[0]):
        return False
    try:
        _columns(source, rows[0], 1)
    except ReadError:
        return False
    return True


def write(observations: Observations) -> bytes:
    """The points as a table that `read` takes back exactly.

    Points of a table of this format come out in its order, those of other files line by line.

    Args:
        observations: Whatever was read. Labels are written as one line each and numbered
            where two are the same.

    Returns:
        Columns line, x, y, and photo if there is more than one, in UTF-8.

    Raises:
        OptionError: the lines are of several lenses, which a table cannot keep apart.
    """
    lenses = {observations.photos[line.photo].lens for line in observations.lines}
    if len(lenses) > 1:
        raise OptionError(
            f"{observations.named}the lines are of {len(lenses)} lenses, which a CSV cannot keep "
            "apart",
            hint="select a photo with --image N, or write a .pto or .json",
        )
    labels, photo_names = UniqueLabels(), UniqueLabels()
    photos = [photo_names(photo.name) for photo in observations.photos]
    several = len(photos) > 1
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    # A quoted field keeps a name that starts with # from reading as a comment.
    quoting = csv.writer(text, lineterminator="\n", quoting=csv.QUOTE_NONNUMERIC)
    writer.writerow(["line", "x", "y", "photo"] if several else ["line", "x", "y"])
    records: list[list[str | float]] = []
    for line in observations.lines:
        label = labels(line.label, line.photo)
        last = [photos[line.photo]] if several else []
        records += ([label, x, y, *last] for x, y in line.points_px.tolist())
    for index in _order(observations):
        record = records[index]
        (quoting if str(record[0]).startswith("#") else writer).writerow(record)
    return text.getvalue().encode()


def _order(observations: Observations) -> Iterable[int]:
    """The order of all lines' points in the table that they come from."""
    rows = [line.rows for line in observations.lines if line.rows is not None]
    of_table = [origin.format for origin in observations.origins] == ["csv"]
    if not of_table or len(rows) < len(observations.lines):
        return range(observations.n_points)
    return np.argsort(np.concatenate(rows), kind="stable").tolist()


def _columns(source: Source, cells: list[str], line: int) -> _Columns:
    names = [_UNIT.sub("", cell.strip().lower()[:40]) for cell in cells]
    axes = [found[1] if (found := _AXIS.fullmatch(name)) else "" for name in names]
    if "x" in axes and "y" in axes:
        for name in ("x", "y"):
            if axes.count(name) > 1:
                raise source.error(f"two columns are named {name}", line, _HINT)
        x, y = axes.index("x"), axes.index("y")
        photo = next((names.index(name) for name in _PHOTO if name in names), -1)
        others = (i for i in range(len(names)) if i not in {x, y, photo} and names[i])
        return _Columns(tuple(names), x, y, photo, tuple(others)[:_MOST_COLUMNS], header=True)
    if len(cells) in {2, 3} and all(_is_number(cell) for cell in cells[-2:]):
        width = len(cells)
        named = (CERTAIN, "x", "y")[-width:]
        return _Columns(named, width - 2, width - 1, lines=tuple(range(width - 2)))
    raise source.error(
        "the first row is neither a header with x and y nor a point in two or three columns",
        line,
        _HINT,
    )


def _is_number(cell: str) -> bool:
    try:
        float(cell.replace(",", ".", 1))
    except ValueError:
        return False
    return True


def _points(table: Table, places: _Columns, rows: Iterator[Row]) -> _Points:
    number = table.number_reader()
    width, x, y, photo = len(places.names), places.x, places.y, places.photo
    certain = [place for place in places.lines if places.names[place] == CERTAIN]
    columns = {place: Column(places.names[place]) for place in places.lines}
    looked_at = {place: columns[place].add for place in certain or places.lines}
    photos = Column("photo" if photo >= 0 else "")
    points = _Points(array("d"), array("q"), photos, Column(""), (*columns.values(),))
    block = 0
    for at, row in rows:
        cells = row if len(row) == width else _fitted(table.source, row, places, certain, at)
        try:
            pair = number(cells[x]), number(cells[y])
        except (ValueError, IndexError):
            if any(map(str.strip, row)):
                raise table.bad_number([cells[x], cells[y]], at) from None
            block += 1
            continue
        points.photos.add(cells[photo].strip() if photo >= 0 else "")
        points.blocks.add(str(block))
        for place, add in looked_at.items():
            add(cells[place].strip() if place < len(cells) else "")
        points.xy.extend(pair)
        points.rows.append(at)
    return points


def _fitted(
    source: Source, row: list[str], places: _Columns, certain: list[int], line: int
) -> list[str]:
    """A row of another width than the first: only unneeded cells may lack or be blank."""
    width = len(places.names)
    needed = max(places.x, places.y, places.photo, *certain) + 1
    blank = not any(map(str.strip, row))
    if blank or (len(row) >= needed and not any(map(str.strip, row[width:]))):
        return row
    raise source.error(
        f"the row has {len(row)} columns where {width} belong",
        line,
        "where numbers have a decimal comma, part the columns by semicolons",
    )

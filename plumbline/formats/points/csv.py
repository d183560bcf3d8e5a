"""Plain tables of points, as a spreadsheet or a script writes them.

    line,x,y                 10.5 20.5
    left,10.5,20.5           11.2 120
    left,11.2,120            (a blank line or a # comment starts the next line)
    roof,5,7                 5 7

With a header the columns may stand in any order: `line`, `x`, `y`, and `photo` or `image`
where one lens took several photos; other columns are ignored. A column named label, edge,
curve or group stands in for `line`, and one named filename for `photo`; without any of them,
blank lines and comments part the lines. Without a header, three columns are line, x, y and two are
x, y. Commas, semicolons, tabs or blanks part the columns; with the latter three the decimal
sign may be a comma. Rows of the same line need not follow each other.

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
from plumbline.formats.points.imagej import is_results_header
from plumbline.formats.points.lines import MAX_PICKED_LINES, LineGatherer, UniqueLabels
from plumbline.formats.points.table import Row, Table
from plumbline.observations import Observations

_LINE = ("line", "label", "edge", "curve", "group")
_PHOTO = ("photo", "image", "filename")
_UNIT = re.compile(r"[ _]*[\[(]?(px|pixels?)[\])]?$")
_HINT = "start with the row 'line,x,y', then one row a point, such as 'roof,10.5,20'"


@dataclass(frozen=True)
class _Columns:
    """Where the columns stand; -1 where there is none."""

    width: int
    x: int
    y: int
    line: int = -1
    photo: int = -1
    header: bool = False


@dataclass(frozen=True)
class _Points:
    """The points row by row, and which of them make each line of each photo."""

    xy: array[float]
    rows: array[int]
    members: dict[tuple[str, str | int], array[int]]


def read(source: Source, _options: ReadOptions) -> Observations:
    """Points of a plain table, grouped by line and photo.

    Raises:
        ReadError: the text is no such table.
    """
    table = Table.of(source)
    rows = table.rows()
    first = next((row for row in rows if any(map(str.strip, row[1]))), None)
    if first is None:
        raise source.error("the file holds no points", hint=_HINT)
    columns = _columns(source, first[1], first[0])
    points = _points(table, columns, rows if columns.header else chain([first], rows))
    if not points.rows:
        raise source.error("the file holds a header but no points", hint=_HINT)
    xy = np.frombuffer(points.xy, dtype=np.float64).reshape(-1, 2)
    at = np.frombuffer(points.rows, dtype=np.int64)
    gatherer = LineGatherer(source)
    for (photo, line), members in points.members.items():
        chosen = np.frombuffer(members, dtype=np.int64)
        if line == "" or (columns.photo >= 0 and not photo):
            missing = "line" if line == "" else "photo"
            raise source.error(f"the row names no {missing}", int(at[chosen[0]]), "name it")
        label = line if isinstance(line, str) else ""
        gatherer.add(xy[chosen], label, photo=photo, photo_name=photo, rows=at[chosen])
    return gatherer.observations()


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
    if "x" in names and "y" in names:
        for name in ("x", "y"):
            if names.count(name) > 1:
                raise source.error(f"two columns are named {name}", line, _HINT)
        label, photo = (
            next((names.index(name) for name in choice if name in names), -1)
            for choice in (_LINE, _PHOTO)
        )
        return _Columns(len(cells), names.index("x"), names.index("y"), label, photo, header=True)
    if len(cells) in {2, 3} and all(_is_number(cell) for cell in cells[-2:]):
        return _Columns(len(cells), len(cells) - 2, len(cells) - 1, len(cells) - 3)
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


def _points(table: Table, columns: _Columns, rows: Iterator[Row]) -> _Points:
    number = table.number_reader()
    width, x, y, line, photo = columns.width, columns.x, columns.y, columns.line, columns.photo
    points = _Points(array("d"), array("q"), {})
    block = index = 0
    for at, row in rows:
        cells = row if len(row) == width else _fitted(table.source, row, columns, at)
        try:
            pair = number(cells[x]), number(cells[y])
        except (ValueError, IndexError):
            if any(map(str.strip, row)):
                raise table.bad_number([cells[x], cells[y]], at) from None
            block += 1
            continue
        key = (
            cells[photo].strip() if photo >= 0 else "",
            cells[line].strip() if line >= 0 else block,
        )
        members = points.members.get(key)
        if members is None:
            if len(points.members) == MAX_PICKED_LINES:
                raise table.source.error(
                    f"more than {MAX_PICKED_LINES:,} lines",
                    at,
                    hint="give the picks of one photo or a few at a time",
                )
            members = points.members[key] = array("q")
        members.append(index)
        points.xy.extend(pair)
        points.rows.append(at)
        index += 1
    return points


def _fitted(source: Source, row: list[str], columns: _Columns, line: int) -> list[str]:
    """A row of another width than the first: only unneeded cells may lack or be blank."""
    needed = max(columns.x, columns.y, columns.line, columns.photo) + 1
    blank = not any(map(str.strip, row))
    if blank or (len(row) >= needed and not any(map(str.strip, row[columns.width :]))):
        return row
    raise source.error(
        f"the row has {len(row)} columns where {columns.width} belong",
        line,
        "where numbers have a decimal comma, part the columns by semicolons",
    )

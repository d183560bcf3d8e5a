"""Match points: where a point is seen in the photo, and where it lies on the plane.

Read are plain tables, `x,y,X,Y[,name[,sigma]]` or `x,y[,name]`, in all dialects of CSV:

    x,y,X,Y,name,sigma
    412.5,903.0,-1.52,6.10,A,0.01

QGIS's Georeferencer (`.points`; pixels from the corner of the photo, y negative):

    mapX,mapY,sourceX,sourceY,enable,dX,dY,residual
    -1.52,6.10,413.0,-903.5,1,0,0,0

and Global Mapper's table of control points (pixels from the corner of the photo):

    Name,Pixel X,Pixel Y,Ground X,Ground Y,Error
    A,413.0,903.5,-1.52,6.10,0.0

Columns that are not named here are left aside; points that QGIS has switched off too, and said so.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from plumbline.files import read_bytes
from plumbline.formats.base import Source, shown
from plumbline.formats.points.lines import clean_label
from plumbline.formats.points.table import Table
from plumbline.frame import Array
from plumbline.wording import count

MOST_POINTS = 300
"""Chosen, because the adjustment is dense: 300 points take seconds, and nobody measures more."""

_HINT = "give the columns x,y,X,Y,name: pixels in the photo, metres on the ground, and a name"
_EDGE_PX = 0.5
_LARGEST = 1e9
"""No map has larger coordinates, in metres or in pixels."""

_ALIASES = {
    "x": ("x", "px", "pixelx", "sourcex", "pixel x", "pixel_x", "image x", "col", "column"),
    "y": ("y", "py", "pixely", "sourcey", "pixel y", "pixel_y", "image y", "row"),
    "X": ("X", "mapx", "ground x", "ground_x", "east", "easting", "e", "map x"),
    "Y": ("Y", "mapy", "ground y", "ground_y", "north", "northing", "n", "map y"),
    "name": ("name", "id", "point", "label", "gcp name", "number"),
    "sigma": ("sigma", "σ", "sigma_m", "std"),
    "enable": ("enable",),
}


@dataclass(frozen=True)
class Matches:
    """Match points of one file.

    Attributes:
        path: The file.
        names: Their names, all different.
        picks_px: Pixels in the photo, shape (n, 2).
        places: On the plane as the file has it, shape (n, 2); NaN where there are none.
        sigmas: Standard error of a coordinate, shape (n,); NaN where it is not given.
        rows: Line of the file of each, shape (n,).
        notes: What was left aside or assumed.
        digest: SHA-256 of the file.
    """

    path: str
    names: tuple[str, ...]
    picks_px: Array
    places: Array
    sigmas: Array
    rows: tuple[int, ...]
    notes: tuple[str, ...] = ()
    digest: str = ""


@dataclass(frozen=True)
class _Point:
    name: str
    pick: tuple[float, float]
    place: tuple[float, float]
    sigma: float
    row: int


def read_matches(path: str) -> Matches:
    """Read match points.

    Raises:
        ReadError: the file is missing, damaged, holds no points, or too many.
    """
    from hashlib import sha256

    source = Source(path, read_bytes(path))
    table = Table.of(source)
    points, notes = _points(table)
    if not points:
        raise source.error("the file holds no match points", hint=_HINT)
    if len(points) > MOST_POINTS:
        raise source.error(
            f"the file holds {len(points):,} match points; at most {MOST_POINTS} are read",
            hint="leave out those that lie close to others",
        )
    _refuse_doubles(source, points)
    return Matches(
        path,
        tuple(point.name for point in points),
        np.array([point.pick for point in points]),
        np.array([point.place for point in points]),
        np.array([point.sigma for point in points]),
        tuple(point.row for point in points),
        notes,
        sha256(source.content).hexdigest(),
    )


def _points(table: Table) -> tuple[list[_Point], tuple[str, ...]]:
    number = table.number_reader()
    columns: dict[str, int] = {}
    points: list[_Point] = []
    off, shift, sign, notes = 0, 0.0, 1.0, list[str]()
    for row, cells in table.rows():
        values = [cell.strip() for cell in cells]
        if not any(values):
            continue
        if not columns:
            columns, header = _columns(table.source, values, row, number)
            if header:
                shift, sign, told = _convention(values)
                notes += told
                continue
        if "enable" in columns and _cell(values, columns, "enable") in ("0", "false", "False"):
            off += 1
            continue
        points.append(_point(table, values, columns, row, number, shift, sign, len(points) + 1))
    if off:
        notes.append(f"{count(off, 'point')} that QGIS has switched off {_were(off)} left out")
    return points, tuple(notes)


def _were(number: int) -> str:
    return "was" if number == 1 else "were"


def _columns(
    source: Source, cells: Sequence[str], row: int, number: Callable[[str], float]
) -> tuple[dict[str, int], bool]:
    """Where each column stands, and whether this row was a header."""
    if _all_numbers(cells[:2], number):
        rest = cells[2:]
        if len(rest) >= 2 and _all_numbers(rest[:2], number):
            names = ("x", "y", "X", "Y", "name", "sigma")
        else:
            names = ("x", "y", "name")
        if len(cells) > len(names):
            raise source.error(f"the row has {len(cells)} columns", row, _HINT)
        return {name: index for index, name in enumerate(names) if index < len(cells)}, False
    found: dict[str, int] = {}
    for index, cell in enumerate(cells):
        for name, aliases in _ALIASES.items():
            if cell in aliases or (len(cell) > 1 and cell.lower() in aliases):
                if name in found:
                    raise source.error(f"two columns are named {shown(cell)}", row, _HINT)
                found[name] = index
                break
    if not {"x", "y"} <= set(found):
        raise source.error("the first row names no columns x and y of the photo", row, _HINT)
    if ("X" in found) != ("Y" in found):
        raise source.error("only one of the columns X and Y is there", row, _HINT)
    return found, True


def _all_numbers(cells: Sequence[str], number: Callable[[str], float]) -> bool:
    try:
        return len(cells) > 0 and all(math.isfinite(number(cell)) for cell in cells)
    except ValueError:
        return False


def _convention(header: Sequence[str]) -> tuple[float, float, list[str]]:
    """What pixels are counted from: the shift to centres of pixels, and the sign of y."""
    names = {cell.lower() for cell in header}
    if "mapx" in names:
        return -_EDGE_PX, -1.0, []
    if "pixel x" in names:
        return -_EDGE_PX, 1.0, ["Global Mapper's pixels were counted from the photo's corner"]
    return 0.0, 1.0, []


def _point(
    table: Table,
    cells: Sequence[str],
    columns: dict[str, int],
    row: int,
    number: Callable[[str], float],
    shift: float,
    sign: float,
    ordinal: int,
) -> _Point:
    x, y = _numbers(table, cells, columns, ("x", "y"), row, number)
    place = (math.nan, math.nan)
    given = [_cell(cells, columns, name) for name in ("X", "Y")]
    if any(given):
        place = _numbers(table, cells, columns, ("X", "Y"), row, number)
    sigma = math.nan
    if _cell(cells, columns, "sigma"):
        (sigma,) = _numbers(table, cells, columns, ("sigma",), row, number)
        if not sigma > 0:
            raise table.source.error("a standard error must be above 0", row, "correct it")
    name = clean_label(_cell(cells, columns, "name")) or str(ordinal)
    return _Point(name, (x + shift, sign * y + shift), (place[0], place[1]), sigma, row)


def _numbers(
    table: Table,
    cells: Sequence[str],
    columns: dict[str, int],
    names: Sequence[str],
    row: int,
    number: Callable[[str], float],
) -> tuple[float, ...]:
    texts = [_cell(cells, columns, name) for name in names]
    try:
        values = tuple(number(text) for text in texts)
    except ValueError:
        raise table.bad_number(texts, row) from None
    if not all(map(math.isfinite, values)):
        raise table.bad_number(texts, row)
    if max(map(abs, values)) > _LARGEST:
        raise table.source.error("a coordinate is impossibly large", row, "correct it")
    return values


def _cell(cells: Sequence[str], columns: dict[str, int], name: str) -> str:
    index = columns.get(name, -1)
    return cells[index] if 0 <= index < len(cells) else ""


def _refuse_doubles(source: Source, points: Sequence[_Point]) -> None:
    """Refuse names, picks and places that stand there twice."""
    names: dict[str, int] = {}
    picks: dict[tuple[float, float], _Point] = {}
    places: dict[tuple[float, float], _Point] = {}
    for point in points:
        if point.name in names:
            raise source.error(
                f"two points are named {shown(point.name)} (the other in row {names[point.name]})",
                point.row,
                "give every point a name of its own",
            )
        names[point.name] = point.row
        for seen, key, what in ((picks, point.pick, "pick"), (places, point.place, "place")):
            if math.isnan(key[0]):
                continue
            if key in seen:
                other = seen[key]
                raise source.error(
                    f"{point.name} has the same {what} as {other.name} in row {other.row}",
                    point.row,
                    "correct or remove one of them",
                )
            seen[key] = point

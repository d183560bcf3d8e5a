"""Workbooks of Excel (.xlsx): a sheet that holds a table of points.

    | line | x    | y    |        as `plumbline.formats.points.csv` reads it
    | roof | 10.5 | 20.5 |

One sheet of the workbook holds the points; others are named in a note. Kept: as of a table.
Dropped: formats and formulas, of which the values stored by Excel are read. Source: ECMA-376;
decoded by the package openpyxl.
"""

from __future__ import annotations

import csv as writer
import io
import warnings
import zipfile
from dataclasses import replace

from plumbline.formats.base import ReadOptions, Source
from plumbline.formats.packed import BROKEN, MAX_UNPACKED, unpacked_size
from plumbline.formats.points import csv
from plumbline.observations import Observations
from plumbline.wording import listed

MAX_CELLS = 5_000_000
"""Chosen: a million picks with their names and photos."""
_MARK = b"xl/workbook.xml"


def recognises(source: Source) -> bool:
    """Whether the file is a zip that holds a workbook."""
    return source.content.startswith(b"PK\x03\x04") and _MARK in source.content[-65536:]


def read(source: Source, options: ReadOptions) -> Observations:
    """The points of the one sheet that holds some.

    Raises:
        ReadError: the workbook is broken, or no sheet or several hold points.
    """
    sheets = _sheets(source)
    tables = {name: replace(source, content=text, member=name) for name, text in sheets.items()}
    found = [table for table in tables.values() if csv.recognises(table)]
    if len(found) != 1:
        names = listed([table.member for table in found] or list(tables))
        many = f"{len(found)} sheets of the workbook hold" if found else "no sheet holds"
        raise source.error(
            f"{many} a table of points ({names})",
            hint="keep one sheet that starts with the row line, x, y, or save it as CSV",
        )
    observations = csv.read(found[0], options)
    others = [name for name in tables if name != found[0].member]
    note = (f"the sheets {listed(others)} of the workbook were ignored",) if others else ()
    return replace(observations, notes=(*observations.notes, *note))


def _sheets(source: Source) -> dict[str, bytes]:
    """The sheets of a workbook as CSV."""
    try:
        with zipfile.ZipFile(io.BytesIO(source.content)) as archive:
            if unpacked_size(source, archive) > MAX_UNPACKED:
                raise source.error("the workbook unpacks to more than 512 MiB")
            if any(b"<!ENTITY" in archive.read(name) for name in archive.namelist()):
                raise source.error("the workbook declares entities", hint="save it again")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return _decoded(source)
    except BROKEN:
        raise source.error("the workbook is broken", hint="save the sheet as CSV") from None


def _decoded(source: Source) -> dict[str, bytes]:
    from openpyxl import load_workbook

    workbook = load_workbook(io.BytesIO(source.content), read_only=True, data_only=True)
    cells = 0
    sheets: dict[str, bytes] = {}
    for sheet in workbook.worksheets:
        text = io.StringIO(newline="")
        rows = writer.writer(text, lineterminator="\n")
        for row in sheet.iter_rows(values_only=True):
            cells += len(row)
            if cells > MAX_CELLS:
                raise source.error(f"the workbook has more than {MAX_CELLS:,} cells")
            rows.writerow(["" if value is None else _one_line(value) for value in row])
        sheets[sheet.title] = text.getvalue().encode("utf-8", "replace")
    return sheets


def _one_line(value: object) -> str:
    if isinstance(value, float) and value.is_integer():
        return str(int(value))  # a spreadsheet's name 3 is not 3.0
    return " ".join(str(value).split())

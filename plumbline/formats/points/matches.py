"""Matched points of two pictures: a table of x, y in the original, X, Y in the corrected one.

    x,y,X,Y
    10.5,20.25,14.0,23.5

Commas, semicolons or tabs part the columns; the header stands first, in this order. Lines that
begin with # are left aside. Coordinates are pixels, (0, 0) the centre of the top-left pixel.
"""

from __future__ import annotations

import numpy as np

from plumbline.formats.base import Source
from plumbline.frame import Array

_HEADER = ["x", "y", "X", "Y"]
_HINT = "start with the row 'x,y,X,Y', then one row a match, such as '10.5,20.25,14,23.5'"
_MOST = 1_000_000
"""Chosen: SIFT finds some 10,000 matches in a large photo."""


def read_matches(source: Source) -> tuple[Array, Array]:
    """Matched points, shape (n, 2) each.

    Raises:
        ReadError: the text is not such a table.
    """
    rows: list[tuple[int, list[str]]] = []
    for number, text in enumerate(source.text().splitlines(), start=1):
        if text.strip() and not text.lstrip().startswith("#"):
            rows.append((number, [cell.strip() for cell in _split(text)]))
    if not rows or rows[0][1] != _HEADER:
        raise source.error("the columns are not x,y,X,Y", rows[0][0] if rows else None, _HINT)
    if len(rows) < 2 or len(rows) > _MOST:
        raise source.error(f"the table holds {len(rows) - 1:,} matches", hint=_HINT)
    values: list[list[float]] = []
    for number, cells in rows[1:]:
        if len(cells) != len(_HEADER):
            raise source.error(f"the row has {len(cells)} cells, not 4", number, _HINT)
        values.append([source.number(cell, number) for cell in cells])
    table = np.array(values)
    return table[:, :2], table[:, 2:]


def _split(text: str) -> list[str]:
    for sign in ("\t", ";"):
        if sign in text:
            return text.split(sign)
    return text.split(",")

"""All datasets of WebPlotDigitizer, exported to one CSV file.

    roof,,left wall,
    X,Y,X,Y
    10.5,20.5,5.25,7.75
    120,21,5.5,80
    231,22.5,,

One dataset is one line, in columns of its own; shorter ones end in empty cells. The image
must have been loaded with the axes "Image", so that values are pixels with y down.

WebPlotDigitizer counts from the corner of the first pixel: a click is the place on the canvas
over the zoom, and its blob detector adds 0.5 "to shift to the center of the pixels"
(`core/curve_detection/blobdetector.js`; `core/axes/image.js` passes pixels through). So 0.5
is subtracted here. Kept: names and coordinates. Dropped: nothing.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from plumbline.formats.base import ReadOptions, Source
from plumbline.formats.points.lines import LineGatherer
from plumbline.formats.points.table import Row, Table
from plumbline.observations import Observations

MAX_DATASETS = 10_000
"""Chosen: each is picked by hand."""
_HINT = "in WebPlotDigitizer use the axes 'Image' and export all datasets at once"


@dataclass
class _Dataset:
    name: str
    points: list[tuple[float, float]] = field(default_factory=list[tuple[float, float]])
    rows: list[int] = field(default_factory=list[int])


def read(source: Source, _options: ReadOptions) -> Observations:
    """One line a dataset.

    Raises:
        ReadError: the first rows are not names over X and Y, or a value is missing.
    """
    table = Table.of(source, comments=False)
    rows = (row for row in table.rows() if any(map(str.strip, row[1])))
    _, names = next(rows, (1, list[str]()))
    at, axes = next(rows, (2, list[str]()))
    datasets = _datasets(source, names, axes, at)
    _fill(table, datasets, rows)
    gatherer = LineGatherer(source, shift_px=-0.5)
    for dataset in datasets:
        if dataset.points:
            gatherer.add(np.array(dataset.points), dataset.name, rows=dataset.rows)
        else:
            gatherer.leave_aside("dataset without points")
    return gatherer.observations("datasets with points")


def recognises(source: Source) -> bool:
    """Whether names stand over every second column and X, Y, X, Y … below them."""
    rows = Table.opening(source, comments=False).first_rows(2)
    return len(rows) == 2 and any(rows[0]) and _is_axes(rows[1]) and _is_names(rows[0])


def _is_axes(cells: Sequence[str]) -> bool:
    """Whether the cells are X, Y, X, Y …, and blank ones after that."""
    named = [cell.strip().upper() for cell in cells]
    while named and not named[-1]:
        named.pop()
    return len(named) >= 2 and len(named) % 2 == 0 and named == ["X", "Y"] * (len(named) // 2)


def _is_names(cells: Sequence[str]) -> bool:
    """Whether each name stands over X alone, or over X and Y alike."""
    named = [cell.strip() for cell in cells]
    pairs = zip(named[::2], [*named[1::2], ""], strict=False)
    return all(second in {"", first} for first, second in pairs)


def _datasets(source: Source, names: list[str], axes: list[str], line: int) -> list[_Dataset]:
    if not _is_axes(axes):
        raise source.error("the second row is not X, Y, X, Y …", line, _HINT)
    number = sum(1 for cell in axes if cell.strip()) // 2
    if number > MAX_DATASETS:
        raise source.error(f"{number:,} datasets are more than are read", line, _HINT)
    if not _is_names(names) or any(map(str.strip, names[2 * number :])):
        raise source.error("the names of the first row do not stand over each X", 1, _HINT)
    titles = names[::2] + [""] * number
    return [_Dataset(title) for title in titles[:number]]


def _fill(table: Table, datasets: list[_Dataset], rows: Iterator[Row]) -> None:
    number = table.number_reader()
    for at, cells in rows:
        if any(map(str.strip, cells[2 * len(datasets) :])):
            raise table.source.error("the row has more columns than the header", at, _HINT)
        for dataset, x, y in zip(datasets, cells[::2], [*cells[1::2], ""], strict=False):
            if not x.strip() and not y.strip():
                continue
            try:
                dataset.points.append((number(x), number(y)))
            except ValueError:
                raise table.bad_number([x, y], at) from None
            dataset.rows.append(at)

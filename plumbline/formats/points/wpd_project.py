"""Projects of WebPlotDigitizer: `wpd.json`, alone or in the .tar with the photo.

    {"version": [4, 2], "datasetColl": [
      {"name": "roof", "data": [{"x": 10, "y": 40, "value": [10, 40]}]}]}

One dataset is one line. Every point has its place in the photo beside its value on the axes, so
that the axes do not matter. Kept: names and coordinates, of a .tar the photo. Dropped: axes,
values. As in the exported CSV, places count from the corner of the first pixel, so 0.5 is
subtracted here. Source: `core/plotData.js`, serialize; version 3 has `wpd.dataSeries`.
"""

from __future__ import annotations

from plumbline.formats.base import ReadOptions, Source
from plumbline.formats.jsontext import as_list, as_number, as_object, as_text, parsed
from plumbline.formats.points.lines import LineGatherer
from plumbline.observations import Observations


def read(source: Source, _options: ReadOptions) -> Observations:
    """One line a dataset.

    Raises:
        ReadError: the JSON is broken or not WebPlotDigitizer's.
    """
    top = as_object(source, parsed(source, source.text()), "the file")
    if "wpd" in top:
        top = as_object(source, top["wpd"], "'wpd'")
    every = top.get("datasetColl", top.get("dataSeries"))
    gatherer = LineGatherer(source, shift_px=-0.5)
    for number, value in enumerate(as_list(source, every, "'datasetColl'")):
        where = f"dataset {number + 1}"
        dataset = as_object(source, value, where)
        points: list[tuple[float, float]] = []
        for each in as_list(source, dataset.get("data", []), f"the data of {where}"):
            point = as_object(source, each, f"a point of {where}")
            x, y = (as_number(source, point.get(axis), f"a point of {where}") for axis in "xy")
            points.append((x, y))
        if points:
            gatherer.add(points, as_text(dataset.get("name")))
        else:
            gatherer.leave_aside("dataset without points")
    return gatherer.observations("datasets with points")


def recognises(source: Source) -> bool:
    """Whether the file is JSON with WebPlotDigitizer's datasets."""
    content = source.content
    return source.head.lstrip().startswith("{") and (
        b'"datasetColl"' in content or b'"dataSeries"' in content
    )

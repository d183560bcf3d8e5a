"""Annotations in Datumaro's JSON, as CVAT and the program datum export them.

    {"categories": {"label": {"labels": [{"name": "roof"}]}},
     "items": [{"id": "wall", "image": {"path": "wall.jpg", "size": [1536, 2048]},
                "annotations": [{"type": "polyline", "label_id": 0,
                                 "points": [10.5, 20.5, 120, 21]}]}]}

Every polyline, and every set of three points or more, is one line; fewer points that share a
label are one line. Kept: labels, coordinates, names and sizes of the photos (height first).
Dropped: other annotations (a note says which). Coordinates are CVAT's, from the corner of the
first pixel, so 0.5 is subtracted here. Source: `datumaro/plugins/data_formats/datumaro`.
"""

from __future__ import annotations

from plumbline.formats.base import ReadOptions, Source
from plumbline.formats.jsontext import (
    Object,
    as_list,
    as_number,
    as_object,
    as_text,
    listed_names,
    pairs,
    parsed,
)
from plumbline.formats.points.lines import FEWEST, LineGatherer, Size, declared_size
from plumbline.observations import Observations


def read(source: Source, _options: ReadOptions) -> Observations:
    """Polylines and points of a Datumaro file.

    Raises:
        ReadError: the JSON is broken or not Datumaro's.
    """
    top = as_object(source, parsed(source, source.text()), "the file")
    names = _names(source, top)
    gatherer = LineGatherer(source, shift_px=-0.5)
    for number, value in enumerate(as_list(source, top.get("items"), "'items'")):
        item = as_object(source, value, f"items[{number}]")
        image = item.get("image")
        image = image if isinstance(image, dict) else {}
        name = as_text(image.get("path")) or as_text(item.get("id"))
        size = _size(source, image.get("size"))
        for each in as_list(source, item.get("annotations", []), f"items[{number}].annotations"):
            shape = as_object(source, each, "an annotation")
            kind = as_text(shape.get("type"))
            if kind not in {"polyline", "points"}:
                gatherer.leave_aside(kind)
                continue
            points = pairs(source, shape.get("points"), f"points of items[{number}]")
            label = names.get(as_text(shape.get("label_id")), "")
            if kind == "polyline" or len(points) >= FEWEST:
                gatherer.add(points, label, photo=number, photo_name=name, size=size)
            else:
                group = as_text(shape.get("group")).strip("0") or None
                gatherer.pick(points, label, group=group, photo=number, photo_name=name, size=size)
    return gatherer.observations("polylines and points")


def recognises(source: Source) -> bool:
    """Whether the file is a JSON object with items that have annotations."""
    content = source.content
    return (
        source.head.lstrip().startswith("{")
        and b'"items"' in content
        and b'"annotations"' in content
        and b'"label_id"' in content
    )


def _names(source: Source, top: Object) -> dict[str, str]:
    categories = top.get("categories")
    labels = categories.get("label") if isinstance(categories, dict) else None
    return listed_names(source, labels.get("labels") if isinstance(labels, dict) else None)


def _size(source: Source, value: object) -> Size | None:
    if value is None:
        return None
    sides = [as_number(source, side, "'size'") for side in as_list(source, value, "'size'")]
    if len(sides) != 2:
        raise source.error("'size' is not a height and a width", hint="export the file again")
    return declared_size(source, sides[1], sides[0])

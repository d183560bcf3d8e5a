"""Annotations of labelme: one JSON file beside each photo.

    {"shapes": [{"label": "l1", "points": [[10.5, 20.5], [120, 21]],
                 "shape_type": "linestrip"}],
     "imagePath": "wall.jpg", "imageHeight": 1536, "imageWidth": 2048}

Every shape of type linestrip, line or points is one line; a label that occurs twice makes two
lines. Shapes of type point that share a label and `group_id` are one line. Kept: labels,
coordinates, the photo's name and size. Dropped: other shapes (a note says which), flags, the
embedded photo.

labelme draws on a canvas where (0, 0) is the corner of the first pixel and keeps the place of
the mouse over the zoom (`labelme/widgets/canvas.py`, transformPos; its issue 1226 has
coordinates run from 0 to the width), so 0.5 is subtracted here.
"""

from __future__ import annotations

from plumbline.formats.base import ReadOptions, Source
from plumbline.formats.jsontext import as_list, as_number, as_object, as_text, parsed
from plumbline.formats.points.lines import LineGatherer, Size, declared_size
from plumbline.observations import Observations

_READ = {"linestrip", "line", "points", "point"}


def read(source: Source, _options: ReadOptions) -> Observations:
    """Lines of one labelme file.

    Raises:
        ReadError: the JSON is broken or not labelme's.
    """
    top = as_object(source, parsed(source, source.text()), "the file")
    shapes = as_list(source, top.get("shapes"), "'shapes'")
    name = as_text(top.get("imagePath"))
    size = _size(source, top.get("imageWidth"), top.get("imageHeight"))
    gatherer = LineGatherer(source, shift_px=-0.5)
    for number, value in enumerate(shapes, start=1):
        shape = as_object(source, value, f"shape {number}")
        # labelme itself takes a shape without a type for a polygon.
        kind = as_text(shape.get("shape_type")) or "polygon"
        if kind not in _READ:
            gatherer.leave_aside(kind)
            continue
        points = _points(source, shape.get("points"), f"shape {number}")
        label = as_text(shape.get("label"))
        if kind == "point":
            group = as_text(shape.get("group_id"))
            key = (label, group) if group else None
            gatherer.pick(points, label, group=key, photo_name=name, size=size)
        else:
            gatherer.add(points, label, photo_name=name, size=size)
    return gatherer.observations("linestrip, line, points and point")


def recognises(source: Source) -> bool:
    """Whether the file is a JSON object with shapes that are not VIA's."""
    content = source.content
    return (
        source.head.lstrip().startswith("{")
        and b'"shapes"' in content
        and b"_via_img_metadata" not in content
    )


def _size(source: Source, width: object, height: object) -> Size | None:
    if width is None or height is None:
        return None
    numbers = (
        as_number(source, width, "'imageWidth'"),
        as_number(source, height, "'imageHeight'"),
    )
    return declared_size(source, *numbers)


def _points(source: Source, value: object, what: str) -> list[tuple[float, float]]:
    points: list[tuple[float, float]] = []
    for number, pair in enumerate(as_list(source, value, f"'points' of {what}"), start=1):
        point = f"point {number} of {what}"
        xy = as_list(source, pair, point)
        if len(xy) != 2:
            raise source.error(f"{point} has {len(xy)} coordinates", hint="correct or remove it")
        points.append((as_number(source, xy[0], point), as_number(source, xy[1], point)))
    return points

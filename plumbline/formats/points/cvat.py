"""Annotations of CVAT, exported as "CVAT for images 1.1" (annotations.xml).

    <annotations>
      <version>1.1</version>
      <image id="0" name="wall.jpg" width="2048" height="1536">
        <polyline label="l1" source="manual" points="527.11,207.00;593.38,182.53"/>
      </image>
    </annotations>

Every polyline, and every points shape of three clicks or more, is one line; a label is a class
name, so that one which occurs twice makes two lines. Points of fewer clicks that share a group or
else a label are one line. The download of a task is a zip, which is read as it is. Kept: labels,
coordinates, names and sizes of the photos. Dropped: other shapes (a note says which), attributes,
tags, photos without them.

CVAT draws in SVG over the photo, where (0, 0) is the corner of the first pixel and the last
corner is (width, height) (its issue 9973 shows a point dragged to 1920,1080 of a 1920x1080
photo), so 0.5 is subtracted here.
"""

from __future__ import annotations

import re

from plumbline.formats.base import ReadOptions, Source
from plumbline.formats.points.lines import FEWEST, LineGatherer, Size, declared_size
from plumbline.formats.xmltext import Element, parsed, row_of
from plumbline.observations import Observations

_FIRST = re.compile(r"<annotations[\s>]")


def read(source: Source, _options: ReadOptions) -> Observations:
    """Polylines of a CVAT export.

    Raises:
        ReadError: the XML is broken, declares entities, or is not CVAT's.
    """
    root = parsed(source)
    if root.tag != "annotations":
        raise source.error(
            "the XML is not CVAT's: its first element is not <annotations>",
            hint="export the picks as CVAT for images 1.1",
        )
    if root.find("track") is not None:
        raise source.error(
            "the file was exported for video",
            hint="export the task as 'CVAT for images 1.1'",
        )
    gatherer = LineGatherer(source, shift_px=-0.5)
    for number, image in enumerate(root.findall("image"), start=1):
        size = _size(source, image)
        for shape in image:
            label, row = shape.get("label", ""), row_of(shape)
            name = image.get("name", "")
            if shape.tag not in {"polyline", "points"}:
                if shape.tag != "tag":
                    gatherer.leave_aside(str(shape.tag))
                continue
            points = _points(source, shape)
            if shape.tag == "polyline" or len(points) >= FEWEST:
                gatherer.add(points, label, photo=number, photo_name=name, size=size, rows=row)
            else:
                group = shape.get("group_id", "") or None
                gatherer.pick(
                    points, label, group=group, photo=number, photo_name=name, size=size, row=row
                )
    return gatherer.observations("polylines and points")


def recognises(source: Source) -> bool:
    """Whether the XML starts with <annotations>."""
    return source.head.lstrip().startswith("<") and _FIRST.search(source.head) is not None


def _size(source: Source, image: Element) -> Size | None:
    width, height = image.get("width", ""), image.get("height", "")
    if not width or not height:
        return None
    at = row_of(image)
    return declared_size(
        source,
        source.number(width, at, what="the width"),
        source.number(height, at, what="the height"),
        at,
    )


def _points(source: Source, shape: Element) -> list[tuple[float, float]]:
    at = row_of(shape)
    points: list[tuple[float, float]] = []
    for pair in shape.get("points", "").split(";"):
        if not pair.strip():
            continue
        x, _, y = pair.partition(",")
        points.append((source.number(x, at), source.number(y, at)))
    return points

"""Keypoints in COCO's JSON: one annotation is one line.

    {"images": [{"id": 1, "file_name": "wall.jpg", "width": 800, "height": 600}],
     "categories": [{"id": 7, "name": "edge"}],
     "annotations": [{"image_id": 1, "category_id": 7, "keypoints": [10, 40, 2, 200, 28, 2]}]}

Keypoints are x, y and v; those with v = 0 are not labelled and left out. Kept: names of
categories, coordinates, names and sizes of the photos. Dropped: boxes and areas (a note says so).
COCO's point (0, 0) is the corner of the first pixel ("0-indexed", and its own tools add 0.5 to a
pixel's number), so 0.5 is subtracted here. Source: cocodataset.org, "Data format".
"""

from __future__ import annotations

from plumbline.formats.base import ReadOptions, Source
from plumbline.formats.jsontext import (
    Object,
    as_list,
    as_number,
    as_object,
    as_text,
    parsed,
)
from plumbline.formats.points.lines import LineGatherer, Size, declared_size
from plumbline.observations import Observations


def read(source: Source, _options: ReadOptions) -> Observations:
    """Annotations with keypoints of a COCO file.

    Raises:
        ReadError: the JSON is broken or not COCO's.
    """
    top = as_object(source, parsed(source, source.text()), "the file")
    images = _by_id(source, top, "images")
    names = {
        key: as_text(each.get("name")) for key, each in _by_id(source, top, "categories").items()
    }
    gatherer = LineGatherer(source, shift_px=-0.5)
    for number, value in enumerate(as_list(source, top.get("annotations"), "'annotations'")):
        where = f"annotations[{number}]"
        shape = as_object(source, value, where)
        if "keypoints" not in shape:
            gatherer.leave_aside("annotation without keypoints")
            continue
        photo = as_text(shape.get("image_id"))
        image = images.get(photo, {})
        gatherer.add(
            _points(source, shape["keypoints"], f"{where}.keypoints"),
            names.get(as_text(shape.get("category_id")), ""),
            photo=photo,
            photo_name=as_text(image.get("file_name")),
            size=_size(source, image),
        )
    return gatherer.observations("annotations with keypoints")


def recognises(source: Source) -> bool:
    """Whether the file is a JSON object with keypoints of images."""
    content = source.content
    return (
        source.head.lstrip().startswith("{")
        and b'"annotations"' in content
        and b'"image_id"' in content
        and b'"keypoints"' in content
    )


def _by_id(source: Source, top: Object, name: str) -> dict[str, Object]:
    every = [
        as_object(source, each, f"one of '{name}'")
        for each in as_list(source, top.get(name, []), f"'{name}'")
    ]
    return {as_text(each.get("id")): each for each in every}


def _size(source: Source, image: Object) -> Size | None:
    if "width" not in image or "height" not in image:
        return None
    return declared_size(
        source,
        as_number(source, image["width"], "'width'"),
        as_number(source, image["height"], "'height'"),
    )


def _points(source: Source, value: object, where: str) -> list[tuple[float, float]]:
    numbers = [as_number(source, number, where) for number in as_list(source, value, where)]
    if len(numbers) % 3:
        raise source.error(f"{where} does not hold x, y and v in turn", hint="export it again")
    triples = zip(numbers[::3], numbers[1::3], numbers[2::3], strict=True)
    return [(x, y) for x, y, visible in triples if visible]

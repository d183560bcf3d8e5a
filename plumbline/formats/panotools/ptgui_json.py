"""Projects of PTGui 11 and newer: JSON, read only.

    {"contenttype": "com.ptgui.project_pro", "project": {
      "imagegroups": [{"size": [800, 600], "images": [{"filename": "a.jpg"}]}],
      "controlpoints": [{"t": 3, "0": [0, 0, 10, 40], "1": [0, 0, 790, 41]}]}}

Control points name the group and the image of both ends before x and y; of the type `t` 3 and
above those of one image make a line, one number a line. Kept: names and sizes of the photos,
points. Dropped: the lens values, other control points (a note counts them). Coordinates are taken
as Panorama Tools', which are plumbline's own. Source: projects of PTGui 11 and 12.
"""

from __future__ import annotations

import numpy as np

from plumbline.formats.base import Source
from plumbline.formats.jsontext import as_list, as_number, as_object, as_text, parsed
from plumbline.formats.panotools.control_points import collect_lines
from plumbline.formats.panotools.point_records import ControlPoints
from plumbline.formats.points.lines import clean_label, declared_size
from plumbline.observations import Observations, Photo

_MARK = b'"com.ptgui.'
_LARGEST_TYPE = 10**9
"""Chosen: line types are small numbers; a larger one is damage."""


def is_json(source: Source) -> bool:
    """Whether the file is a project of PTGui 11 or newer."""
    return source.head.lstrip().startswith("{") and (
        _MARK in source.content or source.suffix == ".pts"
    )


def read_json(source: Source) -> Observations:
    """Straight lines of a project in JSON.

    Raises:
        ReadError: the JSON is damaged, or there is no straight line.
    """
    top = as_object(source, parsed(source, source.text()), "the file")
    project = as_object(source, top.get("project"), "'project'")
    photos, first_of_group = _photos(source, project.get("imagegroups"))
    points = _points(source, project.get("controlpoints", []), first_of_group, len(photos))
    notes: list[str] = []
    lines = collect_lines(source, points, len(photos), notes)
    return Observations(tuple(photos), lines, notes=tuple(notes))


def _photos(source: Source, value: object) -> tuple[list[Photo], list[int]]:
    """The photos, and the number of the first one of each group."""
    photos: list[Photo] = []
    first: list[int] = []
    for number, each in enumerate(as_list(source, value, "'imagegroups'")):
        group = as_object(source, each, f"imagegroups[{number}]")
        sides = as_list(source, group.get("size"), f"imagegroups[{number}].size")
        numbers = [as_number(source, side, f"imagegroups[{number}].size") for side in sides]
        if len(numbers) != 2:
            raise source.error(f"imagegroups[{number}].size is not a width and a height")
        size = declared_size(source, numbers[0], numbers[1])
        first.append(len(photos))
        for image in as_list(source, group.get("images"), f"imagegroups[{number}].images"):
            name = as_text(as_object(source, image, "an image").get("filename"))
            photos.append(Photo(size, clean_label(name)))
    if not photos:
        raise source.error("there is no image in this project", hint="add the photo in PTGui")
    return photos, first


def _points(source: Source, value: object, first: list[int], photos: int) -> ControlPoints:
    rows: list[list[float]] = []
    for number, each in enumerate(as_list(source, value, "'controlpoints'")):
        where = f"controlpoints[{number}]"
        point = as_object(source, each, where)
        kind = as_number(source, point.get("t", 0), f"{where}.t")
        ends = [
            [as_number(source, part, where) for part in as_list(source, point.get(name), where)]
            for name in ("0", "1")
        ]
        if any(len(end) != 4 for end in ends) or not 0 <= kind < _LARGEST_TYPE:
            raise source.error(
                f"{where} does not hold a group, an image, x and y at either end",
                hint="save the project again in PTGui",
            )
        images = [_image(source, end, first, photos, where) for end in ends]
        rows.append([*images, *ends[0][2:], *ends[1][2:], int(kind)])
    table = np.array(rows, dtype=np.float64).reshape(-1, 7)
    numbers = np.arange(1, len(table) + 1)
    images, kinds = table[:, :2].astype(np.int64), table[:, 6].astype(np.int64)
    return ControlPoints(images, table[:, 2:6], kinds, numbers)


def _image(source: Source, end: list[float], first: list[int], photos: int, where: str) -> int:
    group, image = end[:2]
    whole = group == int(group) and image == int(image)
    if whole and 0 <= group < len(first):
        ends = [*first[1:], photos]
        number = first[int(group)] + int(image)
        if first[int(group)] <= number < ends[int(group)]:
            return number
    raise source.error(
        f"{where} refers to an image that is not in the project",
        hint="remove this control point, or put the image back",
    )

"""Annotations of the VGG Image Annotator, version 3: CSV or project (JSON).

    # CSV_HEADER = metadata_id,file_list,flags,temporal_coordinates,spatial_coordinates,metadata
    # SHAPE_ID = {"POINT":1,"RECT":2,"CIRCLE":3,"ELLIPSE":4,"LINE":5,"POLYLINE":6,"POLYGON":7}
    "1_a","[""wall.jpg""]",0,"[]","[6,10,40,200,28]","{""1"":""roof""}"

    {"file": {"1": {"fid": "1", "fname": "wall.jpg"}},
     "view": {"1": {"fid_list": ["1"]}},
     "metadata": {"1_a": {"vid": "1", "xy": [6, 10, 40, 200, 28], "av": {"1": "roof"}}}}

The first number of a region is its shape. Polylines and lines are one line each, points of one
label are one line. Kept: the first attribute as label, coordinates, file names. Dropped: other
shapes (a note says which). Coordinates are as in version 2, so 0.5 is subtracted here. Source:
`via-3.x.y/_via_import_export.js` and `_via_metadata.js`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from plumbline.formats.base import ReadOptions, Source
from plumbline.formats.jsontext import as_list, as_number, as_object, as_text, parsed
from plumbline.formats.points.lines import LineGatherer
from plumbline.formats.points.table import Table
from plumbline.observations import Observations

_SHAPES = (
    "point", "rectangle", "circle", "ellipse", "line", "polyline", "polygon",
    "extreme rectangle", "extreme circle",
)  # fmt: skip
_HEADER = re.compile(r"^# CSV_HEADER = ([\w,]+)", re.MULTILINE)
_COLUMNS = "metadata_id,file_list,flags,temporal_coordinates,spatial_coordinates,metadata"
_Region = tuple[str, object, object, int | None]


def read(source: Source, _options: ReadOptions) -> Observations:
    """Polylines, lines and points of a VIA 3 file.

    Raises:
        ReadError: the file is broken or not VIA's.
    """
    is_json = source.head.lstrip().startswith("{")
    gatherer = LineGatherer(source, shift_px=-0.5)
    for name, spatial, attributes, row in _of_project(source) if is_json else _of_table(source):
        numbers = [
            as_number(source, number, "a coordinate", row)
            for number in as_list(source, spatial, "the coordinates", row)
        ]
        if not numbers:
            continue  # an attribute of the whole photo
        shape = int(numbers[0]) - 1
        kind = _SHAPES[shape] if 0 <= shape < len(_SHAPES) else "unknown shape"
        if kind not in {"point", "line", "polyline"}:
            gatherer.leave_aside(kind)
            continue
        if len(numbers) % 2 == 0:
            raise source.error(
                "a region has an x without a y", row, "export the annotations from VIA again"
            )
        points = list(zip(numbers[1::2], numbers[2::2], strict=True))
        values = attributes.values() if isinstance(attributes, dict) else ()
        label = next(filter(None, map(as_text, values)), "")
        if kind == "point":
            gatherer.pick(points, label, photo=name, photo_name=name, row=row)
        else:
            gatherer.add(points, label, photo=name, photo_name=name, rows=row)
    return gatherer.observations("polylines, lines and points")


def recognises(source: Source) -> bool:
    """Whether the file has VIA 3's header, or is JSON with its metadata."""
    head = source.head.lstrip("\ufeff \r\n\t")
    if head.startswith("{"):
        content = source.content
        return b'"metadata"' in content and b'"fid_list"' in content and b'"fname"' in content
    found = _HEADER.search(head)
    return found is not None and "spatial_coordinates" in found[1]


def _of_project(source: Source) -> Iterator[_Region]:
    top = as_object(source, parsed(source, source.text()), "the file")
    files = as_object(source, top.get("file", {}), "'file'")
    views = as_object(source, top.get("view", {}), "'view'")
    for value in as_object(source, top.get("metadata", {}), "'metadata'").values():
        region = as_object(source, value, "one of 'metadata'")
        view = views.get(as_text(region.get("vid")))
        ids = view.get("fid_list") if isinstance(view, dict) else None
        file = files.get(as_text(ids[0])) if isinstance(ids, list) and ids else None
        name = as_text(file.get("fname")) if isinstance(file, dict) else ""
        yield name, region.get("xy", []), region.get("av"), None


def _of_table(source: Source) -> Iterator[_Region]:
    found = _HEADER.search(source.head)
    names = (found[1] if found else _COLUMNS).split(",")
    if not {"file_list", "spatial_coordinates"} <= set(names):
        raise source.error(
            "the columns file_list and spatial_coordinates are missing",
            hint="export the annotations from VIA again, as CSV",
        )
    for at, row in Table(source, source.text(), ",").rows():
        if not any(map(str.strip, row)):
            continue
        cells = dict(zip(names, row, strict=False))
        files = parsed(source, cells.get("file_list", "") or "[]", at)
        spatial = parsed(source, cells.get("spatial_coordinates", "") or "[]", at)
        attributes = parsed(source, cells.get("metadata", "") or "{}", at)
        name = as_text(files[0]) if isinstance(files, list) and files else ""
        yield name, spatial, attributes, at

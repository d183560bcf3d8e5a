"""Annotations of the VGG Image Annotator (VIA), versions 1 and 2: CSV or JSON.

    filename,file_size,file_attributes,region_count,region_id,region_shape_attributes,region_attributes
    a.jpg,9821,"{}",1,0,"{""name"":""polyline"",""all_points_x"":[10,120],""all_points_y"":[20,21]}","{}"

    {"_via_img_metadata": {"a.jpg9821": {"filename": "a.jpg", "size": 9821, "regions": [
        {"shape_attributes": {"name": "polyline", "all_points_x": [10, 120],
                              "all_points_y": [20, 21]},
         "region_attributes": {"line": "roof"}}]}}}

The JSON may also be the object of images alone, and `regions` an object by number (version 1).
Every polyline is one line, points that share a label are one line, every file name a photo of the
one lens; the label is the region's attribute line, label or name, or its only one. Kept: labels,
coordinates, file names. Dropped: other shapes (a note says which), other attributes. The size of
the photo is not in the file: VIA's `size` counts bytes.

VIA draws on a canvas where (0, 0) is the corner of the first pixel and rounds the place of
the mouse times the scale to whole numbers (`via-2.x.y/via.js`), so 0.5 is subtracted here.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from plumbline.errors import ReadError
from plumbline.formats.base import ReadOptions, Source
from plumbline.formats.jsontext import (
    Object,
    as_list,
    as_number,
    as_object,
    as_text,
    parsed,
)
from plumbline.formats.points.lines import LineGatherer
from plumbline.formats.points.table import Table
from plumbline.observations import Observations

_LABELS = ("line", "label", "name")
_UNDEFINED = re.compile(r"(?<=:)\s*undefined(?=\s*[,}])")
_SHAPE, _REGION = "region_shape_attributes", "region_attributes"


@dataclass(frozen=True)
class _Region:
    """One region: its photo, its shape, and where it stands in a CSV file."""

    photo: tuple[str, str]
    shape: Object
    attributes: object
    line: int | None = None


def read(source: Source, _options: ReadOptions) -> Observations:
    """Polylines of a VIA file.

    Raises:
        ReadError: the file is broken or not VIA's.
    """
    is_json = source.head.lstrip().startswith("{")
    gatherer = LineGatherer(source, shift_px=-0.5)
    for region in _regions_of_json(source) if is_json else _regions_of_table(source):
        kind = as_text(region.shape.get("name"))
        if kind == "point":
            point = [_number(source, region, key) for key in ("cx", "cy")]
            label, name = _label(region.attributes), region.photo[0]
            gatherer.pick(point, label, photo=region.photo, photo_name=name, row=region.line)
            continue
        if kind != "polyline":
            gatherer.leave_aside(kind)
            continue
        gatherer.add(
            _points(source, region),
            _label(region.attributes),
            photo=region.photo,
            photo_name=region.photo[0],
            rows=region.line,
        )
    return gatherer.observations("polylines and points")


def recognises(source: Source) -> bool:
    """Whether the file has VIA's CSV header, or is JSON with VIA's regions."""
    head = source.head.lstrip("#\ufeff \r\n\t")
    if head.startswith("{"):
        content = source.content
        return b'"_via_img_metadata"' in content or (
            b'"regions"' in content and b'"shape_attributes"' in content
        )
    first = head.partition("\n")[0]
    return first.startswith(("filename", '"filename"')) and _SHAPE in first


def _regions_of_json(source: Source) -> Iterator[_Region]:
    top = as_object(source, parsed(source, _defined(source.text())), "the file")
    images = as_object(source, top.get("_via_img_metadata", top), "the list of images")
    for key, value in images.items():
        image = as_object(source, value, "an image")
        regions = image.get("regions", [])
        listed = (
            list(as_object(source, regions, "'regions'").values())
            if isinstance(regions, dict)
            else as_list(source, regions, "'regions'")
        )
        photo = (as_text(image.get("filename")), key)
        for entry in listed:
            region = as_object(source, entry, "a region")
            shape = as_object(source, region.get("shape_attributes"), "'shape_attributes'")
            yield _Region(photo, shape, region.get("region_attributes"))


def _regions_of_table(source: Source) -> Iterator[_Region]:
    table = Table.of(source, comments=False)
    header: list[str] = []
    for at, row in table.rows():
        if not any(map(str.strip, row)):
            continue
        if not header:
            header = [cell.strip().lstrip("#").strip() for cell in row]
            if not {"filename", _SHAPE} <= set(header):
                raise source.error(
                    f"the columns filename and {_SHAPE} are missing",
                    at,
                    hint="export the annotations from VIA again, as CSV or JSON",
                )
            continue
        cells = dict(zip(header, row, strict=False))
        text = cells.get(_SHAPE, "").strip()
        if text in {"", "{}"}:
            continue  # a photo without regions
        shape = as_object(source, parsed(source, text, at), _SHAPE, at)
        attributes = _attributes(source, cells.get(_REGION, ""), at)
        photo = (cells.get("filename", "").strip(), cells.get("file_size", ""))
        yield _Region(photo, shape, attributes, at)


def _attributes(source: Source, text: str, line: int) -> object:
    """The attributes of a region, of which only the label is wanted: broken ones cost no more."""
    try:
        return parsed(source, _defined(text.strip() or "{}"), line)
    except ReadError:
        return None


def _defined(text: str) -> str:
    """JSON in which VIA wrote the attributes that were never set as `undefined`."""
    return _UNDEFINED.sub("null", text)


def _number(source: Source, region: _Region, key: str) -> float:
    return as_number(source, region.shape.get(key), f"'{key}'", region.line)


def _label(attributes: object) -> str:
    """The name of a region, as far as it has one."""
    named = attributes if isinstance(attributes, dict) else {}
    texts = {str(key).lower(): as_text(value) for key, value in named.items()}
    found = next((texts[key] for key in _LABELS if texts.get(key)), "")
    return found or (next(iter(texts.values())) if len(texts) == 1 else "")


def _points(source: Source, region: _Region) -> list[tuple[float, float]]:
    x, y = (
        [
            as_number(source, value, "a coordinate", region.line)
            for value in as_list(source, region.shape.get(key), f"'{key}'", region.line)
        ]
        for key in ("all_points_x", "all_points_y")
    )
    if len(x) != len(y):
        raise source.error(
            f"a polyline has {len(x)} x and {len(y)} y",
            region.line,
            hint="export the annotations from VIA again, as CSV or JSON",
        )
    return list(zip(x, y, strict=True))

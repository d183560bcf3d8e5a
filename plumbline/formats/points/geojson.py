"""Lines in GeoJSON, as QuPath and QGIS export them.

    {"type": "FeatureCollection", "features": [
      {"type": "Feature", "properties": {"classification": {"name": "roof"}},
       "geometry": {"type": "LineString", "coordinates": [[10.5, 20.5], [120, 21]]}}]}

Every LineString, part of a MultiLineString and MultiPoint is one line; Points of one name are one
line. The name is that of the feature or of its classification. Kept: names and coordinates.
Dropped: areas (a note says so), other properties. QuPath counts from the corner of the first
pixel, so 0.5 is subtracted here. QGIS lays a photo that has no place on the map below its first
axis, with y < 0: there the sign is changed, and a note says so. Source: RFC 7946; QuPath's
`qupath/lib/io/GsonTools.java`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from plumbline.formats.base import ReadOptions, Source
from plumbline.formats.jsontext import as_list, as_number, as_object, as_text, parsed
from plumbline.formats.points.lines import LineGatherer
from plumbline.observations import Observations

_KINDS = {"LineString": 1, "MultiPoint": 1, "MultiLineString": 2, "Point": 0}
"""What is read, and how deep its coordinates nest."""


def read(source: Source, _options: ReadOptions) -> Observations:
    """Lines and points of a GeoJSON file.

    Raises:
        ReadError: the JSON is broken or not GeoJSON.
    """
    gatherer = LineGatherer(source)
    for number, feature in enumerate(_features(source)):
        where = f"feature {number + 1}"
        value = feature.get("geometry", feature)
        if value is None:
            continue
        geometry = as_object(source, value, f"the geometry of {where}")
        kind = as_text(geometry.get("type"))
        if kind not in _KINDS:
            gatherer.leave_aside(kind)
            continue
        label = _name(feature.get("properties"))
        coordinates = geometry.get("coordinates")
        if kind == "Point":
            gatherer.pick(_points(source, [coordinates], where), label)
            continue
        parts = as_list(source, coordinates, where) if _KINDS[kind] == 2 else [coordinates]
        for part in parts:
            gatherer.add(_points(source, part, where), label)
    return _from_corners(gatherer.observations("LineStrings and points"))


def recognises(source: Source) -> bool:
    """Whether the file is JSON with the geometries of GeoJSON."""
    content = source.content
    return (
        source.head.lstrip().startswith(("{", "["))
        and b'"coordinates"' in content
        and (b'"geometry"' in content or b'"Feature' in content)
    )


def _features(source: Source) -> Iterator[dict[str, object]]:
    top = parsed(source, source.text())
    if isinstance(top, dict) and "features" in top:
        top = top["features"]
    every = as_list(source, top, "'features'") if not isinstance(top, dict) else [top]
    for number, value in enumerate(every):
        yield as_object(source, value, f"feature {number + 1}")


def _name(value: object) -> str:
    properties = value if isinstance(value, dict) else {}
    kind = properties.get("classification")
    kind = kind.get("name") if isinstance(kind, dict) else kind
    for name in (properties.get("line"), properties.get("name"), kind, properties.get("id")):
        if as_text(name):
            return as_text(name)
    return ""


def _points(source: Source, value: object, where: str) -> list[tuple[float, float]]:
    points: list[tuple[float, float]] = []
    for place in as_list(source, value, f"the coordinates of {where}"):
        xy = as_list(source, place, f"a point of {where}")
        if len(xy) < 2:
            raise source.error(f"a point of {where} has no y", hint="export the file again")
        x, y = (as_number(source, each, f"a point of {where}") for each in xy[:2])
        points.append((x, y))
    return points


def _from_corners(observations: Observations) -> Observations:
    """The points counted from the centre of the first pixel, y down."""
    y = np.concatenate([line.points_px[:, 1] for line in observations.lines])
    upwards = bool(y.size and y.max() <= 0 and y.min() < -1)
    scale = np.array([1.0, -1.0 if upwards else 1.0])
    lines = tuple(
        replace(line, points_px=line.points_px * scale - 0.5) for line in observations.lines
    )
    note = ("y runs upwards from the photo's top, as in QGIS, and was turned",) * upwards
    return replace(observations, lines=lines, notes=(*observations.notes, *note))

"""Plumbline's own JSON of picked points, and the points that the JSON of a result holds.

    {"format": "plumbline points", "format_version": 1, "plumbline": "1.2.3",
     "observations": {
       "lenses": [{"maker": "", "focal_mm": 9.2, …}],
       "photos": [{"name": "wall.jpg", "number": 0, "size": [2048, 1536], "pixel_aspect": 1.0,
                   "lens": 0}],
       "lines": [{"label": "roof", "photo": 0, "points_px": [[10.5, 20.5], [120.0, 21.0]]}],
       "origins": [{"path": "wall.csv", "format": "csv", "sha256": "…"}],
       "notes": []}}

Kept: all that observations hold but the bytes of the files they came from and the rows there;
notes tell both. A result has the same under `observations`, with the one `lens` of each; its
picks are read whether or not the fit left them out. Names that are not known are passed over,
so that later versions may add some. Coordinates are plumbline's own. Source: this module.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, fields
from typing import Any

import numpy as np

from plumbline._version import __version__
from plumbline.files import POINTS, RESULT, ZOOM
from plumbline.formats.base import ReadOptions, Source
from plumbline.formats.jsontext import (
    Object,
    as_list,
    as_number,
    as_object,
    as_text,
    parsed,
)
from plumbline.formats.points.lines import Size, UniqueLabels, clean_label, declared_size
from plumbline.frame import Array
from plumbline.observations import Line, Observations, Photo
from plumbline.observations.facts import LensFacts
from plumbline.wording import count

FORMAT_VERSION = 1
"""Raised when an older plumbline would misread the file."""
_HEAD = 1024
"""Characters in which the name of the format stands, as plumbline writes it."""
_TEXTS = {field.name for field in fields(LensFacts) if field.type == "str"}
_NUMBERS = {field.name for field in fields(LensFacts) if field.type == "float | None"}
_MOST = 1e100
"""Chosen, because the square of a larger number is no longer finite in all sums."""


def recognises(source: Source) -> bool:
    """Whether the file is JSON that plumbline wrote."""
    head = source.head.lstrip()[:_HEAD]
    return head.startswith("{") and any(f'"{name}"' in head for name in (POINTS, RESULT, ZOOM))


def read(source: Source, _options: ReadOptions) -> Observations:
    """The points of a file of points, or those that a result was fitted to.

    Raises:
        ReadError: the JSON is damaged or another, or of a later version.
    """
    top = as_object(source, parsed(source, source.text()), "the file")
    kind = as_text(top.get("format"))
    if kind == ZOOM:
        raise source.error(
            "this is a zoom lens, joined from several results; it holds no points",
            hint="give the RESULT.json of one focal length",
        )
    if kind not in {POINTS, RESULT}:
        raise source.error(
            "this is not JSON that plumbline wrote", hint="name its format with --format"
        )
    version = as_number(source, top.get("format_version"), "format_version")
    if version > FORMAT_VERSION:
        raise source.error("the file was written by a newer plumbline", hint="update plumbline")
    if "calibrations" not in top:
        return _observations(source, top, "")
    each = as_list(source, top["calibrations"], "calibrations")
    parts = [_observations(source, value, f"calibrations[{n}].") for n, value in enumerate(each)]
    if not parts:
        raise source.error("the file holds no points", hint="convert or fit the points again")
    return Observations.side_by_side(parts)


def write(observations: Observations) -> bytes:
    """The points as JSON that `read` takes back exactly."""
    whole = {
        "format": POINTS,
        "format_version": FORMAT_VERSION,
        "plumbline": __version__,
        "observations": {
            "lenses": [asdict(facts) for facts in observations.lenses],
            "photos": [
                {
                    "name": photo.name,
                    "number": photo.number,
                    "size": list(photo.frame.size),
                    "pixel_aspect": photo.pixel_aspect,
                    "lens": photo.lens,
                    "sha256": photo.sha256,
                    "taken": photo.taken,
                    "serial": photo.serial,
                }
                for photo in observations.photos
            ],
            "lines": [
                {"label": line.label, "photo": line.photo, "points_px": line.points_px.tolist()}
                for line in observations.lines
            ],
            "origins": [
                {"path": origin.path, "format": origin.format, "sha256": origin.sha256}
                for origin in observations.origins
            ],
            "notes": list(observations.notes),
        },
    }
    text = json.dumps(whole, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    # A file name that is not text is written in JSON's own escapes and reads back as it was.
    return text.encode("utf-8", "backslashreplace")


def _observations(source: Source, value: object, path: str) -> Observations:
    whole = as_object(source, value, path.rstrip(".") or "the file")
    stored = as_object(source, whole.get("observations"), f"{path}observations")
    where = f"{path}observations."
    several = "lenses" in stored
    each = as_list(source, stored["lenses"], f"{where}lenses") if several else [stored.get("lens")]
    lenses = [_facts(source, lens, f"{where}lenses[{n}]") for n, lens in enumerate(each)]
    photos = [
        _photo(source, photo, f"{where}photos[{n}]", len(lenses))
        for n, photo in enumerate(as_list(source, stored.get("photos"), f"{where}photos"))
    ]
    every = as_list(source, stored.get("lines"), f"{where}lines")
    objects = [as_object(source, line, f"{where}lines[{n}]") for n, line in enumerate(every)]
    names = UniqueLabels()
    lines = [
        _line(source, line, f"{where}lines[{n}]", len(photos), names)
        for n, line in enumerate(objects)
    ]
    if not lines or not lenses:
        raise source.error("the file holds no line of points", hint="convert the points again")
    left_out = sum(len(out) for line in objects if isinstance(out := line.get("left_out"), list))
    notes = [clean_label(as_text(note), most=1000) for note in _list(stored.get("notes"))]
    notes += [_origin(origin) for origin in _list(stored.get("origins"))]
    if left_out:
        notes.append(f"{count(left_out, 'pick')} that the result left out are taken again")
    told = tuple(dict.fromkeys(filter(None, notes)))
    return Observations(tuple(photos), tuple(lines), tuple(lenses), told)


def _list(value: object) -> Sequence[object]:
    return value if isinstance(value, list) else []


def _origin(value: object) -> str:
    """A note on the file that the points were read from at first."""
    origin: dict[str, Any] = value if isinstance(value, dict) else {}
    path = clean_label(as_text(origin.get("path")))
    checksum = clean_label(as_text(origin.get("sha256")))
    if not path:
        return ""
    return f"the points were read from {path}" + (f" (SHA-256 {checksum})" if checksum else "")


def _photo(source: Source, value: object, where: str, lenses: int) -> Photo:
    photo = as_object(source, value, where)
    aspect = as_number(source, photo.get("pixel_aspect", 1.0), f"{where}.pixel_aspect")
    return Photo(
        _size(source, photo.get("size"), f"{where}.size"),
        clean_label(as_text(photo.get("name"))),
        _index(source, photo.get("lens", 0), f"{where}.lens", lenses),
        aspect,
        sha256=clean_label(as_text(photo.get("sha256"))),
        taken=clean_label(as_text(photo.get("taken"))),
        serial=clean_label(as_text(photo.get("serial"))),
    )


def _size(source: Source, value: object, where: str) -> Size | None:
    if value is None:
        return None
    sides = [as_number(source, side, where) for side in as_list(source, value, where)]
    if len(sides) != 2:
        raise source.error(f"{where} does not hold a width and a height", hint="correct it")
    return declared_size(source, sides[0], sides[1])


def _line(source: Source, line: Object, where: str, photos: int, names: UniqueLabels) -> Line:
    photo = _index(source, line.get("photo"), f"{where}.photo", photos)
    points = _points(source, line.get("points_px"), f"{where}.points_px")
    return Line(points, photo, names(as_text(line.get("label")), photo))


def _points(source: Source, value: object, where: str) -> Array:
    pairs = [
        as_list(source, pair, f"{where}[{n}]")
        for n, pair in enumerate(as_list(source, value, where))
    ]
    for n, pair in enumerate(pairs):
        if len(pair) != 2:
            raise source.error(f"{where}[{n}] is not an x and a y", hint="correct or remove it")
    numbers = [
        [_bounded(source, number, f"{where}[{n}]") for number in pair]
        for n, pair in enumerate(pairs)
    ]
    return np.array(numbers, dtype=np.float64).reshape(-1, 2)


def _bounded(source: Source, value: object, where: str) -> float:
    number = as_number(source, value, where)
    if abs(number) > _MOST:
        raise source.error(f"{where} is impossibly large", hint="correct or remove it")
    return number


def _positive(source: Source, value: object, where: str) -> float:
    number = _bounded(source, value, where)
    if number <= 0:
        raise source.error(f"{where} is not above zero", hint="correct or remove it")
    return number


def _index(source: Source, value: object, where: str, end: int) -> int:
    number = as_number(source, value, where)
    if number != int(number) or not 0 <= number < end:
        raise source.error(f"{where} is {number:g}, and there are {end}", hint="correct it")
    return int(number)


def _facts(source: Source, value: object, where: str) -> LensFacts:
    lens = as_object(source, value, where)
    found: dict[str, Any] = {
        name: clean_label(as_text(lens[name])) for name in _TEXTS & lens.keys()
    }
    found |= {
        name: _positive(source, lens[name], f"{where}.{name}")
        for name in _NUMBERS & lens.keys()
        if lens[name] is not None
    }
    stored = as_object(source, lens.get("stored", {}), f"{where}.stored")
    requested = lens.get("requested")
    if requested is not None:
        names = as_list(source, requested, f"{where}.requested")
        found["requested"] = tuple(clean_label(as_text(name)) for name in names)
    values = {
        clean_label(name): _bounded(source, number, f"{where}.stored.{name}")
        for name, number in stored.items()
    }
    return LensFacts(**found, stored=values)

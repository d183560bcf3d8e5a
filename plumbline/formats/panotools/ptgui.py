"""Projects of PTGui and PTAssembler: Panorama Tools text, read only.

    # ptGui project file
    #-fileversion 49
    #-dummyimage
    o w1 h1 y0 r0 p0 v52 a0.03 b-0.1 c0.06 f0 d0 e0 g0 t0
    #-imgfile 1712 1368 "x.jpg"
    o f0 y0 r0 p0 v=0 a=0 b=0 c=0 d=0 e=0 g=0 t=0
    v v a b c
    c n1 N1 x175 y88 X1534 Y63 t3

The dummy image holds the lens values, and `=0` means it. From file version 8 on, the image
numbers of control points count the dummy. `v` records name variables without a number for the
dummy. From version 11 on `.pts` files are JSON (`ptgui_json`). Source: files of PTGui 4 to
9; coordinates are taken as Panorama Tools', which are plumbline's own.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace

from plumbline.formats.base import ReadOptions, Source
from plumbline.formats.panotools.control_points import collect_lines
from plumbline.formats.panotools.point_records import ControlPoints, take_points
from plumbline.formats.panotools.ptgui_json import is_json, read_json
from plumbline.formats.panotools.pto import refuse_moved_centre
from plumbline.formats.panotools.script import ImageRecord, kind_of, parse_image, readable
from plumbline.observations import Observations, Photo
from plumbline.observations.facts import LensFacts

_FILE_VERSION = re.compile(r"#-fileversion (\d{1,6})\s*\Z")
_IMAGE_FILE = re.compile(r'#-imgfile (\d{1,9}) (\d{1,9}) "([^"]*)"')
_CROP = re.compile(r"#-ccdcrop (\S+)")
_COUNTS_DUMMY_FROM = 8
"""Version of the project format from which the dummy image counts as image 0."""


@dataclass
class _Project:
    points: ControlPoints
    version: int = 0
    crop_factor: float | None = None
    has_dummy: bool = False
    images: list[ImageRecord] = field(default_factory=list[ImageRecord])
    sizes: list[tuple[int, int]] = field(default_factory=list[tuple[int, int]])
    requested: set[str] = field(default_factory=set[str])
    pending: tuple[int, int, str] | None = None


def recognises(source: Source) -> bool:
    """Whether the file is a project of PTGui or PTAssembler."""
    head = source.head.lstrip()
    return head.startswith("# ptGui") or (
        (source.suffix == ".pts" and (head.startswith("{") or "#-imgfile" in head))
        or is_json(source)
    )


def _parse(source: Source) -> _Project:
    if is_json(source):
        raise source.error(
            "the lens of a project of PTGui 11 or newer (JSON) is not read, only its points",
            hint="fit its straight lines, or export the project for Panorama Tools",
        )
    points, rest = take_points(source)
    project = _Project(points)
    for row, line in rest:
        if line.startswith("#-"):
            _read_comment(source, project, row, line)
        elif kind_of(line) == "o":
            _read_image(source, project, row, line)
        elif kind_of(line) == "v":
            project.requested.update(line.split()[1:])
    return project


def _read_comment(source: Source, project: _Project, row: int, line: str) -> None:
    if found := _FILE_VERSION.match(line):
        project.version = int(found[1])
    elif line.startswith("#-dummyimage"):
        project.has_dummy = True
        project.pending = (1, 1, "")
    elif found := _IMAGE_FILE.match(line):
        project.pending = (int(found[1]), int(found[2]), readable(found[3]))
    elif found := _CROP.match(line):
        crop_factor = source.number(found[1], row, what="the crop factor")
        project.crop_factor = crop_factor if crop_factor > 0 else None


def _read_image(source: Source, project: _Project, row: int, line: str) -> None:
    image = parse_image(source, row, line, project.images)
    if project.pending is None:
        raise source.error(
            "the image record has no '#-imgfile WIDTH HEIGHT \"name\"' before it",
            row,
            hint="save the project again in PTGui, or pick the points in another format",
        )
    width, height, name = project.pending
    if width < 1 or height < 1:
        raise source.error("the image has no size", row, hint="save the project again in PTGui")
    # The size stands in the comment: put it where a script of Panorama Tools has it.
    values = dict(image.values) | {"w": float(width), "h": float(height)}
    project.images.append(replace(image, values=values, name=name))
    project.sizes.append((width, height))
    project.pending = None


def read(source: Source, _options: ReadOptions) -> Observations:
    """Straight lines of a project.

    Raises:
        ReadError: a record is damaged, or there is no image.
    """
    if is_json(source):
        return read_json(source)
    project = _parse(source)
    first = 1 if project.has_dummy else 0
    images = project.images[first:]
    if not images:
        raise source.error("there is no image in this project", hint="add the photo in PTGui")
    if first and project.version >= _COUNTS_DUMMY_FROM:
        project.points = project.points.counted_from(first)
    notes: list[str] = []
    lines = collect_lines(source, project.points, len(images), notes)
    for image in {line.photo for line in lines}:
        refuse_moved_centre(source, images[image])
    lens_of = _lenses(images)
    return Observations(
        photos=tuple(
            Photo(size, image.name, lens)
            for image, size, lens in zip(images, project.sizes[first:], lens_of, strict=True)
        ),
        lines=lines,
        lenses=tuple(
            _facts(project, images[lens_of.index(lens)]) for lens in range(max(lens_of) + 1)
        ),
        notes=tuple(notes),
    )


def read_images(source: Source) -> list[ImageRecord]:
    """The image records of a project with their sizes, whether or not it has straight lines.

    Raises:
        ReadError: a record is damaged, or there is none.
    """
    project = _parse(source)
    images = project.images[1 if project.has_dummy else 0 :]
    if not images:
        raise source.error("there is no image in this project", hint="add the photo in PTGui")
    return images


def _lenses(images: list[ImageRecord]) -> list[int]:
    """Images whose a, b, c come from one record share a lens."""
    numbers: dict[tuple[int | None, ...], int] = {}
    lens_of: list[int] = []
    for own, image in enumerate(images):
        roots = {image.links.get(name) for name in ("a", "b", "c")}
        root = roots.pop() if len(roots) == 1 else None
        key = (root,) if root is not None else (None, own)
        lens_of.append(numbers.setdefault(key, len(numbers)))
    return lens_of


def _facts(project: _Project, image: ImageRecord) -> LensFacts:
    linked = bool(image.links)
    number = project.images.index(image)
    asked = tuple(
        name
        for name in ("a", "b", "c", "d", "e")
        if (linked and name in project.requested) or f"{name}{number}" in project.requested
    )
    return image.facts(asked or None, project.crop_factor)

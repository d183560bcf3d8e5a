"""Hugin projects (PTO), read and written; also scripts for the bare Panorama Tools optimiser.

    i w1712 h1368 f0 v52.44 a0.03 b-0.1 c0.06 d0 e0 g0 t0 n"x.jpg"
    v a0 b0 c0
    c n0 N0 x175.00064 y87.999336 X1533.999936 Y62.666712 t3

Read: size, lens type, field of view, lens values, links and crop factor of every image, the
variables to optimise, and the control points of type t3 and above between points of one image,
one number a line. The points of a line come in any pairing; the union of both ends is taken,
each point once, sorted along the line. Other control points are counted and left aside.
Written back: every byte as it was but for a, b, c, d, e on the `i` lines. Source: Hugin 2022,
libpano13 2.9; coordinates are plumbline's own.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from plumbline.formats.base import ReadOptions, Source
from plumbline.formats.panotools.control_points import collect_lines
from plumbline.formats.panotools.point_records import ControlPoints, take_points
from plumbline.formats.panotools.pto_writing import new_project
from plumbline.formats.panotools.script import (
    STAND_IN,
    UNKNOWN_HFOV_DEG,
    ImageRecord,
    kind_of,
    parse_image,
    size_of,
)
from plumbline.observations import Observations, Photo
from plumbline.observations.facts import LensFacts

_LENS_COEFFICIENTS = ("a", "b", "c", "d", "e")
_LINKED = ("a", "b", "c")
_CROP_FACTOR = re.compile(r"\bcropFactor=(\S+)")
_VARIABLE = re.compile(r"([A-Za-z]+?)(\d+)")


@dataclass
class _Script:
    points: ControlPoints
    images: list[ImageRecord] = field(default_factory=list[ImageRecord])
    crop_factors: list[float | None] = field(default_factory=list["float | None"])
    variables: list[tuple[str, int]] = field(default_factory=list[tuple[str, int]])


def recognises(source: Source) -> bool:
    """Whether the file is a Hugin project or a script with images."""
    head = source.head
    if head.lstrip().startswith("# ptGui"):
        return False
    return (
        source.suffix == ".pto"
        or head.startswith("# hugin project file")
        or re.search(r"^i (?=.*\bw\d)(?=.*\bh\d)", head, re.MULTILINE) is not None
    )


def _parse(source: Source) -> _Script:
    points, rest = take_points(source)
    script = _Script(points)
    crop_factor: float | None = None
    stand_in = False
    for row, text in rest:
        kind = kind_of(text)
        if kind == "i":
            image = parse_image(source, row, text, script.images)
            script.images.append(_without_hfov(image) if stand_in else image)
            script.crop_factors.append(crop_factor)
            crop_factor, stand_in = None, False
        elif kind == "v":
            names = (_VARIABLE.fullmatch(token) for token in text.split()[1:])
            script.variables += [(m[1], int(m[2])) for m in names if m and len(m[2]) < 10]
        elif text.startswith(STAND_IN):
            stand_in = True
        elif text.startswith("#-hugin"):
            found = _CROP_FACTOR.search(text)
            crop_factor = source.number(found[1], row, what="the crop factor") if found else None
            crop_factor = crop_factor if crop_factor and crop_factor > 0 else None
    return script


def _without_hfov(image: ImageRecord) -> ImageRecord:
    """An image without the field of view that plumbline wrote for want of a known one."""
    if image.values.get("v") != UNKNOWN_HFOV_DEG:
        return image
    return replace(image, values={n: value for n, value in image.values.items() if n != "v"})


def read(source: Source, _options: ReadOptions) -> Observations:
    """Straight lines of a project.

    Raises:
        ReadError: a record is damaged, or there is no image.
    """
    script = _parse(source)
    if not script.images:
        raise source.error("there is no image in this project", hint="add the photo in Hugin")
    notes: list[str] = []
    lens_of = _lenses(script.images, notes)
    lines = collect_lines(source, script.points, len(script.images), notes)
    for image in {line.photo for line in lines}:
        refuse_moved_centre(source, script.images[image])
    return Observations(
        photos=tuple(
            Photo(size_of(source, image), image.name, lens)
            for image, lens in zip(script.images, lens_of, strict=True)
        ),
        lines=lines,
        lenses=_facts(script, lens_of, {line.photo for line in lines}, notes),
        notes=tuple(notes),
    )


def _lenses(images: Sequence[ImageRecord], notes: list[str]) -> list[int]:
    """The lens number of every image: images whose a, b, c are linked share one."""
    lens_of: list[int] = []
    for number, image in enumerate(images):
        roots = {image.links.get(name) for name in _LINKED}
        root = roots.pop() if len(roots) == 1 else None
        lens = max(lens_of, default=-1) + 1
        if root is not None:
            own = [
                name
                for name in ("d", "e", "g", "t")
                if image.values.get(name, 0.0) != images[root].values.get(name, 0.0)
            ]
            if own:
                notes.append(
                    f"image {number} links a, b, c to image {root} but has its own "
                    f"{', '.join(own)}: it is fitted for itself"
                )
            else:
                lens = lens_of[root]
        lens_of.append(lens)
    return lens_of


def _facts(
    script: _Script, lens_of: list[int], with_lines: set[int], notes: list[str]
) -> tuple[LensFacts, ...]:
    facts: list[LensFacts] = []
    unseen: Counter[str] = Counter()
    for lens in range(max(lens_of) + 1):
        members = [image for image, its in enumerate(lens_of) if its == lens]
        asked = [name for name, image in script.variables if image in members]
        if with_lines & set(members):
            unseen.update(n for n in dict.fromkeys(asked) if n in ("v", "y", "p", "r", "g", "t"))
        requested = tuple(name for name in _LENS_COEFFICIENTS if name in asked)
        first = members[0]
        facts.append(script.images[first].facts(requested or None, script.crop_factors[first]))
    if unseen:
        words = {"v": "the field of view (v)", "g": "the shear g", "t": "the shear t"}
        listed = ", ".join(words.get(name, name) for name in unseen)
        notes.append(f"the project asks to optimise {listed}, which straight lines do not show")
    return tuple(facts)


def read_images(source: Source) -> list[ImageRecord]:
    """The image records of a project, whether or not it has straight lines.

    Raises:
        ReadError: a record is damaged, or there is none.
    """
    images = _parse(source).images
    if not images:
        raise source.error("there is no image in this project", hint="add the photo in Hugin")
    return images


def refuse_moved_centre(source: Source, image: ImageRecord) -> None:
    """Refuse a crop that moves the image centre away from the photo's.

    Raises:
        ReadError: there is one.
    """
    if image.crop is None:
        return
    left, right, top, bottom = image.crop
    width, height = size_of(source, image)
    if (left + right, top + bottom) != (width, height):
        raise source.error(
            "the image has a crop (C) whose centre is not the photo's, about which its lens "
            "values would be measured",
            image.row,
            hint="remove the crop, or use Hugin's S crop, which keeps the centre",
        )


def write(observations: Observations) -> bytes:
    """A new project of picked points."""
    return new_project(observations, {})

"""Drawings in SVG, as Inkscape saves them: lines drawn over the photo.

    <svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 800 600">
      <image width="800" height="600" href="wall.jpg"/>
      <path id="roof" d="M 10,40 L 200,28 400,24"/>
      <polyline points="10,560 200,572 400,576"/>
    </svg>

Every polyline, line and open path is one line; of curves the nodes are taken, which were clicked.
With an <image> its box is the photo, whatever the unit of the drawing; without one the viewBox is
if the photo's size is known, or else the unit is the pixel. Kept: labels of Inkscape or ids,
transformations, the photo's name. Dropped: closed shapes (a note says so), copies by <use>. SVG
counts from the corner of the first pixel, so 0.5 is subtracted here. Source: SVG 1.1; paths and
transformations by the package svgelements.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from plumbline.formats.base import ReadOptions, Source
from plumbline.formats.points.lines import LineGatherer, Size
from plumbline.formats.xmltext import Element, parsed, row_of
from plumbline.frame import Array
from plumbline.observations import Observations

if TYPE_CHECKING:
    from svgelements import Matrix

MAX_DEPTH = 200
"""Groups within groups; chosen, Python's own limit is 1,000 calls."""
MAX_PATH = 1_000_000
"""Characters of one path; chosen as fifty thousand nodes, more than anyone clicks."""
_FIRST = re.compile(r"<(?:\w+:)?svg[\s>]")
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,3})?")
_LINES = {"polyline", "line", "path"}
_CLOSED = {"rect", "circle", "ellipse", "polygon", "use", "text"}
_UNSEEN = {"defs", "clipPath", "mask", "marker", "pattern", "symbol", "metadata"}
_SAME_SHAPE = 0.01
"""Ratio of aspects that differ by more are another picture; chosen for rounded sizes."""
_LABEL = "{http://www.inkscape.org/namespaces/inkscape}label"
_LINK = "{http://www.w3.org/1999/xlink}href"


def read(source: Source, options: ReadOptions) -> Observations:
    """Polylines, lines and open paths of a drawing.

    Raises:
        ReadError: the XML is broken, a path or number is, or the drawing holds several photos
            or one whose size is not known.
    """
    root = parsed(source)
    if _tag(root) != "svg":
        raise source.error("the XML is not a drawing in SVG", hint="save it again as SVG")
    shapes = list(_shapes(source, root))
    box, name = _photo(source, root, shapes, options.size)
    gatherer = LineGatherer(source, shift_px=-0.5)
    for element, matrix in shapes:
        kind = _tag(element)
        if kind in _CLOSED:
            gatherer.leave_aside(kind)
        elif kind in _LINES:
            label = element.get(_LABEL, "") or element.get("id", "")
            for part in _parts(source, element, kind):
                points = _through(matrix, part) @ box[:2] + box[2]
                gatherer.add(
                    points, label, photo_name=name, size=options.size, rows=row_of(element)
                )
    return gatherer.observations("polylines, lines and open paths")


def recognises(source: Source) -> bool:
    """Whether the XML starts with <svg>."""
    return source.head.lstrip().startswith("<") and _FIRST.search(source.head) is not None


def _tag(element: Element) -> str:
    return str(element.tag).rpartition("}")[2]


def _shapes(source: Source, root: Element) -> Iterator[tuple[Element, Matrix]]:
    """All elements that are drawn, each with its transformation to the drawing's unit."""
    from svgelements import Matrix

    waiting = [(child, Matrix(), 1) for child in root][::-1]
    while waiting:
        element, outer, depth = waiting.pop()
        if _tag(element) in _UNSEEN:
            continue
        try:
            matrix = Matrix(element.get("transform", "")) * outer
        except (ValueError, TypeError, IndexError, AttributeError, ZeroDivisionError):
            raise source.error(
                "a transformation is broken", row_of(element), "save again"
            ) from None
        if depth < MAX_DEPTH:
            waiting += [(child, matrix, depth + 1) for child in element][::-1]
        yield element, matrix


def _photo(
    source: Source, root: Element, shapes: list[tuple[Element, Matrix]], size: Size | None
) -> tuple[Array, str]:
    """The map from the drawing to the photo's pixels, as rows of a 3 by 2 matrix; its name."""
    images = [each for each in shapes if _tag(each[0]) == "image"]
    if len(images) > 1:
        raise source.error(
            f"the drawing holds {len(images)} photos",
            row_of(images[1][0]),
            "keep the one picked in",
        )
    if images:
        image, matrix = images[0]
        link = image.get(_LINK, "") or image.get("href", "")
        name = "" if link.startswith("data:") else link
        left, top, width, height = (
            _length(source, image, each) for each in ("x", "y", "width", "height")
        )
        corners = np.array([(left, top), (left + width, top), (left, top + height)])
        return _onto(source, _through(matrix, corners), size, row_of(image)), name
    numbers = [float(each) for each in _NUMBER.findall(root.get("viewBox", ""))]
    if size is not None and len(numbers) == 4:
        left, top, width, height = numbers
        corners = np.array([(left, top), (left + width, top), (left, top + height)])
        return _onto(source, corners, size, row_of(root)), ""
    return np.array([(1.0, 0.0), (0.0, 1.0), (0.0, 0.0)]), ""


def _onto(source: Source, corners: Array, size: Size | None, row: int | None) -> Array:
    """The map that takes the top left, top right and bottom left corner to a photo's."""
    if size is None:
        raise source.error(
            "the drawing holds a photo whose size in pixels is not known",
            row,
            "give the photo with --photo FILE or its size with --size WIDTHxHEIGHT",
        )
    sides = corners[1:] - corners[0]
    lengths = np.linalg.norm(sides, axis=1)
    if not np.all(np.isfinite(lengths)) or not np.all(lengths > 0):
        raise source.error("the photo in the drawing has no size", row, "save the drawing again")
    if abs(lengths[0] / lengths[1] / (size[0] / size[1]) - 1) > _SAME_SHAPE:
        raise source.error(
            f"the photo in the drawing has the shape {lengths[0]:.6g}x{lengths[1]:.6g}, not that "
            f"of {size[0]}x{size[1]}",
            row,
            "give the photo that was drawn over",
        )
    linear = np.linalg.pinv(sides) @ np.diag(np.array(size, dtype=np.float64))
    return np.vstack([linear, -corners[0] @ linear])


def _length(source: Source, image: Element, name: str) -> float:
    text = image.get(name, "0")
    found = _NUMBER.match(text.strip())
    if found is None:
        raise source.error(f"the {name} of the photo is not a number", row_of(image), "save again")
    return float(found[0])


def _parts(source: Source, element: Element, kind: str) -> Iterator[Array]:
    """The points of each part of a shape, in the shape's own unit."""
    if kind == "line":
        ends = [
            source.number(element.get(n, "0"), row_of(element)) for n in ("x1", "y1", "x2", "y2")
        ]
        yield np.array(ends).reshape(2, 2)
        return
    text = element.get("points" if kind == "polyline" else "d", "")
    if len(text) > MAX_PATH:
        raise source.error("a path is longer than any that is drawn by hand", row_of(element))
    if kind == "polyline":
        numbers = [float(each) for each in _NUMBER.findall(text)]
        yield np.array(numbers[: len(numbers) // 2 * 2]).reshape(-1, 2)
        return
    yield from _of_path(source, element, text)


def _of_path(source: Source, element: Element, text: str) -> Iterator[Array]:
    from svgelements import Close, Move, Path

    try:
        path = Path(text)
        nodes: list[tuple[float, float]] = []
        for segment in path:
            if isinstance(segment, Move) and nodes:
                yield np.array(nodes)
                nodes = []
            if not isinstance(segment, Close) and (end := segment.end) is not None:
                nodes.append((float(end.real or 0.0), float(end.imag or 0.0)))
    except (ValueError, TypeError, IndexError, AttributeError, ZeroDivisionError, OverflowError):
        raise source.error("a path is broken", row_of(element), "save the drawing again") from None
    if nodes:
        yield np.array(nodes)


def _through(matrix: Matrix, points: Array) -> Array:
    linear = np.array([[matrix.a, matrix.b], [matrix.c, matrix.d]])
    return points @ linear + np.array([matrix.e, matrix.f])

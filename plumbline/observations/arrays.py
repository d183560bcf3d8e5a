"""Lines of picks from arrays: NumPy's, masked ones, OpenCV's corners."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plumbline.errors import OptionError
from plumbline.frame import Array
from plumbline.observations.facts import LensFacts
from plumbline.observations.picks import Line, Photo
from plumbline.wording import count


def lines_from_arrays(
    lines: Iterable[ArrayLike], labels: Sequence[object] | None
) -> tuple[tuple[Line, ...], int]:
    """Lines of one photo from arrays, and how many of their points were masked.

    Args:
        lines: One (n, 2) or (n, 1, 2) array of pixels a line.
        labels: Names of the lines, one each; numbers from 1 where there are none.

    Raises:
        OptionError: an array has the wrong shape or holds no numbers, or there are more or fewer
            labels than lines.
    """
    arrays = _listed(lines, "lines", "give a list of arrays of shape (n, 2), one for each line")
    hint = "give one label for each line, or none at all"
    names = range(1, len(arrays) + 1) if labels is None else _listed(labels, "labels", hint)
    if len(names) != len(arrays):
        raise OptionError(
            f"there are {count(len(names), 'label')} for {count(len(arrays), 'line')}",
            hint=hint,
        )
    found: list[Line] = []
    hidden = 0
    for label, values in zip(map(str, names), arrays, strict=True):
        points, shown = _numbers(values, f"line {label}")
        if points.ndim == 3 and points.shape[1:] == (1, 2):
            points, shown = points[:, 0], shown[:, 0]  # as OpenCV has corners
        if points.ndim != 2 or points.shape[1] != 2:
            raise OptionError(
                f"line {label} has shape {points.shape}",
                hint="give one array of shape (n, 2), x and y in pixels, for each line",
            )
        hidden += int(np.count_nonzero(~shown))
        found.append(Line(points[shown], 0, label))
    return tuple(found), hidden


def lines_from_grid(points: ArrayLike) -> tuple[tuple[Line, ...], int]:
    """The rows and columns of a grid as lines of one photo, and how many points are missing.

    Args:
        points: Pixels, shape (rows, columns, 2); NaN or masked where a point is missing.

    Raises:
        OptionError: the array has another shape or holds no numbers.
    """
    grid, shown = _numbers(points, "the grid")
    if grid.ndim != 3 or grid.shape[2] != 2:
        raise OptionError(
            f"the grid has shape {grid.shape}",
            hint="give shape (rows, columns, 2); OpenCV's corners take this shape with "
            "corners.reshape(rows, columns, 2)",
        )
    known = shown & ~np.isnan(grid).any(axis=2)
    return tuple(_rows_and_columns(grid, known)), int(np.count_nonzero(~known))


def photo_and_lens(
    size: tuple[int, int], focal_px: float | None, pixel_aspect: float
) -> tuple[Photo, LensFacts]:
    """The photo that arrays were picked in, and the lens that took it.

    Raises:
        OptionError: the size is not two numbers, or another argument is not a number.
    """
    try:
        width, height = map(float, size)
    except (TypeError, ValueError):
        raise OptionError(
            f"the size {size!r} is not a width and a height",
            hint="give two whole numbers of pixels, as in size=(6000, 4000)",
        ) from None
    try:
        aspect = float(pixel_aspect)
        focal = None if focal_px is None else float(focal_px)
    except (TypeError, ValueError) as error:
        raise OptionError(f"focal_px and pixel_aspect are numbers: {error}") from None
    if not (width.is_integer() and height.is_integer()):
        raise OptionError(
            f"the size {width:g}x{height:g} is impossible", hint="give whole numbers of pixels"
        )
    return Photo((int(width), int(height)), pixel_aspect=aspect), LensFacts(focal_px=focal)


def _listed(values: Iterable[Any], what: str, hint: str) -> list[Any]:
    try:
        return list(values)
    except TypeError:
        given = type(values).__name__
        raise OptionError(f"a list of {what} expected, not {given}", hint=hint) from None


def _rows_and_columns(grid: Array, known: NDArray[np.bool_]) -> Iterator[Line]:
    for number, (points, there) in enumerate(zip(grid, known, strict=True), 1):
        yield Line(points[there], 0, f"row {number}")
    for number, (points, there) in enumerate(zip(grid.swapaxes(0, 1), known.T, strict=True), 1):
        yield Line(points[there], 0, f"column {number}")


def _numbers(values: ArrayLike, what: str) -> tuple[Array, NDArray[np.bool_]]:
    """An array of points and which of them are not masked, shape (...,).

    Raises:
        OptionError: these are not numbers in an array.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # complex numbers
            points = np.array(np.ma.getdata(values), dtype=np.float64)
        hidden = np.ma.getmaskarray(np.ma.asarray(values))
    except (TypeError, ValueError, RuntimeWarning) as error:
        raise OptionError(f"{what} is not an array of numbers: {error}") from None
    if points.ndim == 0:
        raise OptionError(f"{what} is not an array of numbers but a {type(values).__name__}")
    return points, np.asarray(~hidden.any(axis=-1))

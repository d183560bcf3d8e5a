"""What observations consist of: a photograph, a line of picks, the file they came from."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from plumbline.errors import OptionError
from plumbline.frame import Array, Frame

MAX_SIDE = 1_000_000
"""Pixels; chosen, ten times the side of the largest stitched photos."""


@dataclass(frozen=True)
class Photo:
    """One photograph.

    Attributes:
        size: Width and height in pixels, as picked; None while still unknown.
        name: File name as the source gives it; may be empty.
        lens: Index into `Observations.lenses`.
        pixel_aspect: Width of one pixel over its height.
        number: Its number in the file it was named by.
        source: Name of the file of points, where that holds this photo alone.
        sha256: Of the file's bytes when the points were read; empty where it was not at hand.
        taken: When it was taken, as EXIF has it; may be empty.
        serial: Serial number of its camera, as EXIF has it; may be empty.
    """

    size: tuple[int, int] | None
    name: str = ""
    lens: int = 0
    pixel_aspect: float = 1.0
    number: int = 0
    source: str = ""
    sha256: str = ""
    taken: str = ""
    serial: str = ""

    @cached_property
    def frame(self) -> Frame:
        """The photo's rectangle.

        Raises:
            OptionError: the size is not known.
        """
        if self.size is None:
            raise OptionError(
                "the size of the photo is not known",
                hint="give the photo with --photo FILE or its size with --size WIDTHxHEIGHT",
            )
        return Frame(*self.size, self.pixel_aspect)

    def checked(self, where: str = "") -> Photo:
        """The same photo, its size two plain whole numbers.

        Args:
            where: What messages begin with.

        Raises:
            OptionError: the size is missing or absurd, or the pixels are.
        """
        name = f" of {self.name}" if self.name else ""
        size = self.frame.size if self.size is None else tuple(self.size)
        if len(size) != 2:
            raise OptionError(
                f"{where}the size {size}{name} is not a width and a height",
                hint="give two whole numbers of pixels",
            )
        width, height = size
        if not all(0 < side <= MAX_SIDE and side == int(side) for side in size):
            raise OptionError(
                f"{where}the size {width}x{height}{name} is impossible",
                hint="give width and height in whole pixels, such as 6000x4000",
            )
        if not 0.01 <= self.pixel_aspect <= 100:
            raise OptionError(
                f"a pixel aspect of {self.pixel_aspect:g} is impossible",
                hint="give the width of a pixel over its height, such as 16:15",
            )
        plain = (int(width), int(height))
        return replace(self, size=plain, pixel_aspect=float(self.pixel_aspect))


@dataclass(frozen=True, eq=False)
class Line:
    """Points picked along one straight edge, in the order along it.

    Attributes:
        points_px: Observed points, shape (n, 2), the photo's own pixels.
        photo: Index into `Observations.photos`.
        label: The line's name in the source.
        rows: Where each point stands in the source file, counted from 1; None for arrays.
        corrected_px: Where a corrected picture shows the same points, shape (n, 2): these are
            matches of two pictures, and lie on no line. None for picks.
    """

    points_px: Array
    photo: int = 0
    label: str = ""
    rows: NDArray[np.int64] | None = None
    corrected_px: Array | None = None

    def first_of_each(self) -> NDArray[np.int64]:
        """Where each distinct point stands first, in rising order."""
        return first_of_each(self.points_px)


@dataclass(frozen=True)
class Origin:
    """Where observations came from, kept so that a project can be written back losslessly.

    Attributes:
        path: The file as named by the user.
        format: Name of its format.
        content: Its bytes; empty where a result was read back.
        checksum: The SHA-256 of the bytes, where a result tells it.
    """

    path: str
    format: str
    content: bytes = field(repr=False, default=b"")
    checksum: str = ""

    @property
    def sha256(self) -> str:
        """SHA-256 of the file's bytes, in hexadecimal; empty where it is not known."""
        return hashlib.sha256(self.content).hexdigest() if self.content else self.checksum


def first_of_each(points: Array) -> NDArray[np.int64]:
    """Where each distinct point of shape (n, 2) stands first, in rising order."""
    x, y = points[:, 0], points[:, 1]
    order = np.lexsort((y, x))
    x, y = x[order], y[order]
    repeated = (x[1:] == x[:-1]) & (y[1:] == y[:-1])
    if not repeated.any():
        return np.arange(len(points))
    # lexsort is stable: the first of equal points is the one that stands first.
    return np.sort(order[np.concatenate(([True], ~repeated))])

"""A photograph to pick in: decoded once, upright, small first, and watched on disk."""

from __future__ import annotations

import hashlib
import threading
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from plumbline.errors import PlumblineError, ReadError
from plumbline.files import read_bytes
from plumbline.photos.exif import PhotoFacts, read_photo
from plumbline.photos.files.picture import Picture, decode
from plumbline.photos.turning import turned_upright

Pixels = NDArray[Any]

_EIGHTH = 3
"""Levels that a JPEG decoded at an eighth of its size skips: log₂ 8."""

_LARGE = 4_000_000
"""Pixels from which a JPEG is shown small first. Chosen, because fewer decode in 50 ms."""


@dataclass(frozen=True)
class Level:
    """The photo at one size.

    Attributes:
        pixels: Upright, 8 bits: grey (rows, columns), or blue, green, red or four inks (…, n).
        mode: "L", "BGR" or "CMYK".
    """

    pixels: Pixels
    mode: str


class LoadedPhoto:
    """One photograph, loading in the background.

    The constructor reads the head alone. `load` decodes: level k of the pyramid is the photo
    reduced by 2ᵏ; of a large JPEG the small levels come first.

    Args:
        path: The file.

    Attributes:
        sha256: Of the file's bytes, in hexadecimal; empty until it is loaded.
        picked_sha256: The same when it was picked in; empty where that is not known.
        failure: Why it cannot be decoded; None where it can, or is not yet.

    Raises:
        ReadError: it is not a photograph that can be read.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.facts: PhotoFacts = read_photo(path)
        self.size = self.facts.size
        self.sha256 = ""
        self.picked_sha256 = ""
        self.icc = b""
        self.failure: PlumblineError | None = None
        self._levels: dict[int, Level] = {}
        self._source: Pixels | None = None
        self._changed = threading.Condition()
        self._stamp = _stamp(path)

    @property
    def n_levels(self) -> int:
        """Levels of the pyramid: the last one fits into 256 pixels."""
        return max(1, int(np.ceil(np.log2(max(self.size) / 256))) + 1)

    def load(self) -> None:
        """Decode the photo; what goes wrong is kept in `failure`."""
        try:
            data = read_bytes(self.path)
            self.sha256 = hashlib.sha256(data).hexdigest()
            self._show_small(data)
            self._take(decode(data, self.path))
        except PlumblineError as error:
            self._fail(error)
        except MemoryError:
            self._fail(ReadError("the photo does not fit into memory", path=self.path))

    def level(self, number: int, timeout_s: float = 60.0) -> Level:
        """One level of the pyramid, waited for.

        Raises:
            ReadError: the photo cannot be decoded, or not in time.
        """
        with self._changed:
            self._changed.wait_for(lambda: self.failure or number in self._levels, timeout_s)
            if self.failure is not None:
                raise self.failure
            if number not in self._levels:
                raise ReadError("the photo is not decoded yet", path=self.path)
            return self._levels[number]

    def source(self, timeout_s: float = 60.0) -> Pixels:
        """The photo at full size and depth, upright, blue first; waited for.

        Raises:
            ReadError: the photo cannot be decoded, or not in time.
        """
        level = self.level(0, timeout_s)
        if level.mode == "CMYK":
            raise ReadError(
                "edges are not traced in printing inks",
                path=self.path,
                hint="save it with red, green and blue, or pick freely",
            )
        return level.pixels if self._source is None else self._source

    @property
    def trouble(self) -> str:
        """Why it cannot be shown, or is shown as it was, in a sentence; empty if all is well."""
        if self.failure is not None:
            return self.failure.message
        if self.sha256 and self.picked_sha256 not in ("", self.sha256):
            return f"{self.path.name} has changed since the picks were made: check them"
        now = _stamp(self.path)
        if now == self._stamp:
            return ""
        what = "was moved or deleted" if now is None else "was changed"
        return f"{self.path.name} {what} after it was opened; this page shows it as it was"

    def _fail(self, error: PlumblineError) -> None:
        with self._changed:
            self.failure = error
            self._changed.notify_all()

    def _show_small(self, data: bytes) -> None:
        """Decode a large JPEG at an eighth of its size, which its format allows quickly."""
        if self.size[0] * self.size[1] < _LARGE or self.n_levels <= _EIGHTH:
            return
        if not data.startswith(b"\xff\xd8"):
            return
        flags = cv2.IMREAD_REDUCED_COLOR_8 | cv2.IMREAD_IGNORE_ORIENTATION
        small: Any = cv2.imdecode(np.frombuffer(data, dtype=np.uint8), flags)
        if small is None:
            return
        self._build(Level(turned_upright(small, self.facts.orientation), "BGR"), _EIGHTH)

    def _take(self, picture: Picture) -> None:
        pixels = picture.pixels
        if picture.alpha:
            pixels = pixels[..., 0] if pixels.shape[2] == 2 else pixels[..., :3]
        turned_before = self.facts.turned and pixels.shape[1::-1] == self.size
        pixels = turned_upright(pixels, 1 if turned_before else self.facts.orientation)
        if pixels.shape[1::-1] != self.size:
            raise ReadError(
                "the photo's header and its pixels give two different sizes", path=self.path
            )
        mode = "CMYK" if picture.inks else "L" if pixels.ndim == 2 else "BGR"
        self.icc = picture.metadata.icc
        if pixels.dtype == np.uint16:
            self._source = pixels
            pixels = (pixels >> 8).astype(np.uint8)
        self._build(Level(pixels, mode), 0)

    def _build(self, first: Level, number: int) -> None:
        """Fill the pyramid from one level upwards."""
        levels = {number: first}
        pixels = first.pixels
        for above in range(number + 1, self.n_levels):
            width, height = (max(1, (side + 1) // 2) for side in pixels.shape[1::-1])
            pixels = np.asarray(cv2.resize(pixels, (width, height), interpolation=cv2.INTER_AREA))
            levels[above] = Level(pixels, first.mode)
        with self._changed:
            self._levels |= levels
            self._changed.notify_all()


def is_photo(path: Path) -> bool:
    """Whether Pillow takes a file for a picture."""
    try:
        with warnings.catch_warnings(action="ignore"), Image.open(path):
            return True
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError):
        return False


def _stamp(path: Path) -> tuple[int, int] | None:
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_size, status.st_mtime_ns

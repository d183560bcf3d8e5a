"""Records of Panorama Tools scripts: what Hugin's and PTGui's projects have in common.

A script is plain text, one record a line, its first character the kind. Tokens are
`<name><value>` separated by blanks; values may be numbers, `=N` (that of image N), or strings
in double quotes. Nothing is thrown away: a script is written back byte for byte but for the
values that were set.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from plumbline.errors import OptionError
from plumbline.files import FITTED_DECIMALS
from plumbline.formats.base import Source, shown
from plumbline.observations.facts import LensFacts

LENS_VALUES = ("a", "b", "c", "d", "e", "g", "t")
PROJECTIONS = {
    0: "rectilinear",
    1: "panoramic",
    2: "circular fisheye",
    3: "full-frame fisheye",
    4: "equirectangular",
    8: "orthographic fisheye",
    10: "stereographic fisheye",
    20: "Thoby fisheye",
    21: "equisolid fisheye",
}

UNKNOWN_HFOV_DEG = 50.0
"""Stands in for an unknown field of view: a PTO must have one, and lines do not depend on it."""

STAND_IN = "# the field of view of the next image is not known: 50 degrees stand in for it"
"""Stands in a project that plumbline makes before an image without a known field of view."""

MAX_RECORDS = 2_000_000
"""Chosen: twice the million points that the benchmark `speed` reads."""
MAX_RECORD_LENGTH = 100_000
"""Bytes; chosen, a record of Hugin has some hundred, one with long paths a few thousand."""

_UNKNOWN_TYPE = "lens type f"
_QUOTED = re.compile(r'"[^"]*"?')
_VALUE = re.compile(r"(?<=[ \t])([whfvabcdegt])(\S+)")
_NAME = re.compile(r'[ \t]n"([^"]*)"')
_CROP = re.compile(r"[ \t]C(-?\d{1,9}),(-?\d{1,9}),(-?\d{1,9}),(-?\d{1,9})(?!\S)", re.ASCII)


@dataclass(frozen=True)
class ImageRecord:
    """An `i` or `o` record.

    Attributes:
        row: Line of the file, counted from 1.
        text: The line as it stands.
        values: Its numbers by name, links resolved.
        links: Which image each linked value comes from.
        name: File name of the photo.
    """

    row: int
    text: str
    values: Mapping[str, float]
    links: Mapping[str, int] = field(default_factory=dict[str, int])
    name: str = ""

    @property
    def projection(self) -> str:
        """The lens type in words."""
        number = int(self.values.get("f", 0))
        return PROJECTIONS.get(number, f"{_UNKNOWN_TYPE}{number}")

    @property
    def crop(self) -> tuple[int, int, int, int] | None:
        """Left, right, top, bottom of a crop that moves the image centre."""
        match = _CROP.search(masked(self.text))
        if match is None:
            return None
        left, right, top, bottom = (int(group) for group in match.groups())
        return left, right, top, bottom

    def facts(self, requested: tuple[str, ...] | None, crop_factor: float | None) -> LensFacts:
        """What the record says of its lens."""
        hfov = self.values.get("v")
        return LensFacts(
            hfov_deg=hfov if hfov and 0 < hfov < 180 else None,
            hfov_width_px=self.values.get("w"),
            crop_factor=crop_factor,
            stored={n: self.values[n] for n in LENS_VALUES if n in self.values},
            requested=requested,
            projection=self.projection,
        )


def lens_type(projection: str) -> int:
    """The number of a lens type; undoes `ImageRecord.projection`.

    Raises:
        OptionError: it is none that a script can name.
    """
    numbers = {name: number for number, name in PROJECTIONS.items()}
    if projection in numbers:
        return numbers[projection]
    try:
        return int(projection.removeprefix(_UNKNOWN_TYPE))
    except ValueError:
        raise OptionError(
            f"there is no lens type {shown(projection)}", hint=f"use one of {', '.join(numbers)}"
        ) from None


def line_starts(source: Source) -> NDArray[np.int64]:
    """Where each line of a script starts in its bytes, and where one more would.

    Raises:
        ReadError: the file is empty or binary, or larger than any real project.
    """
    source.refuse_binary()
    content = source.content
    if b"\0" in content:
        raise source.error("the project is UTF-16, which Hugin does not read", hint="save as UTF-8")
    n_records = content.count(b"\n") + 1
    if n_records > MAX_RECORDS:
        raise source.error(
            f"the project has {n_records:,} lines, more than the {MAX_RECORDS:,} that are read",
            hint="save the project again with fewer control points",
        )
    stops = np.flatnonzero(np.frombuffer(content, dtype=np.uint8) == ord("\n"))
    starts = np.concatenate(([0], stops + 1, [len(content) + 1]))
    many_bytes = np.flatnonzero(np.diff(starts) > MAX_RECORD_LENGTH).tolist()
    length_of = {
        row: len(decoded(content[starts[row] : starts[row + 1] - 1])) for row in many_bytes
    }
    longest = max(length_of, key=lambda row: length_of[row], default=0)
    if length_of.get(longest, 0) > MAX_RECORD_LENGTH:
        message = f"the line has {length_of[longest]:,} characters"
        raise source.error(message, longest + 1, "remove this line")
    return starts


def records(source: Source) -> list[str]:
    """The script's lines as text; `encoded` gives back the same bytes.

    Raises:
        ReadError: the file is empty or binary, or larger than any real project.
    """
    line_starts(source)
    return decoded(source.content).split("\n")


def decoded(content: bytes) -> str:
    """Part of a script as text, bytes that are not UTF-8 as surrogates."""
    return content.decode("utf-8", errors="surrogateescape")


def encoded(texts: Sequence[str]) -> bytes:
    """Undo `records`."""
    return "\n".join(texts).encode("utf-8", errors="surrogateescape")


def readable(text: str) -> str:
    """A part of a decoded script as real text; it is Latin-1 where it is not UTF-8."""
    content = encoded([text])
    try:
        return content.decode()
    except UnicodeDecodeError:
        return content.decode("latin-1")


def kind_of(text: str) -> str:
    """The kind of a record, the character before its first blank; empty for anything else."""
    bare = text.removeprefix("\ufeff")  # a byte-order mark stands before the first record
    return bare[0] if bare[1:2] in (" ", "\t") else ""


def masked(text: str) -> str:
    """The record with quoted strings blotted out, every other character in its place."""
    return _QUOTED.sub(lambda match: "_" * len(match.group()), text)


def parse_image(source: Source, row: int, text: str, earlier: Sequence[ImageRecord]) -> ImageRecord:
    """Read an image record.

    Args:
        source: The file, for messages.
        row: Line of the file, counted from 1.
        text: The line.
        earlier: The images before it, which `=N` may refer to.

    Raises:
        ReadError: a value is not a number, or a link does not point to an earlier image.
    """
    values: dict[str, float] = {}
    links: dict[str, int] = {}
    for match in _VALUE.finditer(masked(text)):
        name, value = match[1], match[2]
        if value.startswith("="):
            number = source.number(value[1:], row, what=f"the number of an image after {name}=")
            link = int(number)
            if number != int(number) or not 0 <= link < len(earlier):
                raise source.error(
                    f"{shown(name + value)} does not refer to an earlier image",
                    row,
                    hint="link to an image above this one, or give the value itself",
                )
            links[name] = earlier[link].links.get(name, link)
            if name in earlier[link].values:
                values[name] = earlier[link].values[name]
        else:
            values[name] = source.number(value, row, what=f"the value of {name}")
    found = _NAME.search(text)
    return ImageRecord(row, text, values, links, readable(found[1]) if found else "")


def size_of(source: Source, image: ImageRecord) -> tuple[int, int]:
    """Width and height of an image record.

    Raises:
        ReadError: they are missing or not positive whole numbers.
    """
    sides = [image.values.get(name, 0.0) for name in ("w", "h")]
    if any(side < 1 or side != int(side) for side in sides):
        raise source.error(
            "the image has no size: w and h must be positive whole numbers",
            image.row,
            hint="save the project again with its photo present, or write w and h by hand",
        )
    return int(sides[0]), int(sides[1])


def with_values(
    text: str,
    values: Mapping[str, float],
    keep_links: set[str],
    as_text: Callable[[float], str] | None = None,
) -> str:
    """The record with lens values set, all else as it was.

    Args:
        text: The line.
        values: Values by name; a value the line lacks is appended.
        keep_links: Names whose `=N` is left alone.
        as_text: How values are written; `fitted` by default.
    """
    as_text = as_text or fitted
    out, end = list[str](), 0
    met: set[str] = set()
    for match in _VALUE.finditer(masked(text)):
        name, old = match[1], match[2]
        if name not in values:
            continue
        met.add(name)
        linked = old.startswith("=")
        if name in keep_links if linked else float(old) == values[name]:
            continue
        out += [text[end : match.start(2)], as_text(values[name])]
        end = match.end(2)
    line = "".join(out) + text[end:]
    body = line.rstrip("\r\n \t")
    lacking = [name for name in values if name not in met]
    return body + "".join(f" {n}{as_text(values[n])}" for n in lacking) + line[len(body) :]


def decimal(value: float) -> str:
    """The shortest decimal that reads back exactly, without a trailing `.0`."""
    text = repr(float(value))
    return text.removesuffix(".0") if text != "-0.0" else "0"


def fitted(value: float) -> str:
    """A lens value in so many decimals that plumbline knows its own projects by them."""
    return "0" if value == 0 else f"{value:.{FITTED_DECIMALS}f}"

"""What a file format of picked points is, and what every reader needs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from plumbline.errors import ReadError, printable

Order = Literal["raster", "zigzag"]


@dataclass(frozen=True)
class Source:
    """A file that has been read into memory.

    Attributes:
        path: The file as named by the user, for messages.
        content: Its bytes, or those of the member that is read.
        member: Which member of an archive this is; empty where the file is none.
        photos: Pictures that stand with it in the archive, by their names without folders.
    """

    path: str
    content: bytes = field(repr=False)
    member: str = ""
    photos: Mapping[str, bytes] = field(default_factory=dict[str, bytes], repr=False)

    @property
    def suffix(self) -> str:
        """The suffix in lower case, with its dot."""
        name = (self.member or self.path).replace("\\", "/").rpartition("/")[2]
        return ("." + name.rpartition(".")[2].lower()) if "." in name else ""

    @property
    def head(self) -> str:
        """The first 4 KiB as text whatever they are, for recognising the format."""
        return self.content[:4096].decode("utf-8-sig", errors="replace")

    def refuse_binary(self) -> None:
        """Refuse what is not text in any encoding that `text` knows.

        Raises:
            ReadError: the file is empty or binary.
        """
        content = self.content
        if not content or content.isspace():
            raise self.error("the file is empty", hint="save or export the points again")
        try:
            binary = "\0" in content.decode("utf-16") if self._is_utf_16 else b"\0" in content
        except UnicodeDecodeError:
            binary = True
        if binary:
            raise self.error(
                "the file is binary, not text",
                hint="export the points as text, such as a table line,x,y",
            )

    def text(self) -> str:
        """The whole file as text: UTF-8 with or without a mark, UTF-16 with one, or Latin-1.

        Raises:
            ReadError: the file is empty or binary.
        """
        self.refuse_binary()
        if self._is_utf_16:
            return self.content.decode("utf-16")
        try:
            return self.content.decode("utf-8-sig")
        except UnicodeDecodeError:
            return self.content.decode("latin-1")

    @property
    def _is_utf_16(self) -> bool:
        return self.content.startswith((b"\xff\xfe", b"\xfe\xff"))

    def error(self, message: str, line: int | None = None, hint: str = "") -> ReadError:
        """A `ReadError` about this file, and perhaps one of its lines counted from 1."""
        path = f"{self.path}: {self.member}" if self.member else self.path
        return ReadError(message, path=path, line=line, hint=hint)

    def number(self, text: str, line: int | None = None, *, what: str = "a coordinate") -> float:
        """A finite number from text; the decimal sign is a dot.

        Raises:
            ReadError: the text is not a number, or is NaN or infinite.
        """
        try:
            # float() also takes "1_000" and other digits than 0-9, which no program writes.
            plain = text.replace("−", "-")  # as plumbline's own tables print it
            value = float(plain) if plain.isascii() and "_" not in plain else math.nan
        except ValueError:
            raise self.error(
                f"{shown(text)} stands where {what} belongs", line, "correct or remove this row"
            ) from None
        if not math.isfinite(value):
            raise self.error(f"{shown(text)} is not a finite number", line, "correct or remove it")
        return value


@dataclass(frozen=True)
class ReadOptions:
    """What a reader may need beyond the file.

    Attributes:
        size: The photo's width and height in pixels, where the user gave them.
        grid: Rows and columns of one long polyline that holds a whole grid.
        order: How that polyline runs through the grid: every row from the left, or back and
            forth.
    """

    size: tuple[int, int] | None = None
    grid: tuple[int, int] | None = None
    order: Order = "raster"


def shown(text: str, most: int = 40) -> str:
    """Text from a file, quoted, shortened and made safe for a terminal."""
    cut = text if len(text) <= most else text[: most - 1] + "…"
    return f"'{printable(cut)}'"

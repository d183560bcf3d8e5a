"""Delimited text: its separator, its rows one a line of the file, and its numbers."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

from plumbline.errors import ReadError
from plumbline.formats.base import Source, shown

MAX_LINES = 5_000_000
"""Chosen: several times the largest file that the benchmarks read."""
MAX_LINE_LENGTH = 1_000_000
"""Characters; chosen, a row of a table has a few hundred."""
_SAMPLE = 65_536
"""Characters from which the dialect is told; chosen, its first 50 rows fit."""
_QUOTED = re.compile(r'"[^"]*"')
Row = tuple[int, list[str]]
_WORD = re.compile(r'"([^"]*)"|(\S+)')


@dataclass(frozen=True)
class Table:
    """A file of rows and columns.

    Attributes:
        source: The file, for messages.
        text: Its text.
        separator: A comma, semicolon or tab; a blank stands for any run of blanks.
        comments: Whether a line that starts with `#` counts as blank.
    """

    source: Source
    text: str = field(repr=False)
    separator: str
    comments: bool = True

    @classmethod
    def of(cls, source: Source, *, comments: bool = True) -> Table:
        """The table in a file, its separator found out from the first lines.

        Raises:
            ReadError: the file is empty, binary, or longer than any real one.
        """
        text = source.text()
        lines = max(text.count("\n"), text.count("\r")) + 1
        if lines > MAX_LINES:
            raise source.error(
                f"the file has {lines:,} lines, more than the {MAX_LINES:,} that are read",
                hint="split the file",
            )
        return cls(source, text, _separator(text, comments=comments), comments)

    @classmethod
    def opening(cls, source: Source, *, comments: bool = True) -> Table:
        """The table in the first 4 KiB of a file, for recognising its format. Never raises."""
        head = source.head
        if source.content.startswith((b"\xff\xfe", b"\xfe\xff")):
            head = source.content[:4096].decode("utf-16", errors="replace")
        return cls(source, head, _separator(head, comments=comments), comments)

    def rows(self) -> Iterator[Row]:
        """Line numbers from 1 and cells; blank lines and comments have no cells.

        Raises:
            ReadError: a line is absurdly long or has an unclosed quotation mark.
        """
        lines = self._lines()
        if self.separator == " ":
            for number, line in enumerate(lines, start=1):
                yield number, _words(line)
            return
        reader = csv.reader(lines, delimiter=self.separator, skipinitialspace=True, strict=True)
        try:
            for cells in reader:
                yield reader.line_num, cells
        except csv.Error as error:
            raise self.source.error(
                f"the row cannot be split into columns: {error}", reader.line_num, "correct it"
            ) from None

    def first_rows(self, most: int) -> list[list[str]]:
        """The first rows that are not blank, cells stripped; fewer if the rest is unreadable."""
        found: list[list[str]] = []
        rows = self.rows()
        try:
            while len(found) < most:
                _, cells = next(rows)
                if any(map(str.strip, cells)):
                    found.append([cell.strip() for cell in cells])
        except (StopIteration, ReadError):
            return found
        return found

    def number_reader(self) -> Callable[[str], float]:
        """A function from a cell to a number; it raises ValueError where there is none.

        NaN and infinity pass: check them all at once. A decimal comma is read where the
        separator leaves room for it, but not beside decimal dots.
        """
        commas = "," in self.text and (self.separator != "," or '"' in self.text)
        if self.text.isascii() and "_" not in self.text and not commas:
            return float
        return _DecimalReader() if commas else _strict_float

    def bad_number(self, cells: Sequence[str], line: int) -> ReadError:
        """The `ReadError` about the first of some cells that is not a number."""
        for cell in cells:
            try:
                good = math.isfinite(_DecimalReader()(cell))
            except ValueError:
                good = False
            if not good:
                return self.source.error(
                    f"{shown(cell.strip())} stands where a coordinate belongs",
                    line,
                    "correct or remove this row",
                )
        return self.source.error(
            "a decimal comma and a decimal dot occur in the same file",
            line,
            "write all numbers with the same decimal sign",
        )

    def _lines(self) -> Iterator[str]:
        # A wrapped BytesIO splits at \n, \r\n and \r only, and needs no second copy per line.
        stream = io.TextIOWrapper(
            io.BytesIO(self.text.encode("utf-8", "replace")), "utf-8", newline=""
        )
        comments = self.comments and "#" in self.text
        quotes = '"' in self.text
        for number, line in enumerate(stream, start=1):
            if len(line) > MAX_LINE_LENGTH:
                raise self.source.error(f"the line has {len(line):,} characters", number)
            if comments and line.lstrip().startswith("#"):
                yield "\n"
                continue
            # Fields over several lines would let one stray mark swallow the file.
            if quotes and line.count('"') % 2:
                raise self.source.error(
                    "a quotation mark is not closed",
                    number,
                    'close it, or double it ("") if it belongs to a name',
                )
            yield line


def _words(line: str) -> list[str]:
    if '"' not in line:
        return line.split()
    return [quoted or plain for quoted, plain in _WORD.findall(line)]


def _separator(text: str, *, comments: bool) -> str:
    """The separator found in most of the first lines; a comma may be a decimal sign."""
    lines = [line.strip(" ") for line in text[:_SAMPLE].splitlines()[:50]]
    bare = [_QUOTED.sub("", line) for line in lines if not (comments and line.startswith("#"))]
    counts = {sign: sum(sign in line for line in bare) for sign in "\t;,"}
    best = max(counts, key=counts.__getitem__)
    return best if counts[best] else " "


def _strict_float(cell: str) -> float:
    # float() also takes "1_000" and other digits than 0-9, which no program writes.
    if "_" in cell or not cell.isascii():
        raise ValueError(cell)
    return float(cell)


class _DecimalReader:
    """Reads numbers that all have the same decimal sign, comma or dot."""

    def __init__(self) -> None:
        self.sign = ""

    def __call__(self, cell: str) -> float:
        sign = "," if "," in cell else "." if "." in cell else ""
        if sign:
            if self.sign not in {"", sign}:
                raise ValueError(cell)
            self.sign = sign
        return _strict_float(cell.replace(",", ".", 1))

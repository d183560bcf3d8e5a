"""Types of the values of options."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Any

import click

AUTO = "auto"
"""The model that `compare` recommends."""

FILE = "file"
"""The start vector that the project stores."""

_MOST = 1e7
"""Largest number that an option takes unless it says otherwise; chosen, because no length in
pixels, millimetres or metres that an option names comes near it, and its square is exact."""

if TYPE_CHECKING:
    _Type = click.ParamType[Any]
else:
    _Type = click.ParamType  # not generic in every version that will do


class Pair(_Type):
    """Two whole numbers with an x between them."""

    name = "pair"

    def __init__(self, least: int = 1) -> None:
        self.least = least

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[int, int]:
        """Read `2048x1536`."""
        if isinstance(value, tuple):
            return value
        match = re.fullmatch(r"(\d{1,7})[xX×](\d{1,7})", str(value).strip(), re.ASCII)
        if match is None or min(int(match[1]), int(match[2])) < self.least:
            self.fail(
                f"{value!r} is not two whole numbers from {self.least} up, such as 2048x1536",
                param,
                ctx,
            )
        return int(match[1]), int(match[2])


class Names(_Type):
    """Names separated by commas."""

    name = "names"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, ...]:
        """Read `a,b,c`."""
        names = tuple(part.strip() for part in str(value).split(",") if part.strip())
        if not names:
            self.fail("give at least one name, as in a,b,c", param, ctx)
        return names


class ModelName(_Type):
    """A distortion model, or `auto` where one may be chosen."""

    name = "model"

    def __init__(self, *, auto: bool) -> None:
        self.auto = auto

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Read the name of a known model."""
        from plumbline.errors import UnsupportedModelError, printable
        from plumbline.models import get_model

        if not (self.auto and value == AUTO):
            try:
                get_model(str(value))
            except UnsupportedModelError as error:
                self.fail(printable(f"{error.message}; {error.hint}"), param, ctx)
        return str(value)


class Start(_Type):
    """A start vector, or the word `file`."""

    name = "start"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> str | dict[str, float]:
        """Read `a=0.03,b=-0.1`."""
        if value == FILE:
            return FILE
        start: dict[str, float] = {}
        for part in str(value).split(","):
            name, sign, number = part.partition("=")
            try:
                start[name.strip()] = float(number.replace("−", "-"))  # as summaries print it
            except ValueError:
                sign = ""
            if not sign or not math.isfinite(start[name.strip()]):
                self.fail(f"{part!r} is not NAME=NUMBER as in a=0.03,b=-0.1", param, ctx)
        return start


class Positive(_Type):
    """A finite number above zero, up to the largest that makes sense; a decimal comma will do."""

    name = "number"

    def __init__(self, most: float = _MOST) -> None:
        self.most = most

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Read a positive number."""
        try:
            number = float(str(value).replace(",", "."))
        except ValueError:
            number = math.nan
        if not 1 / self.most <= number <= self.most:
            self.fail(f"{value!r} is not a number above 0 and up to {self.most:g}", param, ctx)
        return number


class Text(_Type):
    """A printable name."""

    name = "text"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Read a name and strip the blanks around it."""
        text = str(value).strip()
        if not text or not text.isprintable():
            self.fail("is empty, or not printable", param, ctx)
        return text


class Ratio(Positive):
    """A positive number, also written as `4:3`."""

    name = "ratio"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Read `4:3` or `1.333`."""
        over, colon, under = str(value).partition(":")
        part = Positive()
        number = part.convert(over, param, ctx)
        if colon:
            number /= part.convert(under, param, ctx)
        return super().convert(number, param, ctx)

"""Options that several verbs share, spelt once, and the types of their values."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, TypeVar

import click
from click.core import ParameterSource

_F = TypeVar("_F", bound=Callable[..., Any])

_FORMATS = "ptgui, pto, cvat, labelme, via, imagej, webplotdigitizer, winmorph, csv"


if TYPE_CHECKING:
    _Type = click.ParamType[Any]
else:
    _Type = click.ParamType  # not generic in every version that will do


class Pair(_Type):
    """Two whole numbers with an x between them."""

    name = "pair"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[int, int]:
        """Read `2048x1536`."""
        if isinstance(value, tuple):
            return value
        match = re.fullmatch(r"(\d{1,7})[xX×](\d{1,7})", str(value).strip(), re.ASCII)
        if match is None:
            self.fail(f"{value!r} is no pair of whole numbers such as 2048x1536", param, ctx)
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
            self.fail("names no coefficient; write for example a,b,c", param, ctx)
        return names


class Start(_Type):
    """A start vector, or the word `file`."""

    name = "start"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> str | dict[str, float]:
        """Read `a=0.03,b=-0.1`."""
        if value == "file":
            return "file"
        start: dict[str, float] = {}
        for part in str(value).split(","):
            name, sign, number = part.partition("=")
            try:
                start[name.strip()] = float(number)
            except ValueError:
                sign = ""
            if not sign or not math.isfinite(start[name.strip()]):
                self.fail(f"{part!r} is not NAME=NUMBER as in a=0.03,b=-0.1", param, ctx)
        return start


class Positive(_Type):
    """A finite number above zero, up to the largest that makes sense."""

    name = "number"

    def __init__(self, most: float = 1e7) -> None:
        self.most = most

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Read a positive number."""
        try:
            number = float(value)
        except ValueError:
            number = math.nan
        if not 1 / self.most <= number <= self.most:
            self.fail(f"{value!r} is no number above zero and up to {self.most:g}", param, ctx)
        return number


class Text(_Type):
    """A name that shows."""

    name = "text"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Read a name, without blanks around it."""
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
        first = super().convert(over, param, ctx)
        return first / super().convert(under, param, ctx) if colon else first


def refuse_useless(context: click.Context, what: str, useless: Iterable[str]) -> None:
    """Refuse options that were given and would be ignored.

    Args:
        context: The running command's.
        what: What has no use for them.
        useless: Their names as parameters of the command.
    """
    for parameter in context.command.params:
        given = context.get_parameter_source(parameter.name or "") is ParameterSource.COMMANDLINE
        if given and parameter.name in set(useless):
            raise click.UsageError(f"{what} has no use for {parameter.opts[0]}; leave it out")


def stacked(*options: Callable[[_F], _F]) -> Callable[[_F], _F]:
    """Several options as one decorator."""

    def decorate(function: _F) -> _F:
        for option in reversed(options):
            function = option(function)
        return function

    return decorate


reading = stacked(
    click.option(
        "--photo",
        metavar="FILE",
        help="The photograph the points were picked in; tells its size and, by EXIF, its lens.",
    ),
    click.option("--size", type=Pair(), metavar="WxH", help="Size of the photograph in pixels."),
    click.option(
        "--image",
        type=click.IntRange(min=0),
        metavar="N",
        help="Take only photo number N of the project, counted from 0.",
    ),
    click.option("--format", metavar="NAME", help=f"Format of the points: {_FORMATS}."),
    click.option(
        "--grid",
        type=Pair(),
        metavar="ROWSxCOLS",
        help="One polyline holds a whole grid of that many rows and columns (WinMorph).",
    ),
    click.option(
        "--order",
        type=click.Choice(["raster", "zigzag"]),
        default="raster",
        show_default=True,
        help="How that polyline runs: every row from the left, or back and forth.",
    ),
    click.option(
        "--pixel-aspect",
        type=Ratio(),
        default=1.0,
        metavar="RATIO",
        help="Width of a pixel over its height, for video frames; 1 by default.",
    ),
)
"""What verbs that read picked points take."""

focal = stacked(
    click.option("--focal", type=Positive(1e5), metavar="MM", help="Focal length in millimetres."),
    click.option("--focal-px", type=Positive(), metavar="PX", help="Focal length in pixels."),
    click.option(
        "--crop-factor",
        type=Positive(100),
        metavar="NUMBER",
        help="Diagonal of the 35-mm frame over that of the sensor.",
    ),
)
"""What tells the focal length, for models that measure in it."""

labelling = stacked(
    click.option("--maker", type=Text(), metavar="TEXT", help="Maker of the lens, for LensFun."),
    click.option("--lens-name", type=Text(), metavar="TEXT", help="Name of the lens, for LensFun."),
    click.option("--mount", type=Text(), metavar="TEXT", help="Mount of the lens, for LensFun."),
    focal,
    click.option(
        "--aspect-ratio",
        type=Ratio(),
        metavar="RATIO",
        help="Aspect ratio for LensFun, as 3:2 or 1.5; that of the photo by default.",
    ),
)
"""What is known of the lens, where EXIF and project are silent or wrong."""

fitting = stacked(
    click.option(
        "--model",
        default="ptlens",
        show_default=True,
        metavar="NAME",
        help="Distortion model; `plumbline models` lists them, auto takes the one that `plumbline "
        "compare` recommends.",
    ),
    click.option(
        "--free",
        type=Names(),
        metavar="NAMES",
        help="Coefficients to fit, as a,b,c; d,e is the distortion centre.",
    ),
    click.option("--hold", type=Names(), metavar="NAMES", help="Coefficients not to fit."),
)
"""What is fitted."""

lens_labels = stacked(
    click.option("--maker", type=Text(), metavar="TEXT", help="Maker of the lens, for LensFun."),
    click.option(
        "--lens-name",
        "model",
        type=Text(),
        metavar="TEXT",
        help="Name of the lens, for LensFun.",
    ),
    click.option("--mount", type=Text(), metavar="TEXT", help="Mount of the lens, for LensFun."),
    click.option(
        "--crop-factor",
        type=Positive(100),
        metavar="NUMBER",
        help="Diagonal of the 35-mm frame over that of the sensor.",
    ),
)
"""What verbs take that write a lens of several focal lengths, by the names of `LensFacts`."""

overwriting = click.option(
    "--overwrite", is_flag=True, help="Replace files that plumbline did not write."
)

plotting = click.option(
    "--plot",
    "plots",
    multiple=True,
    metavar="FILE",
    help="Draw one figure, named by the last part of FILE's stem, as in curve.svg or "
    "building.curve.png: photo, lines, curve, displacement, uncertainty, radius, along; may be "
    "given several times.",
)
"""What verbs take that draw the figures of a calibration."""

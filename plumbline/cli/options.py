"""Options that several verbs share, spelt once."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Mapping
from contextlib import contextmanager
from typing import Any, TypeVar

import click
from click.core import ParameterSource

from plumbline.cli import option_types as types
from plumbline.formats.known import POINT_FORMATS

_F = TypeVar("_F", bound=Callable[..., Any])

_BOOTSTRAP = 50, 100_000
"""Limits of `fit.bootstrap`, repeated here since importing them would load JAX for `--help`."""
_MOST_FOCAL_MM = 1e5
"""100 m; chosen, because the longest telescopes that take photographs have some tens of metres."""
_MOST_CROP = 100
"""Chosen, because the smallest sensors in use (1/10 inch) have a crop factor of about 28."""
_MOST_PIXEL_ASPECT = 100
"""Chosen, because anamorphic video stays below 3; more than 100 is a slip."""


def refuse_useless(context: click.Context, what: str, useless: Iterable[str]) -> None:
    """Refuse options that were given and would be ignored.

    Args:
        context: The running command's.
        what: The option or verb that does not use them.
        useless: Their names as parameters of the command.
    """
    for parameter in context.command.params:
        given = context.get_parameter_source(parameter.name or "") is ParameterSource.COMMANDLINE
        if given and parameter.name in set(useless):
            raise click.UsageError(f"{what} does not use {parameter.opts[0]}; leave it out")


def refuse_unknown(model: str, coefficients: Mapping[str, Iterable[str] | None]) -> None:
    """Refuse coefficients that the model does not have, or that are named for `auto`.

    Args:
        model: Name of the model.
        coefficients: Those that each option names, None where it is not given; or `file`.
    """
    from plumbline.errors import printable
    from plumbline.models import CENTRE, get_model

    given = {flag: names for flag, names in coefficients.items() if names is not None}
    if model == types.AUTO and given:
        raise click.UsageError(
            "--model auto chooses the model and its coefficients itself; leave out "
            f"{', '.join(given)}, or name the model"
        )
    known = () if model == types.AUTO else (*get_model(model).coefficients, *CENTRE)
    for flag, names in given.items():
        for name in () if names == types.FILE else names:
            if name not in known:
                raise click.UsageError(
                    printable(
                        f"{flag} names an unknown coefficient {name!r}; those of {model} are "
                        f"{', '.join(known)}"
                    )
                )


@contextmanager
def wrong_call() -> Generator[None]:
    """Turn errors raised inside into a wrong call, which exits with status 2."""
    from plumbline.errors import PlumblineError, printable

    try:
        yield
    except PlumblineError as error:
        raise click.UsageError(printable(f"{error.message}; {error.hint}")) from None


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
        help="The photograph the points were picked in; gives its size and, from EXIF, its lens.",
    ),
    click.option(
        "--size", type=types.Pair(), metavar="WxH", help="Size of the photograph in pixels."
    ),
    click.option(
        "--image",
        type=click.IntRange(min=0),
        metavar="N",
        help="Use only photo number N of the project, counted from 0.",
    ),
    click.option(
        "--format",
        type=click.Choice(POINT_FORMATS),
        metavar="NAME",
        help=f"Format of the points: {', '.join(POINT_FORMATS)}.",
    ),
    click.option(
        "--grid",
        type=types.Pair(least=2),
        metavar="ROWSxCOLS",
        help="The only line of the file holds a whole grid of that many rows and columns.",
    ),
    click.option(
        "--order",
        type=click.Choice(["raster", "zigzag"]),
        default="raster",
        show_default=True,
        help="How that line runs: every row from the left, or back and forth.",
    ),
    click.option(
        "--pixel-aspect",
        type=types.Ratio(_MOST_PIXEL_ASPECT),
        metavar="RATIO",
        help="Width of a pixel divided by its height, for video frames; 1 by default.",
    ),
)
"""Options of verbs that read picked points."""

_MAKER = click.option(
    "--maker", type=types.Text(), metavar="TEXT", help="Maker of the lens, for LensFun."
)
_MOUNT = click.option(
    "--mount", type=types.Text(), metavar="TEXT", help="Mount of the lens, for LensFun."
)
_CROP_FACTOR = click.option(
    "--crop-factor",
    type=types.Positive(_MOST_CROP),
    metavar="NUMBER",
    help="Diagonal of the 35-mm frame divided by that of the sensor.",
)


def _lens_name(*names: str) -> Callable[[_F], _F]:
    return click.option(
        "--lens-name",
        *names,
        type=types.Text(),
        metavar="TEXT",
        help="Name of the lens, for LensFun.",
    )


focal = stacked(
    click.option(
        "--focal",
        type=types.Positive(_MOST_FOCAL_MM),
        metavar="MM",
        help="Focal length in millimetres.",
    ),
    click.option("--focal-px", type=types.Positive(), metavar="PX", help="Focal length in pixels."),
    _CROP_FACTOR,
)
"""Options that give the focal length, for models that measure in it."""

labelling = stacked(
    _MAKER,
    _lens_name(),
    _MOUNT,
    focal,
    click.option(
        "--aspect-ratio",
        type=types.Ratio(),
        metavar="RATIO",
        help="Aspect ratio for LensFun, as in 3:2 or 1.5; that of the photo by default.",
    ),
)
"""Facts about the lens, where EXIF and the project lack them or have them wrong."""


def _model_option(also: str = "", *, auto: bool) -> Callable[[_F], _F]:
    return click.option(
        "--model",
        type=types.ModelName(auto=auto),
        default="ptlens",
        show_default=True,
        metavar="NAME",
        help=f"Distortion model; `plumbline models` lists them{also}.",
    )


model = _model_option(auto=False)
"""The model to fit."""

model_or_auto = _model_option(", auto fits the one that `plumbline compare` recommends", auto=True)
"""The model to fit, where it may be chosen by a comparison."""

coefficients = stacked(
    click.option(
        "--free",
        type=types.Names(),
        metavar="NAMES",
        help="Coefficients to fit, as a,b,c; d,e is the distortion centre.",
    ),
    click.option("--hold", type=types.Names(), metavar="NAMES", help="Coefficients not to fit."),
)
"""Which coefficients of a model are fitted."""

bootstrap = click.option(
    "--bootstrap",
    type=click.IntRange(*_BOOTSTRAP),
    metavar="N",
    help="Also fit N times to resampled residuals, for a second set of error bars.",
)

lens_labels = stacked(_MAKER, _lens_name("model"), _MOUNT, _CROP_FACTOR)
"""Options of verbs that write a lens of several focal lengths, named as in `LensFacts`."""

overwriting = click.option(
    "--overwrite", is_flag=True, help="Replace files that plumbline did not write."
)

plotting = click.option(
    "--plot",
    "plots",
    multiple=True,
    metavar="FILE",
    help="Draw one figure; the last part of FILE's stem names it, as in curve.svg or "
    "building.curve.png: photo, lines, curve, displacement, uncertainty, corrected, radius, "
    "along. May be given several times.",
)
"""Options of verbs that draw the figures of a calibration."""

assignment = stacked(
    click.option(
        "--case",
        type=types.Text(),
        metavar="TEXT",
        help="Name or number of the case, for the report.",
    ),
    click.option(
        "--examiner",
        type=types.Text(),
        metavar="TEXT",
        help="Who calibrated, for the report.",
    ),
)
"""What a report is for."""

results = stacked(
    click.option(
        "-o",
        "--output",
        multiple=True,
        metavar="FILE",
        help="Write this file (.pto, .xml or .json); may be given several times.",
    ),
    click.option(
        "--report",
        metavar="FILE",
        help="Write a report: one HTML page with figures, tables and checksums.",
    ),
    assignment,
)
"""Options of verbs that fit a lens, for its files."""

printing = stacked(
    click.option("--json", "as_json", is_flag=True, help="Print the result as JSON."),
    click.option("-v", "--verbose", is_flag=True, help="List every line, however many."),
    click.option("-q", "--quiet", is_flag=True, help="Print only the finding and the files."),
)
"""Options of verbs that fit a lens, for what they print."""

_DELIVERY = (
    *("output", "report", "plots", "case", "examiner", "overwrite", "as_json", "verbose", "quiet"),
)


def delivery(how: dict[str, Any]) -> dict[str, Any]:
    """The values of `results`, `plotting`, `overwriting` and `printing`, taken out of all."""
    if how["report"] is None:
        context = click.get_current_context()
        refuse_useless(context, f"{context.info_name} without --report", ["case", "examiner"])
    return {name: how.pop(name) for name in _DELIVERY}

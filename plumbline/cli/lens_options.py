"""Options about the lens of a photo, shared by `lens` and `correct`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from plumbline.cli.option_types import Pair, Positive, Start
from plumbline.cli.options import stacked

if TYPE_CHECKING:
    from plumbline.lenses.request import LensRequest

choosing = stacked(
    click.option(
        "--lens",
        metavar="SOURCE",
        help="Use the lens in this file: a result or zoom JSON, a Hugin or PTGui project, a "
        "LensFun XML file or folder, a PTLens profile, a Hugin lens .ini.",
    ),
    click.option(
        "--ptlens",
        type=Start(),
        metavar="VALUES",
        help="Use these coefficients, as in a=0,b=-0.02,c=0; d and e in the stored photo's pixels.",
    ),
    click.option("--camera", metavar="NAME", help="Maker and model, where EXIF lacks them."),
    click.option("--lens-name", metavar="NAME", help="Name of the lens, where several match."),
    click.option(
        "--like", metavar="CAMERA", help="Use the lens of this comparable camera instead."
    ),
    click.option("--focal", type=Positive(), metavar="MM", help="Focal length in millimetres."),
    click.option(
        "--crop-factor",
        type=Positive(),
        metavar="NUMBER",
        help="Diagonal of the 35-mm frame divided by that of the part of the sensor that the "
        "photo shows.",
    ),
    click.option(
        "--full-size",
        type=Pair(),
        metavar="WxH",
        help="Size of the uncropped picture, at the photo's scale, where the photo is a crop.",
    ),
)
"""What verbs that look up a lens take; `request_of` makes a request of their values."""


def request_of(
    lens: str | None,
    ptlens: Any,
    camera: str | None,
    lens_name: str | None,
    like: str | None,
    focal: float | None,
    crop_factor: float | None,
    full_size: tuple[int, int] | None,
) -> LensRequest:
    """The request that the options of `choosing` stand for."""
    from plumbline.lenses.request import LensRequest

    if isinstance(ptlens, str):
        raise click.BadParameter("give coefficients as a=0,b=-0.02,c=0", param_hint="--ptlens")
    if ptlens is not None:
        found_by = {"--lens": lens, "--camera": camera, "--lens-name": lens_name, "--like": like}
        useless = [name for name, value in (found_by | {"--focal": focal}).items() if value]
        if useless:
            raise click.UsageError(f"--ptlens already gives the lens; leave out {useless[0]}")
    return LensRequest(lens, ptlens, camera, lens_name, like, focal, crop_factor, full_size)

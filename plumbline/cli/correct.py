"""`plumbline correct`."""

from __future__ import annotations

import os
from typing import Any

import click

from plumbline.cli import lens_options, option_types, options

_HELP = """Take the lens distortion out of photographs.

PHOTO is a photograph or a folder of them. --lens names the lens: a calibration that `fit` wrote, a
Hugin project or lens file, a LensFun file or folder, a PTLens profile. Without it, plumbline looks
the photo's EXIF up in your own calibrations and in LensFun's database. Results go beside the
originals as NAME_corrected; metadata are kept, originals are never touched.

\b
Examples:
  plumbline correct facade.jpg --lens building.json
  plumbline correct photos/ -o corrected/ --jobs 4 --skip-existing
  plumbline correct facade.jpg --ptlens a=0,b=-0.02,c=0 --scale fit -o facade.png
  plumbline correct facade.jpg --points picks.csv --lens building.json
"""

_ABOUT_LENS = (
    *("lens", "ptlens", "camera", "lens_name", "like"),
    *("focal", "crop_factor", "full_size"),
)
_FOR_PICTURES = {
    *("interpolation", "border", "quality", "difference", "jobs", "scheduler", "skip_existing"),
}
_USELESS = {
    "points": ("--points", {*_FOR_PICTURES, "scale"}),
    "map_file": ("--map", {*_FOR_PICTURES, "output", "suffix"}),
    "scheduler": ("--scheduler", {"jobs"}),
}
"""Options that another one makes useless: its parameter, its name, and theirs."""


@click.command("correct", help=_HELP)
@click.argument("photos", nargs=-1, metavar="[PHOTO]...")
@lens_options.choosing
@click.option(
    "-o", "--output", metavar="PATH", help="File or folder to write; beside the photo by default."
)
@click.option(
    "--suffix",
    metavar="TEXT",
    help="Suffix of the names of results: _corrected by default, none in a folder given by -o.",
)
@click.option(
    "--interpolation",
    type=click.Choice(["cubic", "lanczos", "linear", "nearest"]),
    default="cubic",
    show_default=True,
    help="Interpolation method.",
)
@click.option(
    "--scale",
    type=click.Choice(["keep", "fit", "fill"]),
    default="keep",
    show_default=True,
    help="Keep the scale at the gauge radius, fit the whole photo in, or fill the frame.",
)
@click.option(
    "--border",
    type=click.Choice(["black", "white", "transparent", "edge"]),
    default="black",
    show_default=True,
    help="What to draw where the photo shows nothing.",
)
@click.option(
    "--quality",
    type=click.IntRange(1, 100),
    default=95,
    show_default=True,
    help="Quality of JPEG and WebP.",
)
@click.option("--inverse", is_flag=True, help="Apply the distortion instead of removing it.")
@click.option(
    "--difference", is_flag=True, help="Also write a PNG of the difference, dark on white."
)
@click.option(
    "--map",
    "map_file",
    metavar="FILE",
    help="Write the sampling map instead: an ST map (.tif), or pixels (.npz).",
)
@click.option(
    "--points", metavar="FILE", help="Correct picked points instead of pixels, and write a CSV."
)
@click.option(
    "--size", type=option_types.Pair(), metavar="WxH", help="Size of the photo of --points."
)
@click.option(
    "--jobs",
    type=click.IntRange(min=1),
    metavar="N",
    help="Number of processes for several photos; one per core by default.",
)
@click.option(
    "--scheduler",
    metavar="ADDRESS",
    help="Dask scheduler whose workers correct the photos, as in tcp://host:8786.",
)
@click.option("--skip-existing", is_flag=True, help="Skip photos whose result exists.")
@options.overwriting
@click.option("-q", "--quiet", is_flag=True, help="Print only errors and the summary.")
def command(
    photos: tuple[str, ...],
    map_file: str | None,
    points: str | None,
    size: tuple[int, int] | None,
    **how: Any,
) -> None:
    """Find the lens, correct, print."""
    # The pixels are OpenCV's work; threads of BLAS would only wait for each other.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from plumbline.cli.tools import correct as correcting
    from plumbline.errors import OptionError

    context = click.get_current_context()
    for name, (option, useless) in _USELESS.items():
        if context.params[name] is not None:
            options.refuse_useless(context, option, useless)
    if points is not None and how["output"] is not None:
        options.refuse_useless(context, "--points with -o", ["suffix"])
    request = lens_options.request_of(**{name: how.pop(name) for name in _ABOUT_LENS})
    first, *others = photos or ("",)
    if points is not None:
        if map_file is not None or others:
            raise OptionError("--points takes at most one photo, and not --map")
        correcting.points(points, first or None, size, request, how)
    elif not photos:
        raise click.UsageError("name a photo, a folder, or points with --points")
    elif size is not None:
        raise OptionError("--size belongs to --points", hint="leave it out")
    elif map_file is None:
        correcting.pictures(photos, request, how)
    elif others:
        raise OptionError("--map writes the map of one photo", hint="name one photo")
    else:
        correcting.sampling_map(first, map_file, request, how)

"""`plumbline pair`."""

from __future__ import annotations

from typing import Any

import click

from plumbline.cli import option_types, options

_HELP = """Calibrate from a photograph and the same one corrected.

ORIGINAL is the picture as the lens shows it, such as a raw file's development, and CORRECTED the
same one after a correction: the camera's own JPEG, or what another program made of it. They may be
of different sizes, the second enlarged, cropped and shifted. Thousands of points are matched, and
the lens that the correction was made for is fitted to them.

\b
Examples:
  plumbline pair developed.jpg camera.jpg
  plumbline pair developed.jpg camera.jpg --model brown -o lens.json --report lens.html
  plumbline pair developed.jpg --points pairs.csv
"""


@click.command("pair", help=_HELP)
@click.argument("original", required=False)
@click.argument("corrected", required=False)
@click.option(
    "--points",
    metavar="FILE",
    help="Take matched points from a CSV of x,y,X,Y instead: pixels of original and corrected.",
)
@click.option(
    "--size",
    type=option_types.Pair(),
    metavar="WxH",
    help="Size of the original in pixels, for --points without it.",
)
@options.model
@options.coefficients
@options.labelling
@options.results
@options.plotting
@options.overwriting
@options.printing
def command(
    original: str | None,
    corrected: str | None,
    points: str | None,
    size: tuple[int, int] | None,
    model: str,
    free: tuple[str, ...] | None,
    hold: tuple[str, ...] | None,
    **how: Any,
) -> None:
    """Match, fit, write, print."""
    from rich.console import Console

    from plumbline.cli.tools.deliver import deliver, refuse_unclear
    from plumbline.pairs.files import calibrate_pair_files, from_points
    from plumbline.reading.gathering import labels_of

    if points is not None and corrected is not None:
        raise click.UsageError("--points takes the original alone, for its size and EXIF")
    if points is None and size is not None:
        raise click.UsageError("--size belongs to --points; leave it out")
    options.refuse_unknown(model, {"--free": free, "--hold": hold})
    delivery = options.delivery(how)
    with options.wrong_call():
        refuse_unclear(delivery["output"], delivery["report"], delivery["plots"])
    fit: dict[str, Any] = {"model": model, "free": free, "hold": hold or ()}
    labels = labels_of(how)
    narration = Console(stderr=True)
    with narration.status("Matching…"):
        if points is not None:
            calibration = from_points(points, original, size, labels, **fit)
        elif original is not None and corrected is not None:
            calibration = calibrate_pair_files(original, corrected, labels=labels, **fit)
        else:
            raise click.UsageError("name an original and a corrected picture, or --points FILE")
    deliver([calibration], original or points or "", narration, photo=original, **delivery)

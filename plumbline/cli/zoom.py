"""`plumbline zoom`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from plumbline.cli import options

_HELP = """Join calibrations at several focal lengths into one lens.

RESULT: JSON files that `fit` wrote. Several at one focal length, even from different specimens of a
camera, are pooled by their covariances, and their scatter is printed. Each coefficient is
interpolated over focal length; focal lengths where another calibration is most needed are named.

The suffix of -o chooses what is written: .json for `correct --lens`, .xml for LensFun, .txt for the
script of LensFun's contributors (lenses.txt).

\b
Examples:
  plumbline zoom 18mm.json 35mm.json 55mm.json -o zoom.json -o zoom.xml
  plumbline zoom *.json --method polynomial --degree 3 --plot zoom.svg
"""


@click.command("zoom", help=_HELP)
@click.argument("results", nargs=-1, required=True, metavar="RESULT…")
@click.option(
    "--method",
    type=click.Choice(["linear", "hermite", "polynomial"]),
    default="hermite",
    show_default=True,
    help="How to interpolate coefficients over focal length: linearly, by LensFun's Hermite "
    "spline, or by a polynomial weighted by the standard errors.",
)
@click.option(
    "--degree",
    type=click.IntRange(0, 20),
    default=3,
    show_default=True,
    help="Degree of the polynomial.",
)
@click.option("--plot", metavar="FILE", help="Plot the coefficients with error bars (.png, .svg).")
@options.lens_labels
@click.option(
    "-o",
    "--output",
    multiple=True,
    metavar="FILE",
    help="Write this file (.json, .xml or .txt); may be given several times.",
)
@options.overwriting
def command(
    results: tuple[str, ...],
    method: Any,
    degree: int,
    plot: str | None,
    output: tuple[str, ...],
    overwrite: bool,
    **labels: Any,
) -> None:
    """Read, join, print, write."""
    if method != "polynomial":
        options.refuse_useless(click.get_current_context(), f"--method {method}", ["degree"])
    from plumbline.errors import printable
    from plumbline.files import refuse_to_clobber, refuse_unknown_suffix, write_atomically
    from plumbline.report.figures.zoom import PLOT_SUFFIXES, plot_zoom
    from plumbline.report.terminal.summary import WideConsole
    from plumbline.report.terminal.zoom import print_zoom
    from plumbline.writing.zoom import ZOOM_SUFFIXES, read_zoom_lens, zoom_bytes

    with options.wrong_call():
        for name in output:
            refuse_unknown_suffix(Path(name), ZOOM_SUFFIXES, "zoom lenses")
        if plot is not None:
            refuse_unknown_suffix(Path(plot), PLOT_SUFFIXES, "plots")
    lens = read_zoom_lens(results, method, degree, labels)
    contents: dict[Path, bytes] = {}
    notes: list[str] = []
    for name in output:
        content, more = zoom_bytes(lens, Path(name))
        contents[Path(name)] = content
        notes += more
    if plot is not None:
        contents[Path(plot)] = plot_zoom(lens, Path(plot))
    for target in contents:
        refuse_to_clobber(target, results, overwrite=overwrite)
    write_atomically(contents)
    print_zoom(WideConsole(), lens)
    for note in dict.fromkeys(notes):
        click.echo(f"Note: {printable(note)}.")
    for target in contents:
        click.echo(f"Wrote {printable(str(target))}")

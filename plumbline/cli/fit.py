"""`plumbline fit`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from plumbline.cli import options

_HELP = """Find the distortion that makes picked lines straight.

POINTS is a Hugin project with straight-line control points, a CSV of line,x,y, or what a viewer
exports. Several files are photos of one lens, fitted together. The result goes beside the first
input, as a Hugin project (building.fit.pto) and a LensFun profile (building.fit.xml), unless -o
names others.

\b
Examples:
  plumbline fit building.pto
  plumbline fit picks.csv --photo facade.jpg --model poly3
  plumbline fit building.pto --free b -o b_alone.json
  plumbline fit building.pto --start a=0.03,b=-0.1,c=0.05
  plumbline fit building.pto --report building.html --plot building.curve.svg
"""


@click.command(
    "fit", help=_HELP, short_help="Find the distortion that makes picked lines straight."
)
@click.argument("points", nargs=-1, required=True)
@click.option(
    "--model",
    default="ptlens",
    show_default=True,
    metavar="NAME",
    help="Distortion model; `plumbline models` lists them.",
)
@click.option(
    "--free",
    type=options.Names(),
    metavar="NAMES",
    help="Coefficients to fit, as a,b,c; d,e is the distortion centre.",
)
@click.option("--hold", type=options.Names(), metavar="NAMES", help="Coefficients not to fit.")
@click.option(
    "--start",
    type=options.Start(),
    metavar="VECTOR",
    help="Start vector as a=0.03,b=-0.1, or `file` for the project's; from zero by default.",
)
@click.option(
    "--residual",
    type=click.Choice(["image", "corrected"]),
    default="image",
    show_default=True,
    help="Measure straightness in the photograph's pixels, or in the corrected photo's.",
)
@options.reading
@options.labelling
@click.option(
    "-o",
    "--output",
    multiple=True,
    metavar="FILE",
    help="Write this file (.pto, .xml or .json); may be given several times.",
)
@click.option(
    "--report",
    metavar="FILE",
    help="Write a report: one HTML page with figures, tables and checksums.",
)
@options.plotting
@options.overwriting
@click.option("--json", "as_json", is_flag=True, help="Print the result as JSON.")
@click.option("-v", "--verbose", is_flag=True, help="List every line, however many.")
@click.option("-q", "--quiet", is_flag=True, help="Print only the finding and the files.")
def command(
    points: tuple[str, ...],
    model: str,
    free: tuple[str, ...] | None,
    hold: tuple[str, ...] | None,
    start: Any,
    residual: Any,
    output: tuple[str, ...],
    report: str | None,
    plots: tuple[str, ...],
    overwrite: bool,
    as_json: bool,
    verbose: bool,
    quiet: bool,
    image: int | None,
    maker: str | None,
    lens_name: str | None,
    mount: str | None,
    focal: float | None,
    focal_px: float | None,
    crop_factor: float | None,
    aspect_ratio: float | None,
    **how: Any,
) -> None:
    """Read, fit, write, print."""
    from rich.console import Console

    from plumbline.cli.pipeline import (
        command_line,
        gather,
        name_the_source,
        split_by_lens,
        write_results,
    )
    from plumbline.errors import PlumblineError, printable
    from plumbline.models import get_model
    from plumbline.report.terminal import WideConsole, print_summary
    from plumbline.report.writing import check_targets, report_contents
    from plumbline.writing import refuse_unsettled

    get_model(model)
    check_targets(report, plots)
    labels = {
        "maker": maker,
        "model": lens_name,
        "mount": mount,
        "focal_mm": focal,
        "focal_px": focal_px,
        "crop_factor": crop_factor,
        "aspect_ratio": aspect_ratio,
    }
    parts = split_by_lens(gather(points, image, **how), labels)
    narration = Console(stderr=True)
    with narration.status("Fitting…"):
        from plumbline.fit.calibrate import calibrate

        calibrations = []
        for part in parts:
            try:
                made = calibrate(
                    part, model, free=free, hold=hold or (), start=start, residual=residual
                )
            except PlumblineError as error:
                raise name_the_source(error, part, len(parts)) from None
            calibrations.append(replace(made, command=command_line()))
    refuse_unsettled(calibrations)
    drawn: dict[Path, bytes] = {}
    unseen: list[str] = []
    if report is not None or plots:
        with narration.status("Drawing…"):
            drawn, unseen = report_contents(
                calibrations, report, plots, photo=how["photo"], overwrite=overwrite
            )
    written, notes = write_results(calibrations, output, points[0], drawn, overwrite=overwrite)
    notes += unseen
    if as_json:
        from plumbline.result_json import to_json

        click.echo(to_json(calibrations), nl=False)
        for note in notes:
            click.echo(f"Note: {printable(note)}.", err=True)
        for path in written:
            click.echo(f"Wrote {printable(str(path))}", err=True)
        return
    print_summary(WideConsole(), calibrations, written, notes, verbose=verbose, quiet=quiet)

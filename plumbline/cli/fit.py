"""`plumbline fit`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from plumbline.cli import option_types, options

_HELP = """Find the distortion that makes picked lines straight.

POINTS is a Hugin project with straight-line control points, a CSV of line,x,y, or a viewer's
export. Several files are taken as photos of one lens and fitted together. The result goes beside
the first input, as a Hugin project (building.fit.pto) and a LensFun profile (building.fit.xml),
unless -o names other files.

\b
Examples:
  plumbline fit building.pto
  plumbline fit picks.csv --photo facade.jpg --model poly3
  plumbline fit building.pto --free b -o b_alone.json
  plumbline fit building.pto --start a=0.03,b=-0.1,c=0.05
  plumbline fit building.pto --robust --model auto
  plumbline fit picks.csv --photo facade.jpg --snap
  plumbline fit building.pto --report building.html --plot building.curve.svg
"""


@click.command("fit", help=_HELP)
@click.argument("points", nargs=-1, required=True)
@options.model_or_auto
@options.coefficients
@click.option(
    "--start",
    type=option_types.Start(),
    metavar="VECTOR",
    help="Start vector, as in a=0.03,b=-0.1, or `file` for the project's; zero by default.",
)
@click.option(
    "--residual",
    type=click.Choice(["image", "corrected"]),
    default="image",
    show_default=True,
    help="Measure straightness in pixels of the photograph, or of the corrected photo.",
)
@click.option("--robust", is_flag=True, help="Leave suspicious picks out and list them.")
@click.option("--snap", is_flag=True, help="Move the picks onto the photograph's edges first.")
@options.bootstrap
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
    robust: bool,
    snap: bool,
    bootstrap: int | None,
    output: tuple[str, ...],
    report: str | None,
    plots: tuple[str, ...],
    overwrite: bool,
    as_json: bool,
    verbose: bool,
    quiet: bool,
    **reading: Any,
) -> None:
    """Read, fit, write, print."""
    from rich.console import Console

    from plumbline.cli.tools.fit import Wishes, fit_lenses
    from plumbline.cli.tools.report import draw
    from plumbline.errors import printable
    from plumbline.files import refuse_unknown_suffix
    from plumbline.reading.gathering import parts_of
    from plumbline.report.terminal.summary import WideConsole, print_summary
    from plumbline.writing.beside import command_line, write_results
    from plumbline.writing.results import RESULT_SUFFIXES, refuse_unsettled

    options.refuse_unknown(model, {"--free": free, "--hold": hold, "--start": start})
    with options.wrong_call():
        for target in output:
            refuse_unknown_suffix(Path(target), RESULT_SUFFIXES, "results")
        if report is not None or plots:
            from plumbline.report.writing import check_targets

            check_targets(report, plots)
    wishes = Wishes(model, free, hold or (), start, residual, robust, bootstrap)
    narration = Console(stderr=True)
    parts = parts_of(points, reading)
    if snap:
        from plumbline.cli.tools.snap import snapped

        parts = [each.observations for each in snapped(parts, reading["photo"], narration)]
    made = fit_lenses(parts, wishes, narration)
    calibrations = [replace(each, command=command_line()) for each in made]
    refuse_unsettled(calibrations)
    drawn: dict[Path, bytes] = {}
    unseen: list[str] = []
    if report is not None or plots:
        drawn, unseen = draw(
            calibrations, report, plots, narration, photo=reading["photo"], overwrite=overwrite
        )
    written, notes = write_results(calibrations, output, points[0], drawn, overwrite=overwrite)
    notes += unseen
    if as_json:
        from plumbline.result.writing import to_json

        click.echo(to_json(calibrations), nl=False)
        for note in notes:
            click.echo(f"Note: {printable(note)}.", err=True)
        for path in written:
            click.echo(f"Wrote {printable(str(path))}", err=True)
        return
    print_summary(WideConsole(), calibrations, written, notes, verbose=verbose, quiet=quiet)

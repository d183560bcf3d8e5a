"""`plumbline report`."""

from __future__ import annotations

from pathlib import Path

import click

from plumbline.cli import options

_HELP = """Show a calibration as a page with figures, tables and checksums.

RESULT is a JSON that `fit` or `rectify` wrote (-o building.json). The page is one self-contained
HTML file; print it from any browser. It goes beside RESULT unless -o names another.
The photo is looked for by its name, beside RESULT and beside the points; without it, figures
show an empty frame. With --plot and without -o, only those figures are written.

\b
Examples:
  plumbline report building.json
  plumbline report building.json -o report.html --photo photos/facade.jpg
  plumbline report building.json --plot curve.svg --plot building.photo.png
"""


@click.command("report", help=_HELP)
@click.argument("result")
@click.option("-o", "--output", metavar="FILE", help="Write the page to this file (.html).")
@options.plotting
@click.option("--photo", metavar="FILE", help="The photograph, where it is not found by its name.")
@options.assignment
@options.overwriting
def command(
    result: str,
    output: str | None,
    plots: tuple[str, ...],
    photo: str | None,
    case: str | None,
    examiner: str | None,
    overwrite: bool,
) -> None:
    """Read, draw, write."""
    from rich.console import Console

    from plumbline.cli.tools.ground_report import draw_ground, is_rectification
    from plumbline.cli.tools.report import draw
    from plumbline.errors import printable
    from plumbline.files import write_atomically
    from plumbline.report.writing import check_targets
    from plumbline.result.files import read_calibrations

    page = output
    if page is None and not plots:
        page = str(Path(result).with_suffix(".html"))
    with options.wrong_call():
        check_targets(page, plots)
    if is_rectification(result):
        if plots:
            raise click.UsageError("--plot is for calibrations; leave it out")
        target = draw_ground(result, output, photo, overwrite=overwrite)
        click.echo(f"Wrote {printable(str(target))}")
        return
    calibrations = read_calibrations(result)
    contents, notes = draw(
        calibrations,
        page,
        plots,
        Console(stderr=True),
        photo=photo,
        source=result,
        case=case or "",
        examiner=examiner or "",
        overwrite=overwrite,
    )
    write_atomically(contents)
    for note in notes:
        click.echo(f"Note: {printable(note)}.", err=True)
    for target in contents:
        click.echo(f"Wrote {printable(str(target))}")

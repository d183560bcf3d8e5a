"""`plumbline snap`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from plumbline.cli import options

_HELP = """Move picks onto the photograph's edges, to a small part of a pixel.

POINTS is any file that `fit` reads; its photograph is --photo, or lies beside it. Each line is
traced between its picks: steps of light, grooves and wires, also where they are interrupted. A
line whose edge cannot be told keeps its picks, and the reason is printed.

\b
Examples:
  plumbline snap picks.csv --photo facade.jpg -o picks.json
  plumbline snap building.pto
"""


@click.command("snap", help=_HELP)
@click.argument("points")
@options.reading
@click.option(
    "-o",
    "--output",
    metavar="FILE",
    help="Write this file (.json, .csv or .pto); POINTS.snapped.json by default.",
)
@options.overwriting
@click.option("-q", "--quiet", is_flag=True, help="Print only how many lines and the file.")
def command(
    points: str,
    output: str | None,
    overwrite: bool,
    quiet: bool,
    image: int | None,
    **how: Any,
) -> None:
    """Read points, snap them, write them."""
    from rich.console import Console

    from plumbline.cli.tools.snap import described, snapped
    from plumbline.errors import printable
    from plumbline.files import refuse_unknown_suffix
    from plumbline.reading.points import read
    from plumbline.wording import count
    from plumbline.writing.results import POINT_SUFFIXES, points_bytes, write_points

    target = Path(output) if output else Path(points).with_suffix(".snapped.json")
    with options.wrong_call():
        refuse_unknown_suffix(target, POINT_SUFFIXES, "points")
    observations = read([points], image=image, **how)
    points_bytes(observations, target, overwrite=overwrite)  # refuses before the work, not after
    result = snapped([observations], how["photo"], Console(stderr=True))[0]
    written = write_points(result.observations, target, overwrite=overwrite)
    if not quiet:
        for sentence in described(result):
            click.echo(printable(sentence))
    for note in dict.fromkeys((*observations.notes, *result.notes)):
        click.echo(f"Note: {printable(note)}.", err=True)
    click.echo(
        f"Wrote {printable(str(written))}: {result.n_snapped} of "
        f"{count(len(result.lines), 'line')} snapped, "
        f"{count(result.observations.n_points, 'point')}."
    )
    click.echo(f"Next: plumbline fit {printable(str(written))}")

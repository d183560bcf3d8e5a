"""`plumbline convert`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from plumbline.cli import options

_HELP = """Convert picked points to CSV, JSON or a Hugin project.

SOURCE is any file that `fit` reads, a result JSON too; the suffix of TARGET, .csv, .json or .pto,
chooses the format. JSON keeps all that is known of the photos and the lens. In a Hugin project
each line becomes a straight line (t3, t4, …) of paired points, with the photo attached and
a, b, c (or what SOURCE asks for) marked for optimising.

\b
Example:
  plumbline convert grid.mrf grid.pto --photo facade.jpg --grid 7x9
"""


@click.command("convert", help=_HELP)
@click.argument("source")
@click.argument("target")
@options.reading
@options.overwriting
def command(source: str, target: str, overwrite: bool, image: int | None, **how: Any) -> None:
    """Read points and write them."""
    from plumbline.errors import printable
    from plumbline.files import refuse_unknown_suffix
    from plumbline.reading.points import read
    from plumbline.wording import count
    from plumbline.writing.results import POINT_SUFFIXES, resampling_notes, write_points

    with options.wrong_call():
        refuse_unknown_suffix(Path(target), POINT_SUFFIXES, "points")
    observations = read(source, image=image, **how)
    written = write_points(observations, target, overwrite=overwrite)
    notes = list(observations.notes)
    if written.suffix.lower() == ".pto":
        notes += resampling_notes(observations)
    for note in notes:
        click.echo(f"Note: {printable(note)}.", err=True)
    click.echo(
        f"Wrote {printable(str(written))}: {count(observations.n_points, 'point')} on "
        f"{count(len(observations.lines), 'line')}."
    )
    width, height = observations.photos[0].frame.size
    size = f" --size {width}x{height}" if written.suffix.lower() == ".csv" else ""
    click.echo(f"Next: plumbline fit {printable(str(written))}{size}")

"""`plumbline find`."""

from __future__ import annotations

from typing import Any

import click

from plumbline.cli import options

_HELP = """Find a photograph's long straight edges without picks.

Edges that a lens bends are found over the whole width of the photo, measured to a small part of a
pixel, and written as points; a drawing shows them. The last line says how far the lens they tell
can be trusted, or what the photo lacks. `fit PHOTO` does this and fits, where they can be trusted.

\b
Examples:
  plumbline find facade.jpg
  plumbline find facade.jpg -o edges.csv --overlay edges.png
"""


@click.command("find", help=_HELP)
@click.argument("photo")
@click.option(
    "-o",
    "--output",
    metavar="FILE",
    help="Write the points here (.json, .csv or .pto); PHOTO.found.json by default.",
)
@click.option(
    "--overlay",
    metavar="FILE",
    help="Write the drawing here (.jpg or .png); PHOTO.found.jpg by default.",
)
@options.overwriting
def command(photo: str, overwrite: bool, **where: Any) -> None:
    """Find edges, write and draw them."""
    from rich.console import Console

    from plumbline.cli.tools import find as tool
    from plumbline.errors import printable
    from plumbline.files import write_atomically

    with options.wrong_call():
        targets = tool.Targets.of(photo, where["output"], where["overlay"])
    targets.refuse_to_clobber(photo, overwrite=overwrite)
    found = tool.found_in(photo, Console(stderr=True))
    files = tool.contents(found, targets, overwrite=overwrite)
    write_atomically(files)
    for note in found.notes:
        click.echo(f"Note: {printable(note)}.", err=True)
    click.echo(f"Found {printable(tool.sentence(found))}.")
    for path in files:
        click.echo(f"Wrote {printable(str(path))}")
    if targets.points in files:
        click.echo(f"Next: look at {targets.overlay}, then plumbline fit {targets.points}")

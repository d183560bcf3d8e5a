"""`plumbline pick`."""

from __future__ import annotations

import os
from typing import Any

import click

from plumbline.cli import options

_HELP = """Pick lines on a page in the browser, with the fit running while you click.

PHOTO is a photograph, or several of one lens; POINTS a file of picks in any format, to go on with
those. Click near one end of a straight edge, then near the other. Every action is saved at once
beside the photo (facade.plumbline.json), and the next call goes on there. Finish writes what
`fit` writes (facade.fit.pto, facade.fit.xml) and a report (facade.fit.html).

The page is on 127.0.0.1 behind a secret address; nothing leaves this machine. Ctrl-C stops it.

\b
Examples:
  plumbline pick facade.jpg
  plumbline pick facade.jpg picks.csv
  plumbline pick facade.jpg --no-browser --port 8080
"""


@click.command(
    "pick",
    help=_HELP,
)
@click.argument("sources", metavar="PHOTO... [POINTS]", nargs=-1, required=True)
@click.option("--no-browser", is_flag=True, help="Print the page's address, and open no browser.")
@click.option(
    "--port",
    type=click.IntRange(0, 65535),
    default=0,
    metavar="N",
    help="Listen on this port; on any that is free by default.",
)
@options.labelling
def command(sources: tuple[str, ...], no_browser: bool, port: int, **labels: Any) -> None:
    """Open, serve, until stopped."""
    # Products here are small; NumPy's threads would only spin on the core that judges the picks.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from plumbline.pick.opening import open_session
    from plumbline.pick.serving import serve
    from plumbline.reading.gathering import labels_of

    def announce(address: str, opened: bool) -> None:
        click.echo(f"Picking at {address}")
        if not (opened or no_browser):
            click.echo("No browser could be opened: open this address in one yourself.")
        click.echo("Ctrl-C stops; every action is saved.")

    session = open_session(sources, labels_of(labels))
    serve(session, port, announce, browser=not no_browser)

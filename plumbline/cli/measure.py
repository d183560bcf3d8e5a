"""`plumbline measure`."""

from __future__ import annotations

from typing import Any

import click

from plumbline.cli import option_types as types, options

_HELP = """Measure places, distances, angles and areas in a rectified photograph.

PICKS holds points of the same photo, as x,y,name in pixels; the points of the rectification have
names too. Every value comes with its standard error and its 95 % interval, every place with its
95 % ellipse: they hold the errors of picks, points, lens and camera, and the plane's unevenness.
Without a quantity, all places and the distances from each pick to the next are measured.

\b
Examples:
  plumbline measure picks.csv --from road_rectified.json
  plumbline measure picks.csv --from road_rectified.json --distance S1,S2 --area A,B,C,D
  plumbline measure --from road_rectified.json --angle A,B,C -o measured.csv
"""


@click.command("measure", help=_HELP)
@click.argument("picks", required=False)
@click.option(
    "--from",
    "saved",
    required=True,
    metavar="FILE.json",
    help="The rectification that rectify saved.",
)
@click.option("--place", type=types.Names(), multiple=True, metavar="A", help="Where a point lies.")
@click.option(
    "--distance", type=types.Names(), multiple=True, metavar="A,B", help="From A to B, metres."
)
@click.option("--angle", type=types.Names(), multiple=True, metavar="A,B,C", help="At B, degrees.")
@click.option(
    "--area", type=types.Names(), multiple=True, metavar="A,B,C,…", help="Of a polygon, m²."
)
@click.option(
    "-o",
    "--output",
    metavar="FILE",
    help="Also write them: .csv, .json, .dxf, or .html, the report with them.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the values as JSON.")
@options.overwriting
def command(picks: str | None, saved: str, as_json: bool, **how: Any) -> None:
    """Read, measure, print."""
    from plumbline.cli.tools import measure

    measure.run(picks, saved, how, as_json=as_json)

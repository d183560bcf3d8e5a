"""`plumbline fit`."""

from __future__ import annotations

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
  plumbline fit facade.jpg
  plumbline fit building.pto --report building.html --plot building.curve.svg
"""

_FOR_PICKS = ("snap", "photo", "size", "image", "format", "grid", "order", "pixel_aspect")
"""Options that say nothing of a photo whose edges are found without picks."""


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
@options.results
@options.plotting
@options.overwriting
@options.printing
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
    **how: Any,
) -> None:
    """Read, fit, write, print."""
    from rich.console import Console

    from plumbline.cli.tools.deliver import deliver, refuse_unclear
    from plumbline.cli.tools.fit import Wishes, fit_lenses
    from plumbline.reading.gathering import labels_of, parts_of, photo_alone, split_by_lens

    options.refuse_unknown(model, {"--free": free, "--hold": hold, "--start": start})
    delivery = options.delivery(how)
    with options.wrong_call():
        refuse_unclear(delivery["output"], delivery["report"], delivery["plots"])
    wishes = Wishes(model, free, hold or (), start, residual, robust, bootstrap)
    narration = Console(stderr=True)
    if photo_alone(points, how["format"]):
        from plumbline.cli.tools.find import trusted_edges

        options.refuse_useless(click.get_current_context(), "a photo without picks", _FOR_PICKS)
        found = trusted_edges(points[0], narration)
        parts = split_by_lens(found.observations, labels_of(how))
        how["photo"] = points[0]
    else:
        parts = parts_of(points, how)
    if snap:
        from plumbline.cli.tools.snap import snapped

        parts = [each.observations for each in snapped(parts, how["photo"], narration)]
    calibrations = fit_lenses(parts, wishes, narration)
    deliver(calibrations, points[0], narration, photo=how["photo"], **delivery)

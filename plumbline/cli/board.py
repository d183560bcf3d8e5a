"""`plumbline board`."""

from __future__ import annotations

from typing import Any

import click

from plumbline.cli import option_types, options

_HELP = """Calibrate from photographs of a chequerboard.

Finds the inner corners of every board in the photos, takes rows and columns for straight lines and
fits all photos together, as of one lens at one focal length. The board need not be wholly in view,
nor its size be known, nor its squares be of one size. Corners go into board.json, which `fit`,
`check` and `compare` read too, and board.jpg shows them; strays are left out of the fit, and
listed.

\b
Examples:
  plumbline board board1.jpg board2.jpg board3.jpg
  plumbline board *.jpg --inner 9x6 --free a,b,c,d,e -o lens.json
  plumbline board *.jpg --points-only --points corners.csv
"""

_FOR_THE_FIT = (
    *("model", "free", "hold", "bootstrap", "output", "report", "plots", "as_json", "verbose"),
    *("maker", "lens_name", "mount", "focal", "focal_px", "crop_factor", "aspect_ratio"),
)


@click.command("board", help=_HELP)
@click.argument("photos", nargs=-1, required=True, metavar="PHOTO...")
@click.option(
    "--inner",
    type=option_types.Pair(least=3),
    metavar="COLSxROWS",
    help="Inner corners of the board, in either order; more of them are cut off.",
)
@click.option("--points-only", is_flag=True, help="Write the corners, and do not fit.")
@click.option(
    "--points",
    metavar="FILE",
    help="Where the corners go (.json, .csv, .pto); board.json beside the first photo by default.",
)
@click.option(
    "--overlay",
    metavar="FILE",
    help="Where the drawing goes (.jpg or .png); board.jpg beside the first photo by default.",
)
@options.model_or_auto
@options.coefficients
@options.bootstrap
@options.labelling
@options.results
@options.plotting
@options.overwriting
@options.printing
def command(
    photos: tuple[str, ...],
    inner: tuple[int, int] | None,
    points_only: bool,
    points: str | None,
    overlay: str | None,
    model: str,
    free: tuple[str, ...] | None,
    hold: tuple[str, ...] | None,
    bootstrap: int | None,
    **how: Any,
) -> None:
    """Find boards, write their corners, fit them."""
    from rich.console import Console

    from plumbline.boards.photographs import look, together, with_remarks
    from plumbline.cli.tools import board as tool
    from plumbline.cli.tools.deliver import deliver, refuse_unclear
    from plumbline.cli.tools.fit import Wishes, fit_lenses
    from plumbline.errors import printable
    from plumbline.reading.gathering import labels_of, split_by_lens

    if points_only:
        options.refuse_useless(click.get_current_context(), "--points-only", _FOR_THE_FIT)
    options.refuse_unknown(model, {"--free": free, "--hold": hold})
    delivery = options.delivery(how)
    with options.wrong_call():
        refuse_unclear(delivery["output"], delivery["report"], delivery["plots"])
        targets = tool.Targets.of(points, overlay, photos[0])
    narration = Console(stderr=True)
    with narration.status("Looking for boards…"):
        found = look(photos, inner)
    for seen in found:
        if not (delivery["quiet"] and seen.boards):
            click.echo(printable(seen.sentence), err=True)
    whole = together(found)
    files = tool.contents(targets, found, whole, overwrite=delivery["overwrite"])
    if points_only:
        tool.write(files)
        return
    wishes = Wishes(model, free, hold or (), None, "image", True, bootstrap)
    parts = split_by_lens(whole, labels_of(how))
    fitted = fit_lenses(parts, wishes, narration)
    calibrations = [with_remarks(each, found, targets.points) for each in fitted]
    deliver(calibrations, str(targets.points), narration, also=files, **delivery)

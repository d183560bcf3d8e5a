"""`plumbline lens`."""

from __future__ import annotations

import sys
from typing import Any

import click

from plumbline.cli import lens_options, options

_HELP = """Show which lens a photo would be corrected with, or store a calibration.

For each PHOTO, print the lens that `correct` would use, and the lenses in the database that match;
a folder stands for the photos in it. The lens is the one that --lens names; without it, EXIF is
looked up in your own calibrations, then in LensFun's database.

`lens add RESULT` stores a result or zoom JSON among your own calibrations, where photos of the same
camera, lens and focal length find it. `lens list` prints them, `lens remove NAME` deletes one.

\b
Examples:
  plumbline lens holiday.jpg
  plumbline lens scan.tif --camera "Nikon D5000" --focal 18
  plumbline lens add building.fit.json
  plumbline lens list
"""

_VERBS = ("add", "list", "remove")


@click.command("lens", help=_HELP)
@click.argument(
    "photos", nargs=-1, required=True, metavar="PHOTO… | add RESULT… | list | remove NAME…"
)
@lens_options.choosing
@options.overwriting
def command(photos: tuple[str, ...], overwrite: bool, **how: Any) -> None:
    """Look up and print, or add, list or remove."""
    from plumbline.cli.tools import lens as tool

    context = click.get_current_context()
    verb, *names = photos
    if verb not in _VERBS:
        options.refuse_useless(context, "lens PHOTO", ["overwrite"])
        if tool.show(photos, lens_options.request_of(**how)):
            sys.exit(1)
        return
    useless = [*how] if verb == "add" else [*how, "overwrite"]
    options.refuse_useless(context, f"lens {verb}", useless)
    if verb == "list":
        if names:
            raise click.UsageError("lens list takes nothing more")
        tool.show_kept()
        return
    if not names:
        what = "a result to add" if verb == "add" else "a calibration to remove"
        raise click.UsageError(f"name {what}: plumbline lens {verb} NAME")
    if verb == "add":
        tool.add(names, overwrite=overwrite)
    else:
        tool.remove(names)

"""`plumbline lens`."""

from __future__ import annotations

from typing import Any

import click

from plumbline.cli import lens_options, options

_HELP = """Show which lens a photo would be corrected with, or store a calibration.

For each PHOTO, print the lens that `correct` would use, and the lenses in the database that match.
The lens is the one that --lens names; without it, EXIF is looked up in your own calibrations, then
in LensFun's database.

`lens add RESULT` stores a result or zoom JSON among your own calibrations, where photos of the same
camera, lens and focal length find it.

\b
Examples:
  plumbline lens holiday.jpg
  plumbline lens scan.tif --camera "Nikon D5000" --focal 18
  plumbline lens add building.fit.json
"""


@click.command("lens", help=_HELP)
@click.argument("photos", nargs=-1, required=True, metavar="PHOTO… | add RESULT…")
@lens_options.choosing
@options.overwriting
def command(photos: tuple[str, ...], overwrite: bool, **how: Any) -> None:
    """Look up and print, or add."""
    from plumbline.errors import printable

    context = click.get_current_context()
    if photos == ("add",):
        raise click.UsageError("name a result to add: plumbline lens add RESULT")
    if photos[0] == "add":
        options.refuse_useless(context, "lens add", how)
        from plumbline.lenses.store import add

        for path in photos[1:]:
            added = add(path, overwrite=overwrite)
            click.echo(f"Wrote {printable(str(added))}")
        return
    options.refuse_useless(context, "lens PHOTO", ["overwrite"])
    from plumbline.lenses.lookup import look_up
    from plumbline.lenses.profile import correction
    from plumbline.photos.exif import read_photo

    request = lens_options.request_of(**how)
    for path in photos:
        photo = read_photo(path)
        found = look_up(photo, request)
        used = correction(found.profile, photo, request)
        width, height = photo.size
        focal_mm = request.focal_mm or photo.facts.focal_mm
        told = [f"{width}x{height}", photo.facts.camera or "no camera in EXIF"]
        told += [photo.facts.model] if photo.facts.model else []
        told += [f"{focal_mm:.4g} mm" if focal_mm else "no focal length in EXIF"]
        click.echo(f"{printable(path)}: {printable(', '.join(told))}")
        click.echo(f"Used: {printable(used.description)}.")
        for note in used.notes:
            click.echo(f"Note: {printable(note)}.")
        if found.candidates:
            click.echo("Matching lenses:")
            for candidate in found.candidates:
                click.echo(f"  {candidate}")

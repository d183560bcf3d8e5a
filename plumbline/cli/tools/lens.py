"""`plumbline lens` without its parsing: look up, keep, list and remove calibrations."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click

from plumbline.errors import PlumblineError, printable
from plumbline.imaging.targets import passed_over, photo_targets
from plumbline.lenses import shelf, store
from plumbline.lenses.lookup import look_up
from plumbline.lenses.profile import correction
from plumbline.lenses.request import LensRequest
from plumbline.photos.exif import PhotoFacts, read_photo
from plumbline.photos.exiftool import EXIFTOOL, lacks_name, lens_names
from plumbline.wording import count, listed


def show(sources: Sequence[str], request: LensRequest) -> int:
    """Show the lens of each photo; what fails is told and stops nothing.

    Returns:
        How many failed.
    """
    failed = 0
    paths: list[Path] = []
    for source in sources:
        try:
            folder = Path(source).is_dir()
            paths += (
                [task.photo for task in photo_targets([source], None)] if folder else [Path(source)]
            )
        except PlumblineError as error:
            failed += _tell(error, len(sources))
    photos: dict[Path, PhotoFacts] = {}
    for path in paths:
        try:
            photos[path] = read_photo(path)
        except PlumblineError as error:
            failed += _tell(error, len(paths))
    if request.looks_for_name:
        names = lens_names([path for path, photo in photos.items() if lacks_name(photo)])
        photos |= {path: photos[path].naming(name, EXIFTOOL) for path, name in names.items()}
    for path, photo in photos.items():
        try:
            _show(path, photo, request)
        except PlumblineError as error:
            failed += _tell(error, len(paths), path)
    over = passed_over(sources, None)
    if over:
        kinds = listed([f"{number:,} {kind}" for kind, number in over.items()])
        click.echo(f"Passed over {count(sum(over.values()), 'other file')}: {kinds}.")
    return failed


def _tell(error: PlumblineError, number: int, path: Path | None = None) -> int:
    """Tell an error where there are other photos; where there are none it is the command's."""
    if number == 1:
        raise error
    name = "" if path is None or str(path) in error.message else f"{path}: "
    click.secho(f"Error: {printable(name + error.message)}.", fg="red", err=True)
    if error.hint:
        click.echo(f"  {printable(error.hint)}.", err=True)
    return 1


def _show(path: Path, photo: PhotoFacts, request: LensRequest) -> None:
    found = look_up(photo, request)
    used = correction(found.profile, photo, request)
    width, height = photo.size
    focal_mm = request.focal_mm or photo.facts.focal_mm
    told = [f"{width}x{height}", photo.facts.camera or "no camera in EXIF"]
    if photo.facts.model:
        by = f" (by {photo.lens_told_by})" if photo.lens_told_by else ""
        told.append(photo.facts.model + by)
    told.append(f"{focal_mm:.4g} mm" if focal_mm else "no focal length in EXIF")
    click.echo(f"{printable(str(path))}: {printable(', '.join(told))}")
    click.echo(f"Used: {printable(used.description)}.")
    for note in used.notes:
        click.echo(f"Note: {printable(note)}.")
    if found.candidates:
        click.echo("Matching lenses:")
        for candidate in found.candidates:
            click.echo(f"  {candidate}")


def add(paths: Sequence[str], *, overwrite: bool) -> None:
    """Keep results and zoom JSONs."""
    for path in paths:
        added = store.add(path, overwrite=overwrite)
        click.echo(f"Wrote {printable(str(added))}")


def remove(names: Sequence[str]) -> None:
    """Delete calibrations that were kept."""
    for name in names:
        click.echo(f"Removed {printable(str(shelf.remove(name)))}")


def show_kept() -> None:
    """List the calibrations that were kept."""
    every = shelf.kept()
    if not every:
        click.echo("You have no calibrations of your own: plumbline lens add RESULT keeps one.")
        return
    for each in every:
        click.echo(printable(each.path.name))
        if each.error:
            click.echo(f"  cannot be used: {printable(each.error)}")
            continue
        low, high = each.range_mm
        span = f"{low:.4g} mm" if low == high else f"{low:.4g}–{high:.4g} mm"
        lens = each.facts.model or "no lens named"
        click.echo(f"  {printable(f'{each.facts.camera}, {lens}')}, {span}")
    click.echo(f"In {printable(str(store.folder()))}.")

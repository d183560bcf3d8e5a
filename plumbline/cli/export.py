"""`plumbline export`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from plumbline.cli import options
from plumbline.formats.known import written

if TYPE_CHECKING:
    from plumbline.writing.files import ExportedFile

_FACTS = {"lens_name": "model", "focal": "focal_mm"}
"""What options of `options.labelling` are called in `LensFacts`, where it is something else."""
_LABELS = {"maker", "lens_name", "mount", "focal", "focal_px", "crop_factor", "aspect_ratio"}
_TARGETS = (*written("lens"), "stmap", "json")
"""What can be written: lenses in other programs' words, a sampling map, and the result again."""
_USELESS = {"stmap": {"force"}, "json": {"force", "image"}}

_HELP = """Write a calibrated lens for another program.

RESULT: a JSON that `fit` wrote, or a Hugin or PTGui project or a Hugin lens .ini with lens
values, such as that of a stitched panorama. Where the program uses another distortion model,
the lens is refitted over the photo and the largest deviation is printed; above 0.1 px the file is
written only with --force. The file goes beside RESULT unless -o names another.

\b
Examples:
  plumbline export building.fit.json --to lensfun
  plumbline export building.fit.json --to imagemagick -o correct.sh
  plumbline export panorama.pto --to hugin-ini
"""


@click.command("export", help=_HELP)
@click.argument("result")
@click.option("--to", "target", type=click.Choice(_TARGETS), required=True, help="What to write.")
@click.option(
    "--image",
    type=click.IntRange(min=0),
    metavar="N",
    help="Use lens number N of the file, counted from 0, where it holds several.",
)
@click.option("--force", is_flag=True, help="Write even if the refit deviates by more than 0.1 px.")
@options.labelling
@click.option("-o", "--output", metavar="FILE", help="Write this file.")
@options.overwriting
def command(
    result: str,
    target: str,
    image: int | None,
    force: bool,
    output: str | None,
    overwrite: bool,
    **labels: Any,
) -> None:
    """Read, convert, write, print."""
    from plumbline.errors import printable
    from plumbline.files import refuse_to_clobber, write_atomically
    from plumbline.writing.files import export_file

    known = written("lens").get(target)
    used = set() if known is None else set(known.facts)
    useless = {name for name in _LABELS if _FACTS.get(name, name) not in used}
    useless |= _USELESS.get(target, set())
    options.refuse_useless(click.get_current_context(), f"--to {target}", useless)
    facts = {_FACTS.get(name, name): value for name, value in labels.items() if value is not None}
    place = Path(output) if output else None
    if target == "stmap":
        exported = _stmap(result, place, image)
    else:
        exported = export_file(result, target, place, image, facts, force=force)
    refuse_to_clobber(exported.path, [result], overwrite=overwrite)
    write_atomically({exported.path: exported.content})
    if exported.deviation_px is not None:
        click.echo(
            f"Refitted to {exported.model}: "
            f"at most {exported.deviation_px:.3f} px off over the photo."
        )
    for note in exported.notes:
        click.echo(f"Note: {printable(note)}.")
    click.echo(f"Wrote {printable(str(exported.path))}")


def _stmap(result: str, output: Path | None, image: int | None) -> ExportedFile:
    """The sampling map of photos of the size that was calibrated."""
    from plumbline.files import read_bytes
    from plumbline.formats.base import Source
    from plumbline.imaging.maps.mapfile import map_bytes
    from plumbline.lenses.correction import Correction
    from plumbline.writing.files import ExportedFile, one_lens

    stored = one_lens(Source(result, read_bytes(result)), image)
    path = output or Path(result).with_suffix(".stmap.tif")
    lens = stored.lens
    correction = Correction(lens.distort, lens.undistort, lens.frame.size, "")
    content, notes = map_bytes(correction, path)
    return ExportedFile(path, content, notes=(*stored.notes, *notes))

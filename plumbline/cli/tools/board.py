"""`plumbline board` without its parsing: the files of corners and of their drawing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import click

from plumbline.boards.overlay import sheet
from plumbline.boards.photographs import Seen
from plumbline.cli.tools.pictures import PICTURES, picture_bytes
from plumbline.errors import WriteError, printable
from plumbline.files import refuse_to_clobber, refuse_unknown_suffix, write_atomically
from plumbline.formats.known import suffixes
from plumbline.observations import Observations


def write(files: Mapping[Path, bytes]) -> None:
    """Write the corners and the drawing alone."""
    write_atomically(files)
    for path in files:
        click.echo(f"Wrote {printable(str(path))}")
    click.echo(f"Next: plumbline fit {printable(str(next(iter(files))))} --robust")


@dataclass(frozen=True)
class Targets:
    """Files to write beside the results of a fit.

    Attributes:
        points: The corners.
        overlay: The drawing.
    """

    points: Path
    overlay: Path

    @classmethod
    def of(cls, points: str | None, overlay: str | None, first: str) -> Targets:
        """Those the user names, else `board.json` and `board.jpg` beside the first photograph.

        Raises:
            WriteError: a suffix stands for nothing, or the two are one file.
        """
        folder = Path(first).parent
        targets = cls(
            folder / "board.json" if points is None else Path(points),
            folder / "board.jpg" if overlay is None else Path(overlay),
        )
        refuse_unknown_suffix(targets.points, tuple(suffixes("points")), "corners")
        refuse_unknown_suffix(targets.overlay, PICTURES, "drawings")
        if targets.points == targets.overlay:
            raise WriteError("this file is named twice", path=targets.points, hint="name two files")
        return targets


def contents(
    targets: Targets, found: Sequence[Seen], observations: Observations, *, overwrite: bool
) -> Mapping[Path, bytes]:
    """What the points and the drawing hold, after all checks.

    Raises:
        WriteError: a file exists and is not plumbline's, or is one of the photographs.
    """
    inputs = [seen.path for seen in found]
    for target in (targets.points, targets.overlay):
        refuse_to_clobber(target, inputs, overwrite=overwrite)
    return {
        targets.points: suffixes("points")[targets.points.suffix.lower()].write(observations),
        targets.overlay: picture_bytes(targets.overlay, sheet([seen.drawing for seen in found])),
    }

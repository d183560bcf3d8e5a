"""`plumbline find` without its parsing: a photograph in, points and a drawing out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from plumbline.cli.tools.pictures import PICTURES, picture_bytes
from plumbline.edges.find import Found, find_edges
from plumbline.edges.overlay import drawn
from plumbline.errors import DegenerateLinesError, WriteError
from plumbline.files import refuse_to_clobber, refuse_unknown_suffix
from plumbline.wording import count, px
from plumbline.writing.results import POINT_SUFFIXES, points_bytes

if TYPE_CHECKING:
    from rich.console import Console


@dataclass(frozen=True)
class Targets:
    """Files to write.

    Attributes:
        points: The edges as points.
        overlay: The drawing.
    """

    points: Path
    overlay: Path

    @classmethod
    def of(cls, photo: str, points: str | None, overlay: str | None) -> Targets:
        """Those the user names, else NAME.found.json and NAME.found.jpg beside the photo.

        Raises:
            WriteError: a suffix stands for nothing, or the two are one file.
        """
        targets = cls(
            Path(photo).with_suffix(".found.json") if points is None else Path(points),
            Path(photo).with_suffix(".found.jpg") if overlay is None else Path(overlay),
        )
        refuse_unknown_suffix(targets.points, POINT_SUFFIXES, "points")
        refuse_unknown_suffix(targets.overlay, PICTURES, "drawings")
        if targets.points == targets.overlay:
            raise WriteError("this file is named twice", path=targets.points, hint="name two files")
        return targets

    def refuse_to_clobber(self, photo: str, *, overwrite: bool) -> None:
        """Refuse to write over the photo, or over a file that plumbline did not write.

        Raises:
            WriteError: as said.
        """
        for target in (self.points, self.overlay):
            refuse_to_clobber(target, [photo], overwrite=overwrite)


def found_in(photo: str, narration: Console) -> Found:
    """The edges of a photo, with what goes on narrated.

    Raises:
        PlumblineError: as `find_edges`.
    """
    with narration.status("Looking for edges…"):
        return find_edges(photo)


def trusted_edges(photo: str, narration: Console) -> Found:
    """The edges of a photo that are vouched for.

    Raises:
        DegenerateLinesError: they are not; the sentence says why.
    """
    found = found_in(photo, narration)
    if not found.verdict.vouched:
        raise DegenerateLinesError(
            f"{photo}: the edges found in the photo do not give a lens that can be vouched for: "
            f"{found.verdict.reason}",
            hint="pick lines by hand and let fit --snap move them onto the edges; plumbline find "
            "writes those that were found, to begin with",
        )
    return found


def contents(found: Found, targets: Targets, *, overwrite: bool) -> Mapping[Path, bytes]:
    """What the points and the drawing hold; without any edge, the drawing alone."""
    files = {targets.overlay: picture_bytes(targets.overlay, drawn(found.pixels, found.lines))}
    if found.observations.lines:
        points = points_bytes(found.observations, targets.points, overwrite=overwrite)
        files[targets.points] = points
    return files


def sentence(found: Found) -> str:
    """What was found and how far it can be trusted."""
    number = count(len(found.lines), "long edge")
    if found.verdict.vouched:
        return f"{number}; the correction they give is uncertain by {px(found.verdict.error_px)}"
    return f"{number}, not enough to fit without a check by eye: {found.verdict.reason}"

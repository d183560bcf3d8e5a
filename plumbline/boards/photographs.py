"""Chequerboards in photographs: what each shows, and the lens that all of them give."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from plumbline.boards.find import look_for_boards
from plumbline.boards.overlay import Drawing, drawn, width_of_each
from plumbline.boards.spacing import spacing
from plumbline.errors import OptionError, PlumblineError, ReadError
from plumbline.files import is_same
from plumbline.fit.calibrate import calibrate
from plumbline.models import CENTRE
from plumbline.observations import Observations, Origin
from plumbline.observations.board import Board, lines_of
from plumbline.observations.facts import LensFacts
from plumbline.photos.brightness import brightness
from plumbline.reading.photo import note_on_orientation, with_exif
from plumbline.reading.points import join
from plumbline.reading.upright import photo_of, read_upright
from plumbline.result.calibration import Calibration
from plumbline.wording import count, listed, number

_WORTHWHILE = 0.9
"""Share of the rms that must be left for a free centre to be mentioned; chosen."""

_NO_BOARD = (
    "a chequerboard needs at least 3 by 3 inner corners in view, sharp and evenly lit; boards with "
    "markers in their squares (ChArUco) and grids of dots are not read"
)


@dataclass(frozen=True, eq=False)
class Seen:
    """What one photograph shows.

    Attributes:
        path: The photograph.
        boards: Its boards; may be empty.
        reason: Why there is none.
        observations: Rows and columns of its boards as lines; None without any.
        drawing: The photograph with its boards drawn in.
    """

    path: str
    boards: tuple[Board, ...]
    reason: str
    observations: Observations | None
    drawing: Drawing

    @property
    def sentence(self) -> str:
        """What was found, for the user."""
        if not self.boards:
            return f"{self.path}: no chequerboard: {self.reason}"
        sizes = [f"{columns}x{rows}" for columns, rows in (board.inner for board in self.boards)]
        corners = count(sum(map(len, self.boards)), "corner")
        return f"{self.path}: {corners} of {count(len(self.boards), 'board')} ({listed(sizes)})"


def calibrate_board(
    photos: Sequence[str | Path],
    *,
    inner: tuple[int, int] | None = None,
    model: str = "ptlens",
    free: Sequence[str] | None = None,
    hold: Sequence[str] = (),
) -> Calibration:
    """Calibrate a lens from photographs of chequerboards, all at one focal length.

    Rows and columns of the boards' inner corners are the lines. The fit is a robust one: corners
    that do not agree with the others are left out and named.

    Args:
        photos: The files.
        inner: As for `find_board`.
        model: Name of the distortion model, see `plumbline.MODELS`.
        free: Coefficients to fit; all of the model's by default. `d` and `e`, the distortion
            centre in pixels, may be among them.
        hold: Coefficients to hold at 0 nevertheless.

    Returns:
        The calibration; its remarks name photos without a board and what the boards tell besides.

    Raises:
        ReadError: a photograph cannot be read, or none shows a board.
        OptionError: one is named twice, they were taken at several focal lengths, or as
            `calibrate`.
        DegenerateLinesError: as `calibrate`.

    Example:
        >>> plumbline.calibrate_board(["board1.jpg", "board2.jpg"]).coefficients  # doctest: +SKIP
    """
    found = look([str(photo) for photo in photos], inner)
    calibration = calibrate(together(found), model, free=free, hold=hold, robust=True)
    return with_remarks(calibration, found)


def look(paths: Sequence[str], inner: tuple[int, int] | None) -> list[Seen]:
    """Look for boards in photographs.

    Raises:
        ReadError: a photograph cannot be read, or none shows a board.
        OptionError: one is named twice.
    """
    for index, path in enumerate(paths):
        if any(is_same(Path(path), other) for other in paths[:index]):
            raise OptionError(
                f"{path}: this photo is named twice, and its corners would count twice",
                hint="name each photo once",
            )
    found = [_seen(path, inner, width_of_each(len(paths))) for path in paths]
    if not any(seen.boards for seen in found):
        where = found[0].path if len(found) == 1 else f"none of {len(found)} photos"
        reasons = list(dict.fromkeys(seen.reason for seen in found))
        raise ReadError(f"{where}: no chequerboard: {listed(reasons, 3)}", hint=_NO_BOARD)
    return found


def _seen(path: str, inner: tuple[int, int] | None, width_px: int) -> Seen:
    photo = read_upright(path)
    search = look_for_boards(brightness(photo.pixels), inner)
    drawing = drawn(photo.pixels, search.boards, photo.facts.name, width_px)
    if not search.boards:
        return Seen(path, (), search.reason, None, drawing)
    height, width = photo.pixels.shape[:2]
    notes = note_on_orientation(photo.facts, (width, height))
    facts = with_exif(LensFacts(), [photo.facts], notes)
    observations = Observations(
        (photo_of(photo),),
        tuple(lines_of(search.boards)),
        (facts,),
        tuple(notes),
        (Origin(path, "photo", checksum=photo.identity.sha256),),
    ).checked()
    return Seen(path, search.boards, "", observations, drawing)


def together(found: Sequence[Seen]) -> Observations:
    """Rows and columns of all photographs, those of one lens.

    Raises:
        OptionError: they were taken at several focal lengths.
    """
    parts = [seen.observations for seen in found if seen.observations is not None]
    whole = join(parts)
    photos = tuple(replace(photo, number=n) for n, photo in enumerate(whole.photos))
    return replace(whole, photos=photos)


def with_remarks(
    calibration: Calibration, found: Sequence[Seen], corners: Path | None = None
) -> Calibration:
    """The calibration with what the boards tell beside it.

    Args:
        calibration: Fitted to the boards that were found.
        found: All photographs.
        corners: The file of corners, which `plumbline compare` reads, if there is one.
    """
    remarks = [seen.sentence for seen in found if not seen.boards]
    told = spacing(calibration, [seen.boards for seen in found if seen.boards])
    if told is not None and told.uneven:
        remarks.append(told.sentence)
    remarks += _about_the_centre(calibration, corners)
    return replace(calibration, remarks=(*calibration.remarks, *remarks))


def _about_the_centre(calibration: Calibration, corners: Path | None) -> list[str]:
    """What a free distortion centre would change, where it was held; corners can tell it."""
    if not set(CENTRE).isdisjoint(calibration.free):
        return []
    free = (*calibration.free, *CENTRE)
    try:
        other = calibrate(calibration.observations, calibration.model, free=free, robust=True)
    except PlumblineError:
        return []
    if not other.converged or other.rms_after_px > _WORTHWHILE * calibration.rms_after_px:
        return []
    where = " and ".join(
        f"{name} = {number(other.coefficients[name], '.1f')} ± {other.standard_errors[name]:.1f}"
        for name in CENTRE
    )
    return [
        f"the distortion centre is held at the photo's: free (--free {','.join(free)}) it lies at "
        f"{where} px, and corners stray by {other.rms_after_px:.2g} px instead of "
        f"{calibration.rms_after_px:.2g} px"
        + ("" if corners is None else f"; plumbline compare {corners} judges it")
    ]

"""From two pictures, or a table of matches, to a lens."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from plumbline.errors import OptionError, PlumblineError
from plumbline.files import is_same, read_bytes
from plumbline.formats.base import Source
from plumbline.formats.points.matches import read_matches
from plumbline.frame import Frame
from plumbline.observations import Origin
from plumbline.observations.facts import LensFacts
from plumbline.pairs.calibrate import calibrate_pair
from plumbline.photos.exif import PhotoFacts, read_photo
from plumbline.reading.gathering import labelled
from plumbline.reading.photo import note_on_orientation, with_exif
from plumbline.reading.upright import photo_of, read_upright
from plumbline.result.pair import PairCalibration


def calibrate_pair_files(
    original: str | Path,
    corrected: str | Path,
    *,
    labels: Mapping[str, Any] | None = None,
    model: str = "ptlens",
    free: Iterable[str] | None = None,
    hold: Iterable[str] = (),
) -> PairCalibration:
    """Find the distortion that one of two picture files was corrected for.

    The lens, the date and the checksums of both files go into the calibration.

    Args:
        original: The picture as the lens shows it.
        corrected: The same scene from the same place without distortion.
        labels: What is known of the lens besides EXIF, by the names of `LensFacts`.
        model: Name of the distortion model, see `plumbline.MODELS`.
        free: Coefficients to fit; all of the model's by default.
        hold: Coefficients to hold at 0 nevertheless.

    Raises:
        ReadError: a file is missing, damaged or not a picture.
        OptionError: both names are of one file, or as `calibrate_pair`.
        PairError: as `calibrate_pair`; the sentence names the files.

    Example:
        >>> plumbline.calibrate_pair_files("raw.jpg", "camera.jpg")  # doctest: +SKIP
    """
    original, corrected = str(original), str(corrected)
    if is_same(Path(original), corrected):
        raise OptionError(
            f"{original}: the two pictures are one file", hint="name an original and its correction"
        )
    first, second = read_upright(original), read_upright(corrected)
    notes = note_on_orientation(first.facts, first.facts.size)
    facts = _facts([first.facts, second.facts], labels or {}, notes, first.facts.size)
    calibration = _named(
        f"{original} and {corrected}",
        original=first.pixels,
        corrected=second.pixels,
        facts=facts,
        name=first.facts.name,
        model=model,
        free=free,
        hold=hold,
    )
    origins = (
        Origin(original, "photo", checksum=first.identity.sha256),
        Origin(corrected, "photo", checksum=second.identity.sha256),
    )
    whole = _with(calibration, notes, origins)
    observations = replace(whole.observations, photos=(photo_of(first),))
    return replace(whole, observations=observations)


def from_points(
    path: str,
    photo: str | None,
    size: tuple[int, int] | None,
    labels: Mapping[str, Any],
    **how: Any,
) -> PairCalibration:
    """Calibrate from a table of matches.

    Args:
        path: The table.
        photo: The original, for its size and EXIF.
        size: The original's size, where the photo is not at hand.
        labels: As for `calibrate_pair_files`.
        how: As `calibrate_pair`.

    Raises:
        PlumblineError: as `read_matches` and `calibrate_pair`.
    """
    source = Source(path, read_bytes(path))
    points = read_matches(source)
    notes: list[str] = []
    known = None if photo is None else read_photo(photo)
    if known is not None and size is not None and known.size != size:
        raise OptionError(
            f"{photo} is {known.size[0]}x{known.size[1]}, and --size says {size[0]}x{size[1]}",
            hint="leave out --size",
        )
    taken = size if known is None else known.size
    facts = _facts([] if known is None else [known], labels, notes, taken)
    calibration = _named(
        path,
        points=points,
        size=taken,
        facts=facts,
        name="" if known is None else known.name,
        **how,
    )
    return _with(calibration, notes, (Origin(path, "csv", source.content),))


def _facts(
    photos: list[PhotoFacts],
    labels: Mapping[str, Any],
    notes: list[str],
    size: tuple[int, int] | None,
) -> LensFacts:
    """What EXIF says of the lens, the original's first, and what the user says.

    Without a size the fit is refused, so that what the user says of its shape need not be checked.
    """
    told = LensFacts()
    for photo in reversed(photos):
        told = with_exif(told, [photo], notes)
    return told if size is None else labelled(told, labels, Frame(*size))


def _named(what: str, **how: Any) -> PairCalibration:
    try:
        return calibrate_pair(**how)
    except PlumblineError as error:
        raise type(error)(f"{what}: {error.message}", hint=error.hint) from None


def _with(
    calibration: PairCalibration, notes: list[str], origins: tuple[Origin, ...]
) -> PairCalibration:
    observations = replace(calibration.observations, notes=tuple(notes), origins=origins)
    return replace(calibration, observations=observations)

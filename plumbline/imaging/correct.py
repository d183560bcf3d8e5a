"""Correct photographs: one, in an array, or many, one file at a time."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from plumbline.errors import OptionError, refuse_other_type
from plumbline.files import read_bytes, write_atomically
from plumbline.geometry.lens import Lens
from plumbline.imaging.borders import outside_of, with_alpha
from plumbline.imaging.difference import difference_png
from plumbline.imaging.maps.sampling import fold_notes, sampling_of
from plumbline.imaging.maps.sampling_map import SamplingMap
from plumbline.imaging.resample import resample
from plumbline.imaging.settings import Settings
from plumbline.imaging.targets import SUFFIX, beside, check_target, difference_of
from plumbline.lenses.correction import Correction
from plumbline.lenses.request import LensRequest
from plumbline.observations.facts import LensFacts
from plumbline.photos.exif import PhotoFacts, read_photo
from plumbline.photos.exiftool import EXIFTOOL, lacks_name, with_lens_name
from plumbline.photos.files.encode import encode, format_of
from plumbline.photos.files.metadata import note_of
from plumbline.photos.files.picture import Pixels, decode
from plumbline.result.calibration import Calibration

_CHANNELS = ((), (1,), (2,), (3,), (4,))
"""What lies behind rows and columns: nothing, or grey, grey with alpha, RGB, and RGBA or CMYK."""

LensSource = Calibration | Lens | Correction | LensRequest | str | Path | None


@dataclass(frozen=True)
class Corrected:
    """What was done to a photograph.

    Attributes:
        photo: The original.
        output: The corrected photograph.
        description: The lens that was found and used, in one sentence.
        notes: What the user should know, in plain sentences.
        difference: The picture of the differences, if asked for.
    """

    photo: Path
    output: Path
    description: str
    notes: tuple[str, ...] = ()
    difference: Path | None = None


def correct(
    photo: str | Path,
    lens: LensSource = None,
    output: str | Path | None = None,
    *,
    overwrite: bool = False,
    **settings: Any,
) -> Corrected:
    """Correct the lens distortion of one photograph, and write the result to a file.

    Args:
        photo: JPEG, TIFF, PNG, WebP or whatever Pillow reads.
        lens: A calibration, a lens, a file that holds one, or what is known of it; by default
            it is looked up by the photo's EXIF.
        output: Where to; beside the photo, with `_corrected` after its name, by default.
        overwrite: Replace a file that plumbline did not write.
        **settings: The fields of `Settings`: interpolation, scale, border, quality, inverse,
            difference.

    Returns:
        What was found and done.

    Raises:
        PlumblineError: the photo cannot be read, no lens is found, or the target cannot be
            written; nothing is written then.

    Example:
        >>> import plumbline
        >>> plumbline.correct("facade.jpg", "building.json").output  # doctest: +SKIP
        PosixPath('facade_corrected.jpg')
    """
    source = Path(photo)
    target = Path(output) if output else beside(source, SUFFIX)
    return correct_file(source, target, lens, Settings(**settings), overwrite=overwrite)


def correct_array(pixels: Pixels, lens: Lens | Calibration | Correction, **settings: Any) -> Pixels:
    """Correct the lens distortion of pixels in memory.

    Args:
        pixels: Shape (rows, columns) or (rows, columns, channels), 8 or 16 bit; the last of 2
            or 4 channels is alpha.
        lens: The lens; it is scaled to the picture.
        **settings: The fields of `Settings` that matter here: interpolation, scale, border,
            inverse.

    Returns:
        The corrected pixels; with border "transparent" they have an alpha channel.

    Raises:
        OptionError: the array does not hold a picture, or a setting is unknown.
    """
    refuse_other_type(pixels, np.ndarray, "an array of pixels", "give a NumPy array")
    if (
        pixels.ndim < 2
        or pixels.shape[2:] not in _CHANNELS
        or pixels.dtype.name not in ("uint8", "uint16")
        or not pixels.size
    ):
        raise OptionError(
            f"an array of shape {pixels.shape} and type {pixels.dtype} does not hold a picture",
            hint="give rows, columns and at most 4 channels as uint8 or uint16",
        )
    if pixels.ndim == 3 and pixels.shape[2] == 1:
        grey = correct_array(pixels[..., 0], lens, **settings)
        return grey if grey.ndim == 3 else grey[..., None]
    facts = PhotoFacts((pixels.shape[1], pixels.shape[0]), LensFacts())
    how = Settings(**settings)
    return _corrected(pixels, _sampling(correction_for(facts, lens), how), how)


def correction_for(photo: PhotoFacts, lens: LensSource) -> Correction:
    """The correction of a photo by whatever names a lens.

    Raises:
        PlumblineError: no lens is found, or it does not fit the photo.
    """
    if isinstance(lens, Correction):
        if lens.size != photo.size:
            raise OptionError("the correction is for a photo of another size")
        return lens
    from plumbline.lenses import lookup, profile

    found, request = lookup.profile_for(photo, lens)
    return profile.correction(found, photo, request)


def correct_file(
    photo: Path,
    target: Path,
    lens: LensSource,
    settings: Settings,
    *,
    overwrite: bool = False,
    threads: int | None = None,
    lens_name: str | None = None,
) -> Corrected:
    """Correct one photograph; see `correct`.

    Args:
        photo: The original.
        target: The file to write.
        lens: The lens.
        settings: How to correct.
        overwrite: Replace a file that plumbline did not write.
        threads: Number of threads; one a core by default.
        lens_name: Name of the lens by exiftool, empty if it knows none; asked if None.
    """
    compared = difference_of(target) if settings.difference else None
    for each in (target, compared):
        if each is not None:
            check_target(each, photo, overwrite=overwrite)
    _check_border(settings, target)
    facts = _named(read_photo(photo), photo, lens, lens_name)
    found = correction_for(facts.taken_as_corrected() if settings.inverse else facts, lens)
    sampling = _sampling(found, settings, facts.orientation)
    picture = decode(read_bytes(photo), photo)
    pixels = _corrected(picture.pixels, sampling, settings, inks=picture.inks, threads=threads)
    result = replace(picture, pixels=pixels)
    contents: dict[Path, bytes] = {}
    if compared is not None:
        contents[compared] = difference_png(picture, result, compared)
    contents[target], lost = encode(result, target, settings.quality, note_of(found.description))
    write_atomically(contents)
    notes = (*found.notes, *fold_notes(sampling), *picture.notes, *lost)
    return Corrected(photo, target, found.description, notes, compared)


def _named(facts: PhotoFacts, photo: Path, lens: LensSource, lens_name: str | None) -> PhotoFacts:
    """The facts of a photo with the name of its lens, if a database is to be asked for it."""
    if not looks_for_name(lens) or not lacks_name(facts):
        return facts
    if lens_name is None:
        return with_lens_name(facts, photo)
    return facts.naming(lens_name, EXIFTOOL) if lens_name else facts


def looks_for_name(lens: LensSource) -> bool:
    """Whether the name of a photo's lens matters to find it."""
    if isinstance(lens, str | Path):
        lens = LensRequest(source=str(lens))
    return lens is None or (isinstance(lens, LensRequest) and lens.looks_for_name)


def _check_border(settings: Settings, target: Path) -> None:
    """Refuse what cannot be, before any work is done."""
    if settings.border == "transparent" and format_of(target) == "JPEG":
        raise OptionError(
            "JPEG cannot be transparent", hint="name a .png or .tif with -o, or another --border"
        )


def _sampling(found: Correction, settings: Settings, orientation: int = 1) -> SamplingMap:
    return sampling_of(
        found, orientation=orientation, scale=settings.scale, inverse=settings.inverse
    )


def _corrected(
    pixels: Pixels,
    sampling: SamplingMap,
    settings: Settings,
    *,
    inks: bool = False,
    threads: int | None = None,
) -> Pixels:
    if sampling.size != pixels.shape[1::-1]:
        raise OptionError("the correction is for a photo of another size")
    if settings.border == "transparent":
        if inks:
            raise OptionError(
                "a CMYK picture cannot be transparent", hint="choose another --border"
            )
        pixels = with_alpha(pixels)
    channels = 1 if pixels.ndim == 2 else pixels.shape[2]
    alpha = channels in (2, 4) and not inks
    full = float(np.iinfo(pixels.dtype).max)
    outside = outside_of(settings.border, channels, full, alpha=alpha, inks=inks)
    return resample(pixels, sampling, settings.interpolation, outside, alpha=alpha, threads=threads)

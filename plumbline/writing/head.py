"""The head of a LensFun lens: its labels, its crop factor, aspect ratio and centre.

Every file that names a lens for LensFun takes its head from here, so that what one writer
refuses all of them refuse.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from plumbline.errors import OptionError
from plumbline.formats.lens_files.lensfun import LensfunLens
from plumbline.frame import Frame
from plumbline.geometry.lens import Lens
from plumbline.observations import Observations
from plumbline.observations.facts import LensFacts, best_crop_factor, checked_aspect_ratio
from plumbline.writing.labels import spelt


def lensfun_head(
    every: Sequence[LensFacts],
    frame: Frame,
    name: str,
    comment: str,
    centre: tuple[float, float] = (0.0, 0.0),
) -> LensfunLens:
    """The head of a lens.

    Args:
        every: What each calibration knows of the lens; the first names its maker and mount.
        frame: The photo's.
        name: The lens's, as `lens_name` has it.
        comment: What the reader of the file should know.
        centre: Offset of the distortion centre in half shorter sides.

    Raises:
        OptionError: the crop factor is not known, crop factors differ, or the user's aspect
            ratio contradicts the photo's.
    """
    known = crop_factor(every)
    labels = spelt(replace(every[0], crop_factor=known)).facts
    return LensfunLens(
        maker=labels.maker or "Unknown",
        model=labels.model if labels.model and labels.model != every[0].model else name,
        mount=labels.mount or "Generic",
        crop_factor=labels.crop_factor or known,
        aspect_ratio=aspect_ratio(every[0], frame),
        centre=centre,
        comment=comment,
    )


def lens_name(facts: LensFacts, observations: Observations | None = None) -> str:
    """The lens by EXIF, else after its camera, else after the file of the points."""
    if facts.model:
        return facts.model
    if facts.camera:
        return f"{facts.camera} lens"
    origins = observations.origins if observations else ()
    return Path(origins[0].path).stem if origins else "Lens calibrated by plumbline"


def crop_factor(every: Sequence[LensFacts]) -> float:
    """The crop factor known best, where those of all calibrations agree within their errors.

    Raises:
        OptionError: one is not known, or they differ.
    """
    if not all(facts.crop_factor for facts in every):
        raise OptionError("the crop factor is not known", hint="give it with --crop-factor")
    best = best_crop_factor(every)
    if best is None or best.crop_factor is None:
        raise OptionError("the crop factors differ", hint="give it with --crop-factor")
    return best.crop_factor


def aspect_ratio(facts: LensFacts, frame: Frame) -> float:
    """Longer side over shorter side, as the user rounds it or as the photo has it.

    Raises:
        OptionError: the user gives another one than the photo's.
    """
    width, height = frame.square_size
    if facts.aspect_ratio is None:
        return max(width, height) / min(width, height)
    return checked_aspect_ratio(facts.aspect_ratio, frame)


def focal_mm(facts: LensFacts, frame: Frame) -> float:
    """Focal length in millimetres, which LensFun lists distortion by.

    Raises:
        OptionError: it is not known.
    """
    known = facts.focal_length_mm(frame)
    if known is not None:
        return known
    if facts.crop_factor:
        raise OptionError("the focal length is not known", hint="give it with --focal")
    raise OptionError(
        "the focal length and the crop factor are not known",
        hint="give them with --focal and --crop-factor",
    )


def centre_of(lens: Lens) -> tuple[float, float]:
    """Offset of the distortion centre in half shorter sides of square pixels."""
    frame, values = lens.frame, lens.coefficients
    return values["d"] * frame.pixel_aspect / frame.radius_px, values["e"] / frame.radius_px

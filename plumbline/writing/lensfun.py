"""A LensFun profile from calibrations: which lens it is, what is known of it, its entries."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from plumbline._version import __version__
from plumbline.errors import OptionError, UnsupportedModelError
from plumbline.files import MARK
from plumbline.formats.lens_files.lensfun import MODELS, Distortion, LensfunLens, lensfun_xml
from plumbline.observations.facts import LensFacts, best_crop_factor, checked_aspect_ratio
from plumbline.result.calibration import Calibration
from plumbline.wording import count

_SAME_SHAPE = 0.02

_FLAGS = re.compile(r" \(--[^)]*\)")


def lensfun_bytes(calibrations: Sequence[Calibration]) -> bytes:
    """A LensFun database with one lens, an entry for each calibration.

    Raises:
        UnsupportedModelError: LensFun does not know the model, or cannot hold its centre.
        OptionError: a focal length or the crop factor is not known, or calibrations contradict.
    """
    first = calibrations[0]
    facts = first.observations.lenses[0]
    if first.model not in MODELS:
        raise UnsupportedModelError(
            f"LensFun does not know the model {first.model}",
            hint=f"fit with one of {', '.join(MODELS)}, or write -o RESULT.json",
        )
    _refuse_several_lenses(calibrations)
    if len({(made.coefficients["d"], made.coefficients["e"]) for made in calibrations}) > 1:
        raise UnsupportedModelError(
            "a LensFun lens has one centre for all focal lengths, and these have several",
            hint="hold the centre with --hold d,e, or write each focal length by itself",
        )
    radius_px = first.lens.frame.radius_px
    head = LensfunLens(
        maker=facts.maker or "Unknown",
        model=lens_name(first),
        mount=facts.mount or "Generic",
        crop_factor=_crop_factor(calibrations),
        aspect_ratio=aspect_ratio(first),
        centre=(
            first.coefficients["d"] * first.lens.frame.pixel_aspect / radius_px,
            first.coefficients["e"] / radius_px,
        ),
        comment=_comment(calibrations),
    )
    return lensfun_xml(head, [_entry(made) for made in calibrations])


def _refuse_several_lenses(calibrations: Sequence[Calibration]) -> None:
    hint = "write each lens by itself: select a photo of it with --image N"
    names = list(dict.fromkeys(lens_name(made) for made in calibrations))
    if len(names) > 1:
        raise OptionError(f"these are several lenses, {' and '.join(names)}", hint=hint)
    shapes = [aspect_ratio(made) for made in calibrations]
    if max(shapes) / min(shapes) > 1 + _SAME_SHAPE:
        raise OptionError("the photos differ in their aspect ratio", hint=hint)


def _facts(calibrations: Sequence[Calibration]) -> list[LensFacts]:
    return [made.observations.lenses[0] for made in calibrations]


def _crop_factor(calibrations: Sequence[Calibration]) -> float:
    """The crop factor known best, where those of all calibrations agree within their errors."""
    every = _facts(calibrations)
    best = best_crop_factor(every)
    if not all(facts.crop_factor for facts in every):
        if all(made.observations.lenses[0].focal_mm for made in calibrations):
            raise OptionError("the crop factor is not known", hint="give it with --crop-factor")
        raise OptionError(
            "the focal length and the crop factor are not known",
            hint="give them with --focal and --crop-factor",
        )
    if best is None or best.crop_factor is None:
        raise OptionError("the crop factors differ", hint="give it with --crop-factor")
    return best.crop_factor


def aspect_ratio(made: Calibration) -> float:
    """Longer side over shorter side, as the user rounds it or as the photo has it.

    Raises:
        OptionError: the user gives another one than the photo's.
    """
    width, height = made.lens.frame.square_size
    given = made.observations.lenses[0].aspect_ratio
    if given is None:
        return max(width, height) / min(width, height)
    return checked_aspect_ratio(given, made.lens.frame)


def _entry(made: Calibration) -> Distortion:
    facts = made.observations.lenses[0]
    focal_mm = facts.focal_length_mm(made.lens.frame)
    if focal_mm is None:
        raise OptionError("the focal length is not known", hint="give it with --focal")
    names = made.lens.model.coefficients
    values = {name: made.coefficients[name] for name in names}
    return Distortion(made.model, focal_mm, values)


def lens_name(made: Calibration) -> str:
    """The lens by EXIF, else after its camera, else after the file of the points."""
    facts = made.observations.lenses[0]
    if facts.model:
        return facts.model
    if facts.camera:
        return f"{facts.camera} lens"
    origins = made.observations.origins
    return Path(origins[0].path).stem if origins else "Lens calibrated by plumbline"


def label_notes(calibrations: Sequence[Calibration]) -> list[str]:
    """What of a LensFun lens was not known and fell back, or is rounded, in plain sentences."""
    facts = calibrations[0].observations.lenses[0]
    best = best_crop_factor(_facts(calibrations))
    notes: list[str] = []
    if not facts.maker:
        notes.append("the maker is not known and written as Unknown (--maker)")
    if not facts.model:
        after = "its camera" if facts.camera else "the file of the points"
        name = lens_name(calibrations[0])
        notes.append(f"the lens is named after {after}: {name} (--lens-name)")
    if best and best.crop_factor_error:
        notes.append(
            f"the crop factor {best.crop_factor:.4g} is EXIF's 35-mm equivalent over the focal "
            f"length, good to {100 * best.crop_factor_error:.1f} % (--crop-factor)"
        )
    if not facts.mount:
        notes.append("the mount is not known and written as Generic (--mount)")
    return notes


def _comment(calibrations: Sequence[Calibration]) -> str:
    parts = [f"{MARK} {__version__}"]
    for made in calibrations:
        n_points, n_lines = made.observations.n_points, len(made.observations.lines)
        parts.append(
            f"at {_entry(made).focal_mm:g} mm {count(n_points, 'point')} on "
            f"{count(n_lines, 'line')}, rms {made.rms_before_px:.3f} px before, "
            f"{made.rms_after_px:.3f} px after"
        )
    labels = [_FLAGS.sub("", note) for note in label_notes(calibrations)]
    return "; ".join([*parts, *labels])

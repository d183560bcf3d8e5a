"""A LensFun profile from calibrations: which lens it is, what is known of it, its entries."""

from __future__ import annotations

import re
from collections.abc import Sequence

from plumbline._version import __version__
from plumbline.errors import OptionError, UnsupportedModelError
from plumbline.files import MARK
from plumbline.formats.lens_files.lensfun import MODELS, Distortion, lensfun_xml
from plumbline.observations.facts import LensFacts, best_crop_factor
from plumbline.result.calibration import Calibration
from plumbline.wording import count
from plumbline.writing.head import aspect_ratio, centre_of, focal_mm, lens_name, lensfun_head
from plumbline.writing.labels import spelt

_SAME_SHAPE = 0.02
"""Relative; chosen, cameras cut a few pixels off 3:2 and 4:3."""

_FLAGS = re.compile(r" \(--[^)]*\)")


def lensfun_bytes(calibrations: Sequence[Calibration]) -> bytes:
    """A LensFun database with one lens, an entry for each calibration.

    Raises:
        UnsupportedModelError: LensFun does not know the model, or cannot hold its centre.
        OptionError: a focal length or the crop factor is not known, or calibrations contradict.
    """
    first = calibrations[0]
    if first.model not in MODELS:
        raise UnsupportedModelError(
            f"LensFun does not know the model {first.model}",
            hint=f"fit with one of {', '.join(MODELS)}, or write -o RESULT.json",
        )
    _refuse_several_lenses(calibrations)
    if (
        len(
            {
                (calibration.coefficients["d"], calibration.coefficients["e"])
                for calibration in calibrations
            }
        )
        > 1
    ):
        raise UnsupportedModelError(
            "a LensFun lens has one centre for all focal lengths, and these have several",
            hint="hold the centre with --hold d,e, or write each focal length by itself",
        )
    entries = [_entry(calibration) for calibration in calibrations]
    head = lensfun_head(
        _facts(calibrations),
        first.lens.frame,
        _name(first),
        _comment(calibrations),
        centre_of(first.lens),
    )
    return lensfun_xml(head, entries)


def _refuse_several_lenses(calibrations: Sequence[Calibration]) -> None:
    hint = "write each lens by itself: select a photo of it with --image N"
    names = list(dict.fromkeys(_name(calibration) for calibration in calibrations))
    if len(names) > 1:
        raise OptionError(f"these are several lenses, {' and '.join(names)}", hint=hint)
    shapes = [
        aspect_ratio(_facts_of(calibration), calibration.lens.frame) for calibration in calibrations
    ]
    if max(shapes) / min(shapes) > 1 + _SAME_SHAPE:
        raise OptionError("the photos differ in their aspect ratio", hint=hint)


def _facts(calibrations: Sequence[Calibration]) -> list[LensFacts]:
    return [_facts_of(calibration) for calibration in calibrations]


def _entry(calibration: Calibration) -> Distortion:
    names = calibration.lens.model.coefficients
    values = {name: calibration.coefficients[name] for name in names}
    return Distortion(
        calibration.model, focal_mm(_facts_of(calibration), calibration.lens.frame), values
    )


def _facts_of(calibration: Calibration) -> LensFacts:
    return calibration.observations.lenses[0]


def _name(calibration: Calibration) -> str:
    return lens_name(_facts_of(calibration), calibration.observations)


def label_notes(calibrations: Sequence[Calibration]) -> list[str]:
    """What of a LensFun lens was not known and fell back, or is rounded, in plain sentences."""
    labels = spelt(_facts_of(calibrations[0]))
    facts = labels.facts
    best = best_crop_factor(_facts(calibrations))
    notes: list[str] = []
    if not facts.maker:
        notes.append("the maker is not known and written as Unknown (--maker)")
    if not facts.model:
        after = "its camera" if facts.camera else "the file of the points"
        name = _name(calibrations[0])
        notes.append(f"the lens is named after {after}: {name} (--lens-name)")
    if best and best.crop_factor_error:
        notes.append(
            f"the crop factor {best.crop_factor:.4g} is EXIF's 35-mm equivalent over the focal "
            f"length, good to {100 * best.crop_factor_error:.1f} % (--crop-factor)"
        )
    if not facts.mount:
        notes.append("the mount is not known and written as Generic (--mount)")
    return [*notes, *labels.notes]


def _comment(calibrations: Sequence[Calibration]) -> str:
    parts = [f"{MARK} {__version__}"]
    for calibration in calibrations:
        n_points, n_lines = calibration.observations.n_points, len(calibration.observations.lines)
        parts.append(
            f"at {_entry(calibration).focal_mm:g} mm {count(n_points, 'point')} on "
            f"{count(n_lines, 'line')}, rms {calibration.rms_before_px:.3f} px before, "
            f"{calibration.rms_after_px:.3f} px after"
        )
    labels = [_FLAGS.sub("", note) for note in label_notes(calibrations)]
    return "; ".join([*parts, *labels])

"""Write calibrations and picked points; the format follows the suffix."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from plumbline._version import __version__
from plumbline.calibration import Calibration
from plumbline.errors import OptionError, UnsupportedModelError, WriteError
from plumbline.files import MARK, refuse_to_clobber, write_atomically
from plumbline.formats.csv import write_csv
from plumbline.formats.lensfun import MODELS as LENSFUN_MODELS
from plumbline.formats.lensfun import Distortion, LensfunLens, lensfun_xml
from plumbline.formats.pto_writing import new_project, rewritten
from plumbline.observations import Observations
from plumbline.result_json import to_json

RESULT_SUFFIXES = (".pto", ".xml", ".json")
POINT_SUFFIXES = (".csv", ".pto")


def write(
    result: Calibration | Sequence[Calibration], path: str | Path, *, overwrite: bool = False
) -> Path:
    """Write calibrations; the format follows the suffix.

    `.pto`: the project they were read from, byte for byte but for the lens values, or a new
    one. `.xml`: a LensFun database. `.json`: everything, readable by `read_calibration`.

    Args:
        result: One calibration, or those of the several lenses of one project.
        path: Where to.
        overwrite: Replace a file that plumbline did not write.

    Returns:
        The path written.

    Raises:
        WriteError: the file exists and is not plumbline's, or cannot be written.
        UnsupportedModelError: the format cannot hold the distortion model.
        OptionError: LensFun needs a focal length or a crop factor that is not known.
    """
    calibrations = [result] if isinstance(result, Calibration) else list(result)
    target = Path(path)
    write_atomically({target: result_bytes(calibrations, target, overwrite=overwrite)})
    return target


def result_bytes(
    calibrations: Sequence[Calibration], target: Path, *, overwrite: bool = False
) -> bytes:
    """What `write` writes, after its checks; nothing is written yet.

    Raises:
        PlumblineError: as `write`.
    """
    suffix = target.suffix.lower()
    makers = {".pto": project_bytes, ".xml": lensfun_bytes, ".json": _json_bytes}
    if suffix not in makers:
        raise WriteError(
            f"the suffix {suffix or '(none)'} stands for no format of results",
            path=target,
            hint=f"use one of {', '.join(RESULT_SUFFIXES)}",
        )
    inputs = [path for made in calibrations for path in _inputs(made.observations)]
    refuse_to_clobber(target, inputs, overwrite=overwrite)
    return makers[suffix](calibrations)


def write_points(observations: Observations, path: str | Path, *, overwrite: bool = False) -> Path:
    """Write picked points as CSV or as a Hugin project; the format follows the suffix.

    Args:
        observations: The points.
        path: Where to, `.csv` or `.pto`.
        overwrite: Replace an existing file.

    Raises:
        WriteError: the file exists, or cannot be written.
    """
    target = Path(path)
    suffix = target.suffix.lower()
    if suffix not in POINT_SUFFIXES:
        raise WriteError(
            f"the suffix {suffix or '(none)'} stands for no format of points",
            path=path,
            hint=f"use one of {', '.join(POINT_SUFFIXES)}",
        )
    refuse_to_clobber(target, _inputs(observations), overwrite=overwrite)
    if suffix == ".csv":
        content = write_csv(observations).encode()
    else:
        content = new_project(observations, {})
    write_atomically({target: content})
    return target


def _inputs(observations: Observations) -> list[str]:
    return [origin.path for origin in observations.origins]


def _json_bytes(calibrations: Sequence[Calibration]) -> bytes:
    return to_json(calibrations).encode()


def project_bytes(calibrations: Sequence[Calibration]) -> bytes:
    """A Hugin project with the fitted lens values.

    Raises:
        UnsupportedModelError: the model is not `ptlens` and cannot be written as it.
    """
    values = [ptlens_values(made) for made in calibrations]
    origins = calibrations[0].observations.origins
    square = all(p.pixel_aspect == 1 for made in calibrations for p in made.observations.photos)
    if len(origins) == 1 and origins[0].format == "pto" and origins[0].content and square:
        of_photo = {
            photo.number: value
            for made, value in zip(calibrations, values, strict=True)
            for photo in made.observations.photos
        }
        return rewritten(origins[0].content, origins[0].path, of_photo)
    whole = Observations.side_by_side([made.observations for made in calibrations])
    return new_project(whole, dict(enumerate(values)))


def ptlens_values(made: Calibration) -> dict[str, float]:
    """a, b, c, d, e as Hugin has them, `d` at square pixels.

    Raises:
        UnsupportedModelError: the model has no such form.
    """
    coefficients = made.coefficients
    if made.model == "poly3":
        radial = {"a": 0.0, "b": coefficients["k1"], "c": 0.0}
    elif made.model == "ptlens":
        radial = {name: coefficients[name] for name in ("a", "b", "c")}
    else:
        raise UnsupportedModelError(
            f"a Hugin project cannot hold the model {made.model}",
            hint="fit with --model ptlens, or write -o RESULT.json",
        )
    frame = made.lens.frame
    aspect = round(frame.square_size[0]) / frame.width
    return radial | {"d": coefficients["d"] * aspect, "e": coefficients["e"]}


def lensfun_bytes(calibrations: Sequence[Calibration]) -> bytes:
    """A LensFun database with one lens, an entry for each calibration.

    Raises:
        UnsupportedModelError: LensFun does not know the model, or cannot hold its centre.
        OptionError: a focal length or the crop factor is not known, or calibrations contradict.
    """
    first = calibrations[0]
    facts = first.observations.lenses[0]
    if first.model not in LENSFUN_MODELS:
        raise UnsupportedModelError(
            f"LensFun does not know the model {first.model}",
            hint=f"fit with one of {', '.join(LENSFUN_MODELS)}, or write -o RESULT.json",
        )
    _refuse_several_lenses(calibrations)
    if len({(made.coefficients["d"], made.coefficients["e"]) for made in calibrations}) > 1:
        raise UnsupportedModelError(
            "a LensFun lens has one centre for all focal lengths, and these have several",
            hint="hold the centre with --hold d,e, or write each focal length by itself",
        )
    crops = {made.observations.lenses[0].crop_factor for made in calibrations}
    crop_factor = facts.crop_factor
    if len(crops) > 1 or crop_factor is None:
        raise OptionError(
            "the crop factor is not known" if None in crops else "the crop factors differ",
            hint="give it with --crop-factor",
        )
    radius_px = first.lens.frame.radius_px
    head = LensfunLens(
        maker=facts.maker or "Unknown",
        model=lens_name(first),
        mount=facts.mount or "Generic",
        crop_factor=crop_factor,
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
    if max(shapes) / min(shapes) > 1.02:
        raise OptionError("the photos differ in their aspect ratio", hint=hint)


def aspect_ratio(made: Calibration) -> float:
    """Longer side over shorter side, as the user rounds it or as the photo has it."""
    width, height = made.lens.frame.square_size
    given = made.observations.lenses[0].aspect_ratio
    return given or max(width, height) / min(width, height)


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


def label_notes(made: Calibration) -> list[str]:
    """Which labels of a LensFun lens were not known and fell back, in plain sentences."""
    facts = made.observations.lenses[0]
    notes: list[str] = []
    if not facts.maker:
        notes.append("the maker is not known and written as Unknown (--maker)")
    if not facts.model:
        after = "its camera" if facts.camera else "the file of the points"
        notes.append(f"the lens is named after {after}: {lens_name(made)} (--lens-name)")
    if facts.crop_factor and facts.crop_factor_error:
        notes.append(
            f"the crop factor {facts.crop_factor:.4g} is EXIF's 35-mm equivalent over the focal "
            f"length, good to {100 * facts.crop_factor_error:.1f} % (--crop-factor)"
        )
    if not facts.mount:
        notes.append("the mount is not known and written as Generic (--mount)")
    return notes


def _comment(calibrations: Sequence[Calibration]) -> str:
    parts = [f"{MARK} {__version__}"]
    for made in calibrations:
        parts.append(
            f"{made.observations.n_points} points on {len(made.observations.lines)} lines, "
            f"rms {made.rms_before_px:.3f} px before, {made.rms_after_px:.3f} px after"
        )
    return "; ".join([*parts, *label_notes(calibrations[0])])

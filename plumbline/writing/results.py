"""Write calibrations and picked points; the format follows the suffix."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from plumbline.errors import OptionError, UnsupportedModelError, WriteError, refuse_other_type
from plumbline.files import (
    MARK,
    as_path,
    read_bytes,
    refuse_to_clobber,
    refuse_unknown_suffix,
    sealed,
    write_atomically,
)
from plumbline.formats.known import suffixes
from plumbline.formats.panotools.pto_writing import new_project, rewritten
from plumbline.observations import Observations, Origin
from plumbline.result.calibration import Calibration
from plumbline.result.given import as_calibrations, refuse_unsettled
from plumbline.result.writing import to_json
from plumbline.wording import count
from plumbline.writing.lensfun import lensfun_bytes

RESULT_SUFFIXES = tuple(suffixes("results"))
POINT_SUFFIXES = tuple(suffixes("points"))


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
        UnsettledError: a fit did not reach a minimum; only JSON holds it.
    """
    calibrations, target = as_calibrations(result), as_path(path)
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
    refuse_unknown_suffix(target, RESULT_SUFFIXES, "results")
    inputs = [path for calibration in calibrations for path in _inputs(calibration.observations)]
    refuse_to_clobber(target, inputs, overwrite=overwrite)
    if suffix != ".json":
        refuse_unsettled(calibrations)
    content = sealed(_WRITERS[suffixes("results")[suffix].name](calibrations))
    if suffix == ".pto" and not overwrite:
        _refuse_edited(target, content)
    return content


def _refuse_edited(target: Path, content: bytes) -> None:
    """Refuse to replace a fitted project that someone edited since.

    A project that was read is written back byte for byte, so that no seal tells it. Lines of the
    old file that the new one lacks are edits, but for picks and for what they are fitted with,
    which change in the project that was read.
    """
    if not target.is_file() or _is_new(content):
        return
    old, new = (_lines_of(each) for each in (read_bytes(target), content))
    lost = [line for line in old if line not in set(new)]
    if lost:
        raise WriteError(
            f"this file was edited since plumbline wrote it: {count(len(lost), 'line')} would be "
            f"lost, the first {lost[0].decode(errors='replace')[:60]!r}",
            path=target,
            hint="choose another name with -o, or replace it with --overwrite",
        )


def _is_new(content: bytes) -> bool:
    return MARK.encode() in content[:1024]


def _lines_of(content: bytes) -> list[bytes]:
    """Lines of a project that a fit leaves alone: neither images nor picks nor variables."""
    return [line for line in content.splitlines() if line.strip() and line[:1] not in b"icv"]


def write_points(observations: Observations, path: str | Path, *, overwrite: bool = False) -> Path:
    """Write picked points as CSV, JSON or a Hugin project; the format follows the suffix.

    Args:
        observations: The points. What is known of the lenses and the photos' sizes go into a
            project and into JSON only.
        path: Where to, `.csv`, `.json` or `.pto`.
        overwrite: Replace a file that plumbline did not mark as its own, as it does all but CSV.

    Raises:
        WriteError: the file exists and is not marked as plumbline's, or cannot be written.
        OptionError: a CSV would mix the lines of several lenses.
    """
    refuse_other_type(observations, Observations, "Observations", "read them with plumbline.read")
    target = as_path(path)
    write_atomically({target: points_bytes(observations, target, overwrite=overwrite)})
    return target


def points_bytes(observations: Observations, target: Path, *, overwrite: bool = False) -> bytes:
    """What `write_points` writes, after its checks; nothing is written yet.

    Raises:
        PlumblineError: as `write_points`.
    """
    refuse_unknown_suffix(target, POINT_SUFFIXES, "points")
    content = sealed(suffixes("points")[target.suffix.lower()].write(observations))
    same = target.is_file() and read_bytes(target) == content
    refuse_to_clobber(target, _inputs(observations), overwrite=overwrite or same)
    return content


def resampling_notes(observations: Observations) -> list[str]:
    """For which photos a Hugin project is, where pixels are not square; in plain sentences."""
    return [
        f"the Hugin project is for {before.name or 'the photo'} resampled to "
        f"{after.frame.width}x{after.frame.height}, where its pixels are square"
        for before, after in zip(observations.photos, observations.squared().photos, strict=True)
        if before.pixel_aspect != 1
    ]


def _inputs(observations: Observations) -> list[str]:
    return [origin.path for origin in observations.origins]


def _json_bytes(calibrations: Sequence[Calibration]) -> bytes:
    return to_json(calibrations).encode()


def project_bytes(calibrations: Sequence[Calibration]) -> bytes:
    """A Hugin project with the fitted lens values.

    It is the project that all calibrations were read from, else a new one.

    Raises:
        UnsupportedModelError: the model is not `ptlens` and cannot be written as it.
        OptionError: two calibrations are of the same photo.
    """
    values = [ptlens_values(calibration) for calibration in calibrations]
    square = all(
        p.pixel_aspect == 1 for calibration in calibrations for p in calibration.observations.photos
    )
    project = _common_project(calibrations)
    if project is not None and square:
        return rewritten(project.content, project.path, _of_photos(calibrations, values))
    whole = Observations.side_by_side([calibration.observations for calibration in calibrations])
    return new_project(whole, dict(enumerate(values)))


def _common_project(calibrations: Sequence[Calibration]) -> Origin | None:
    first, *others = [calibration.observations.origins for calibration in calibrations]
    if len(first) != 1 or any(other != first for other in others):
        return None
    return first[0] if first[0].format == "pto" and first[0].content else None


def _of_photos(
    calibrations: Sequence[Calibration], values: Sequence[dict[str, float]]
) -> dict[int, dict[str, float]]:
    """The lens values of each photo number of one project."""
    found: dict[int, dict[str, float]] = {}
    for calibration, value in zip(calibrations, values, strict=True):
        for photo in calibration.observations.photos:
            if photo.number in found:
                raise OptionError(
                    f"two calibrations are of photo number {photo.number} of the project",
                    hint="write one of them, or both as .json",
                )
            found[photo.number] = value
    return found


def ptlens_values(calibration: Calibration) -> dict[str, float]:
    """a, b, c, d, e as Hugin has them, `d` at square pixels.

    Raises:
        UnsupportedModelError: the model has no such form.
    """
    coefficients = calibration.coefficients
    radial = calibration.lens.model.ptlens_values(coefficients)
    if radial is None:
        raise UnsupportedModelError(
            f"a Hugin project cannot hold the model {calibration.model}",
            hint="fit with --model ptlens, or write -o RESULT.json",
        )
    frame = calibration.lens.frame
    aspect = round(frame.square_size[0]) / frame.width
    return radial | {"d": coefficients["d"] * aspect, "e": coefficients["e"]}


_WRITERS = {"json": _json_bytes, "pto": project_bytes, "lensfun": lensfun_bytes}
"""How the results of fits are written to each format that holds them."""

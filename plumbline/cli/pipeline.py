"""From files and flags to observations and written results: the verbs minus their parsing."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from plumbline.calibration import Calibration
from plumbline.errors import OptionError, PlumblineError
from plumbline.files import is_same, write_atomically
from plumbline.lensfun_writing import checked_aspect_ratio, label_notes
from plumbline.observations import Observations
from plumbline.reading import join, read
from plumbline.wording import listed
from plumbline.writing import resampling_notes, result_bytes

_FACTS = {
    "maker": "maker",
    "lens_name": "model",
    "mount": "mount",
    "focal": "focal_mm",
    "focal_px": "focal_px",
    "crop_factor": "crop_factor",
    "aspect_ratio": "aspect_ratio",
}
"""What the options that describe a lens are called in `LensFacts`."""


def parts_of(sources: Sequence[str], options: Mapping[str, Any]) -> list[Observations]:
    """What a verb reads: the observations of each lens in its files.

    Args:
        sources: Files of points.
        options: Values of `options.reading` and of those of `options.labelling` that it takes.

    Raises:
        PlumblineError: as `gather` and `split_by_lens`.
    """
    labels = labels_of(options)
    how = {name: value for name, value in options.items() if name not in _FACTS}
    return split_by_lens(gather(sources, **how), labels)


def labels_of(options: Mapping[str, Any]) -> dict[str, Any]:
    """What `options.labelling` says of a lens, by the names of `LensFacts`."""
    return {fact: options.get(name) for name, fact in _FACTS.items()}


def gather(sources: Sequence[str], image: int | None, **how: Any) -> Observations:
    """Read one or several files of points, of each only photo number `image` if it is given.

    Raises:
        OptionError: a file is named twice, there is no such photo, or it has no lines.
    """
    for index, source in enumerate(sources):
        if any(is_same(Path(source), other) for other in sources[:index]):
            raise OptionError(
                f"{source}: this file is named twice, and its points would count twice",
                hint="name each file once",
            )
    return join([read(source, image=image, **how) for source in sources])


def command_line() -> str:
    """The command as it was given, for the record."""
    return shlex.join(["plumbline", *sys.argv[1:]])


def split_by_lens(observations: Observations, labels: Mapping[str, Any]) -> list[Observations]:
    """One set of observations for each lens that has lines, with the user's facts of it.

    Args:
        observations: What was read.
        labels: Values of the options `--maker`, `--focal` and so on, None where not given.

    Raises:
        OptionError: facts of one lens are given for several.
    """
    with_lines = sorted({observations.photos[line.photo].lens for line in observations.lines})
    given = {name: value for name, value in labels.items() if value is not None}
    if "crop_factor" in given:
        given["crop_factor_error"] = None
    single = {"focal_mm": "--focal", "focal_px": "--focal-px"}
    if len(with_lines) > 1 and (wrong := single.keys() & given.keys()):
        raise OptionError(
            f"{single[min(wrong)]} is given once, but the project has {len(with_lines)} lenses",
            hint="select one with --image N",
        )
    parts: list[Observations] = []
    for lens in with_lines:
        part = observations.of_lens(lens)
        if "aspect_ratio" in given:
            frame = part.photos[0].frame
            given["aspect_ratio"] = checked_aspect_ratio(given["aspect_ratio"], frame)
        facts = replace(part.lenses[0], **given)
        parts.append(replace(part, lenses=(facts,)))
    return parts


def write_results(
    calibrations: Sequence[Calibration],
    outputs: Sequence[str],
    source: str,
    drawn: Mapping[Path, bytes],
    *,
    overwrite: bool,
) -> tuple[list[Path], list[str]]:
    """Write what the user asks for, or what can be written beside the input.

    Args:
        calibrations: One a lens.
        outputs: Files the user names; empty for the defaults.
        source: The first input.
        drawn: Reports and figures, which are written with them: all or nothing.
        overwrite: Replace files that plumbline did not write.

    Returns:
        The files written, and notes on what was not written, on labels that fell back and on
        photos that are resampled.
    """
    chosen = [Path(name) for name in outputs] or [
        Path(source).with_suffix(f".fit{suffix}") for suffix in (".pto", ".xml")
    ]
    contents: dict[Path, bytes] = {}
    notes: list[str] = []
    for target in chosen:
        try:
            contents[target] = result_bytes(calibrations, target, overwrite=overwrite)
        except OptionError as error:
            if outputs:
                raise
            older = "; the one that is there is not of this fit" if target.exists() else ""
            notes.append(f"{target.name} was not written: {error.message} ({error.hint}){older}")
            continue
        if target.suffix.lower() == ".xml":
            notes += label_notes(calibrations)
        elif target.suffix.lower() == ".pto":
            notes += [n for made in calibrations for n in resampling_notes(made.observations)]
    if not contents:
        target = Path(source).with_suffix(".fit.json")
        contents[target] = result_bytes(calibrations, target, overwrite=overwrite)
    contents |= drawn
    write_atomically(contents)
    return list(contents), list(dict.fromkeys(notes))


def name_the_source(error: PlumblineError, part: Observations, n_parts: int) -> PlumblineError:
    """Say which files an error is about, and which photos where a project has several lenses."""
    message = error.message
    if n_parts > 1:
        names = [f"{photo.number} {photo.name}".strip() for photo in part.photos]
        message = f"photo {listed(names)}: {message}"
    files = listed(list(dict.fromkeys(origin.path for origin in part.origins)), 3)
    if not message.startswith(files):
        message = f"{files}: {message}"
    return type(error)(message, hint=error.hint)

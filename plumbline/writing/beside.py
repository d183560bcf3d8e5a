"""What a fit writes: the files that the user names, or those beside the input."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from plumbline.errors import OptionError
from plumbline.files import as_path, write_atomically
from plumbline.result.calibration import Calibration
from plumbline.result.given import as_calibrations, refuse_unsettled
from plumbline.writing.lensfun import label_notes
from plumbline.writing.results import resampling_notes, result_bytes


def command_line() -> str:
    """The command as it was given, for the record."""
    return shlex.join(["plumbline", *sys.argv[1:]])


def write_beside(
    result: Calibration | Sequence[Calibration], source: str | Path, *, overwrite: bool = False
) -> tuple[list[Path], list[str]]:
    """Write the files that `plumbline fit` writes when none is named.

    For `building.pto` these are `building.fit.pto` and `building.fit.xml` in its folder, or
    `building.fit.json` where neither can hold the lens.

    Args:
        result: One calibration, or those of the several lenses of one project.
        source: The file of points, whose name they take.
        overwrite: Replace files that plumbline did not write.

    Returns:
        The files written, and notes in plain sentences on what was not written or assumed.

    Raises:
        WriteError: a file exists and is not plumbline's, or cannot be written; then none is.
        UnsettledError: a fit did not reach a minimum.
    """
    calibrations = as_calibrations(result)
    refuse_unsettled(calibrations)
    return write_results(calibrations, (), str(as_path(source)), {}, overwrite=overwrite)


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
            notes += [
                n
                for calibration in calibrations
                for n in resampling_notes(calibration.observations)
            ]
    if not contents:
        target = Path(source).with_suffix(".fit.json")
        contents[target] = result_bytes(calibrations, target, overwrite=overwrite)
    contents |= drawn
    write_atomically(contents)
    return list(contents), list(dict.fromkeys(notes))

"""From a result file to the bytes of an exported one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from plumbline.errors import OptionError
from plumbline.files import (
    RESULT,
    ZOOM,
    as_path,
    read_bytes,
    refuse_to_clobber,
    write_atomically,
)
from plumbline.formats.base import Source
from plumbline.formats.known import FORMATS
from plumbline.lenses.stored import StoredLens
from plumbline.lenses.stored_files import stored_lenses
from plumbline.reading.gathering import labelled
from plumbline.writing.export import export
from plumbline.writing.targets import TARGETS

ALLOWED_PX = 0.1
"""The largest deviation of a refitted lens that is written without being forced: chosen, a tenth of
what can be seen."""


@dataclass(frozen=True)
class ExportedFile:
    """An exported lens and where it goes.

    Attributes:
        path: The file to write.
        content: What it holds.
        deviation_px: How far a refitted lens differs; None if it was not refitted.
        model: The model it was refitted to.
        notes: What to be aware of.
    """

    path: Path
    content: bytes
    deviation_px: float | None = None
    model: str = ""
    notes: tuple[str, ...] = ()


def export_file(
    result: str,
    target: str,
    output: Path | None,
    image: int | None,
    facts: Mapping[str, Any],
    *,
    force: bool = False,
) -> ExportedFile:
    """Make the file of a target; nothing is written yet.

    Args:
        result: A result JSON, a project or a Hugin lens file.
        target: A row of `TARGETS`, or "json".
        output: Where to; beside the result if None.
        image: Which of several lenses.
        facts: Facts about the lens that the user gives, by the names of `LensFacts`.
        force: Accept a deviation above 0.1 px.

    Raises:
        PlumblineError: the result is damaged, or the target cannot hold its lens.
    """
    known = (*TARGETS, "json")
    if target not in known:
        raise OptionError(f"there is no target {target!r}", hint=f"use one of {', '.join(known)}")
    source = Source(result, read_bytes(result))
    path = output or Path(result).with_suffix(f".{target}{FORMATS[target].suffixes[0]}")
    if target == "json":
        if f'"{RESULT}"' not in source.head[:1024]:
            raise OptionError(
                f"{result} holds lens values only, and a result JSON holds the points and the fit",
                hint="export to another format, or fit picked points with plumbline fit -o x.json",
            )
        stored_lenses(source)
        return ExportedFile(path, source.content)
    stored = one_lens(source, image)
    calibration = export(replace(stored, **_with_facts(stored, facts)), target)
    if calibration.deviation_px is not None and calibration.deviation_px > ALLOWED_PX and not force:
        raise OptionError(
            f"{target} cannot hold the model {stored.lens.model.label} with its coefficients: as "
            f"{calibration.model} it is up to {calibration.deviation_px:.2f} px off over the photo",
            hint=f"write it all the same with --force, or fit with --model {calibration.model}",
        )
    return ExportedFile(
        path, calibration.content, calibration.deviation_px, calibration.model, calibration.notes
    )


def one_lens(source: Source, image: int | None) -> StoredLens:
    """The lens of a file, or number `image` of its lenses.

    Raises:
        ReadError: the file is damaged, or holds no lens at one focal length.
        OptionError: there are several and none was chosen, or there is no such.
    """
    if f'"{ZOOM}"' in source.head[:1024]:
        raise source.error(
            "this is a zoom lens, and one focal length is exported at a time",
            hint="plumbline zoom RESULT… -o lens.xml writes all for LensFun",
        )
    lenses = stored_lenses(source)
    if image is not None:
        if image >= len(lenses):
            raise OptionError(
                f"{source.path} has no lens number {image}; there are {len(lenses)}",
                hint="lenses are counted from 0",
            )
        return lenses[image]
    first = lenses[0]
    alike = all(
        each.lens == first.lens and each.facts.focal_mm == first.facts.focal_mm for each in lenses
    )
    if not alike:
        raise OptionError(
            f"{source.path} holds {len(lenses)} lenses", hint="select one with --image N"
        )
    return first


def _with_facts(stored: StoredLens, facts: Mapping[str, Any]) -> dict[str, Any]:
    known = labelled(stored.facts, facts, stored.lens.frame)
    observations = stored.observations
    if observations is not None:
        observations = replace(observations, lenses=(known,))
    return {"facts": known, "observations": observations}


def write_export(
    result: str | Path,
    to: str,
    path: str | Path | None = None,
    *,
    image: int | None = None,
    force: bool = False,
    overwrite: bool = False,
    **facts: Any,
) -> ExportedFile:
    """Write a calibrated lens for another program.

    Args:
        result: The file of a result (JSON), of a project with lens values, or a Hugin lens file.
        to: What to write, as `plumbline export --to` names it.
        path: Where to; beside the result by default.
        image: Which of several lenses of the file, counted from 0.
        force: Write even if a refitted lens deviates by more than 0.1 px.
        overwrite: Replace a file that plumbline did not write.
        facts: Facts about the lens, by the names of `LensFacts`.

    Returns:
        What was written and where, with the deviation of a refitted lens and notes.

    Raises:
        PlumblineError: the result is damaged, the target cannot hold its lens, or the file
            cannot be written.
    """
    place = None if path is None else as_path(path)
    exported = export_file(str(as_path(result)), to, place, image, facts, force=force)
    refuse_to_clobber(exported.path, [str(result)], overwrite=overwrite)
    write_atomically({exported.path: exported.content})
    return exported

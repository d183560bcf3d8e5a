"""From files and the options of the verbs to the observations of each lens."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from plumbline.errors import OptionError
from plumbline.files import read_bytes
from plumbline.formats.base import Source
from plumbline.formats.known import FORMATS
from plumbline.frame import Frame
from plumbline.observations import Observations
from plumbline.observations.facts import LensFacts, checked_aspect_ratio
from plumbline.reading.points import read

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

_PHOTOS = (".jpg", ".jpeg", ".png", ".tif", ".tiff", ".webp")
"""Suffixes of photographs that are decoded."""


def parts_of(sources: Sequence[str], options: Mapping[str, Any]) -> list[Observations]:
    """What a verb reads: the observations of each lens in its files.

    Args:
        sources: Files of points.
        options: Values of `options.reading` and of those of `options.labelling` that it takes.

    Raises:
        PlumblineError: as `read` and `split_by_lens`.
    """
    labels = labels_of(options)
    how = {name: value for name, value in options.items() if name not in _FACTS}
    return split_by_lens(read(sources, **how), labels)


def photo_alone(sources: Sequence[str], format_name: str | None = None) -> bool:
    """Whether the only source is a photograph, not a file of points.

    A TIFF of ImageJ may hold points: a file that a format recognises is one of points.
    """
    if len(sources) != 1 or format_name is not None:
        return False
    path = Path(sources[0])
    if path.suffix.lower() not in _PHOTOS or not path.is_file():
        return False
    source = Source(str(path), read_bytes(path))
    return not any(each.recognises(source) for each in FORMATS.values())


def labels_of(options: Mapping[str, Any]) -> dict[str, Any]:
    """What `options.labelling` says of a lens, by the names of `LensFacts`."""
    return {fact: options.get(name) for name, fact in _FACTS.items()}


def labelled(facts: LensFacts, labels: Mapping[str, Any], frame: Frame) -> LensFacts:
    """Facts of a lens with what the user says of it.

    Args:
        facts: What files tell.
        labels: Of `labels_of`.
        frame: The first photo's.

    Raises:
        OptionError: the aspect ratio is not the photo's.
    """
    given = {name: value for name, value in labels.items() if value is not None}
    if "crop_factor" in given:
        given["crop_factor_error"] = None
    if "aspect_ratio" in given:
        given["aspect_ratio"] = checked_aspect_ratio(given["aspect_ratio"], frame)
    return replace(facts, **given)


def split_by_lens(observations: Observations, labels: Mapping[str, Any]) -> list[Observations]:
    """One set of observations for each lens that has lines, with the user's facts of it.

    Args:
        observations: What was read.
        labels: Values of the options `--maker`, `--focal` and so on, None where not given.

    Raises:
        OptionError: facts of one lens are given for several.
    """
    with_lines = sorted({observations.photos[line.photo].lens for line in observations.lines})
    given = {name for name, value in labels.items() if value is not None}
    single = {"focal_mm": "--focal", "focal_px": "--focal-px"}
    if len(with_lines) > 1 and (wrong := single.keys() & given):
        raise OptionError(
            f"{single[min(wrong)]} is given once, but the project has {len(with_lines)} lenses",
            hint="select one with --image N",
        )
    parts: list[Observations] = []
    for lens in with_lines:
        part = observations.of_lens(lens)
        facts = labelled(part.lenses[0], labels, part.photos[0].frame)
        parts.append(replace(part, lenses=(facts,)))
    return parts

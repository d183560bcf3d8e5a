"""A zoom lens from result files, and as the files that other programs and plumbline read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from plumbline._version import __version__
from plumbline.errors import OptionError, UnsupportedModelError
from plumbline.files import (
    MARK,
    RESULT,
    ZOOM,
    is_same,
    read_bytes,
    refuse_to_clobber,
    refuse_unknown_suffix,
    sealed,
    write_atomically,
)
from plumbline.formats.base import Source
from plumbline.formats.known import suffixes
from plumbline.formats.lens_files.lenses_txt import lenses_txt
from plumbline.formats.lens_files.lensfun import MODELS, Distortion, LensfunLens, lensfun_xml
from plumbline.frame import Frame
from plumbline.lenses.zoom.curves import Method, lensfun_values
from plumbline.lenses.zoom.join import join
from plumbline.lenses.zoom.json import zoom_text
from plumbline.lenses.zoom.needs import displacement_px
from plumbline.lenses.zoom.zoom_lens import ZoomLens
from plumbline.models import CENTRE
from plumbline.reading.gathering import labelled
from plumbline.result.calibration import Calibration
from plumbline.result.files import consistent_results
from plumbline.result.given import refuse_unsettled
from plumbline.wording import count
from plumbline.writing.head import lens_name, lensfun_head

ZOOM_SUFFIXES = tuple(suffixes("zoom"))
_APART_PX, _ALIKE_PX = 0.1, 0.01
"""Differences below which no note is made, of centres and of curves; chosen, nobody sees them."""
_BETWEEN = 8
"""Focal lengths looked at between two that were fitted; chosen, the curve is smooth."""


def read_zoom_lens(
    paths: Sequence[str],
    method: Method = "hermite",
    degree: int = 3,
    labels: Mapping[str, Any] | None = None,
) -> ZoomLens:
    """Join the calibrations of result files.

    Args:
        paths: The files.
        method: How coefficients run over focal length.
        degree: Of the polynomial.
        labels: Facts about the lens that the user gives, by the names of `LensFacts`.

    Raises:
        PlumblineError: a file is damaged, or the calibrations do not belong together.
    """
    calibrations: list[tuple[str, Calibration]] = []
    for index, path in enumerate(paths):
        if any(is_same(Path(path), other) for other in paths[:index]):
            raise OptionError(
                f"{path}: this file is named twice, and its calibrations would count twice",
                hint="name each file once",
            )
        source = Source(path, read_bytes(path))
        if f'"{ZOOM}"' in source.head[:1024]:
            raise source.error(
                "this is a zoom lens already", hint="name the results that it was made from"
            )
        if f'"{RESULT}"' not in source.head[:1024]:
            raise source.error(
                "this is not a calibration written by plumbline",
                hint="write one with plumbline fit POINTS -o result.json",
            )
        calibrations += [
            (path, calibration) for calibration in consistent_results(source.text(), path)
        ]
    refuse_unsettled([calibration for _, calibration in calibrations])
    lens = join(calibrations, method, degree)
    frame = Frame(*lens.size, lens.pixel_aspect)
    return replace(lens, facts=labelled(lens.facts, labels or {}, frame))


def zoom_bytes(lens: ZoomLens, target: Path) -> tuple[bytes, list[str]]:
    """What a file of that name holds, and notes on what it cannot hold.

    Raises:
        WriteError: the suffix stands for no format.
        OptionError: the format needs what is not known, or cannot hold the model.
    """
    refuse_unknown_suffix(target, ZOOM_SUFFIXES, "zoom lenses")
    return _WRITERS[suffixes("zoom")[target.suffix.lower()].name](lens, target)


def _json(lens: ZoomLens, _target: Path) -> tuple[bytes, list[str]]:
    return zoom_text(lens).encode(), []


def _lensfun(lens: ZoomLens, target: Path) -> tuple[bytes, list[str]]:
    _refuse_unknown_model(lens, target, MODELS)
    entries = _entries(lens)
    notes = _notes(lens, entries)
    centre, apart_px = _centre(lens)
    if apart_px > _APART_PX:
        notes.append(
            f"LensFun holds one distortion centre for all focal lengths: the mean was written, "
            f"up to {apart_px:.1f} px from those of single focal lengths"
        )
    return sealed(lensfun_xml(_head(lens, centre), entries)), notes


def _lenses_txt(lens: ZoomLens, target: Path) -> tuple[bytes, list[str]]:
    _refuse_unknown_model(lens, target, ("ptlens", "poly3"))
    entries = _entries(lens)
    notes = _notes(lens, entries)
    if any(np.any(node.values[-2:]) for node in lens.nodes):
        notes.append("lenses.txt holds no distortion centre: it was left out")
    rows = [(entry.focal_mm, list(entry.coefficients.values())) for entry in entries]
    return sealed(lenses_txt(_head(lens), rows, f"{MARK} {__version__}")), notes


_WRITERS = {"json": _json, "lensfun": _lensfun, "lenses-txt": _lenses_txt}
"""Who writes a zoom lens, by the name of the format."""


def _refuse_unknown_model(lens: ZoomLens, target: Path, known: Sequence[str]) -> None:
    if lens.model.label not in known:
        raise UnsupportedModelError(
            f"{target.name}: LensFun does not know the model {lens.model.label} there",
            hint=f"fit with --model {' or '.join(known)}, or write a .json",
        )


def _head(lens: ZoomLens, centre: tuple[float, float] = (0.0, 0.0)) -> LensfunLens:
    sources = sum(len(node.sources) for node in lens.nodes)
    comment = f"{MARK} {__version__} from {count(sources, 'calibration')}"
    frame = Frame(*lens.size, lens.pixel_aspect)
    return lensfun_head([lens.facts], frame, lens_name(lens.facts), comment, centre)


def _entries(lens: ZoomLens) -> list[Distortion]:
    """The curve at the calibrated focal lengths."""
    names = lens.model.coefficients
    return [
        Distortion(
            lens.model.label,
            node.focal_mm,
            dict(zip(names, (float(v) for v in lens.at(node.focal_mm)), strict=False)),
        )
        for node in lens.nodes
    ]


def _notes(lens: ZoomLens, entries: Sequence[Distortion]) -> list[str]:
    """How far LensFun's own interpolation leaves the curve."""
    worst_px, at_mm = 0.0, 0.0
    for focal_mm in np.geomspace(*lens.range_mm, _BETWEEN * len(entries)):
        ours = lens.at(float(focal_mm))
        found = lensfun_values(entries, float(focal_mm)).coefficients
        theirs = np.array([*found.values(), *ours[-len(CENTRE) :]])
        off = displacement_px(lens, ours) - displacement_px(lens, theirs)
        distance_px = float(np.max(np.hypot(*off.T)))
        if distance_px > worst_px:
            worst_px, at_mm = distance_px, float(focal_mm)
    if worst_px < _ALIKE_PX:
        return []
    return [
        "LensFun interpolates between these focal lengths in its own way, up to "
        f"{worst_px:.2f} px from the {lens.method} curve (at {at_mm:.4g} mm)"
    ]


def _centre(lens: ZoomLens) -> tuple[tuple[float, float], float]:
    """Mean distortion centre in half shorter sides, and how far single ones are from it in px."""
    centres = np.stack([node.values[-2:] for node in lens.nodes])
    mean = centres.mean(axis=0)
    radius_px = Frame(*lens.size, lens.pixel_aspect).radius_px
    apart = float(np.max(np.hypot(*(centres - mean).T))) * radius_px
    return (float(mean[0]), float(mean[1])), apart


def write_zoom(lens: ZoomLens, path: str | Path, *, overwrite: bool = False) -> Path:
    """Write a zoom lens; the format follows the suffix: `.json`, `.xml` or `.txt`.

    Args:
        lens: The lens, from `read_zoom_lens`.
        path: Where to.
        overwrite: Replace a file that plumbline did not write.

    Raises:
        WriteError: the file exists and is not plumbline's, or its suffix stands for no format.
        OptionError: the format needs what is not known, or cannot hold the model.
    """
    target = Path(path)
    content, _ = zoom_bytes(lens, target)
    refuse_to_clobber(target, (), overwrite=overwrite)
    write_atomically({target: content})
    return target

"""Reports and single figures as the bytes of files."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from plumbline.errors import PlumblineError, WriteError
from plumbline.files import as_path, refuse_to_clobber, refuse_unknown_suffix, write_atomically
from plumbline.report.photos import find_photos
from plumbline.result.calibration import Calibration
from plumbline.result.given import as_calibrations, refuse_unsettled
from plumbline.result.pair import PairCalibration

if TYPE_CHECKING:
    from plumbline.observations import Observations
    from plumbline.report.figures import Subject
    from plumbline.result.comparison import Comparison

_PAGES = (".html", ".htm")
_FIGURES = (".png", ".svg")


def check_targets(report: str | None, plots: Sequence[str]) -> None:
    """Refuse names of which it is not clear what to write, before anything is computed.

    Raises:
        WriteError: a suffix stands for nothing, or a name for no figure.
    """
    if report is not None:
        refuse_unknown_suffix(Path(report), _PAGES, "reports")
    for name in plots:
        figure_name(Path(name))


def figure_name(target: Path) -> str:
    """Which figure a file is to hold: `out/building.curve.png` holds `curve`.

    Raises:
        WriteError: there is no figure of that name, or the suffix is neither .png nor .svg.
    """
    from plumbline.report.figures import FIGURES

    refuse_unknown_suffix(target, _FIGURES, "figures")
    name = target.stem.rpartition(".")[2]
    if name not in FIGURES:
        raise WriteError(
            f"there is no figure {name!r}",
            path=target,
            hint=f"use one of {', '.join(FIGURES)}, as in curve.svg or building.curve.svg",
        )
    return name


def _targets(plot: Path, calibrations: Sequence[Calibration]) -> list[tuple[Path, int, int]]:
    """One file for each lens (each photo for `photo`), numbered from 1 if there are several.

    Returns:
        The file, and the numbers of the lens and of the photo that it shows.
    """
    from plumbline.report.page.figures import shown_photos

    name = figure_name(plot)
    shown = [
        (lens, photo)
        for lens, calibration in enumerate(calibrations)
        for photo in shown_photos(name, calibration)
    ]
    if len(shown) == 1:
        return [(plot, *shown[0])]
    before = plot.name.removesuffix(f"{name}{plot.suffix}")
    return [
        (plot.with_name(f"{before}{number}.{name}{plot.suffix}"), *which)
        for number, which in enumerate(shown, 1)
    ]


def refuse_targets(
    calibrations: Sequence[Calibration],
    report: str | None,
    plots: Sequence[str],
    inputs: Sequence[str | None],
    *,
    overwrite: bool,
) -> None:
    """Refuse, before anything is computed, what cannot or must not be written.

    Args:
        calibrations: One a lens.
        report: The page, if any.
        plots: Figures, each named by the last part of its stem.
        inputs: Files that are read, besides those that the points came from.
        overwrite: Replace files that plumbline did not write.

    Raises:
        WriteError: a file exists and is not plumbline's, or its name says nothing.
        UnsettledError: a fit did not reach a minimum.
    """
    refuse_unsettled(calibrations)
    check_targets(report, plots)
    read = [o.path for calibration in calibrations for o in calibration.observations.origins]
    read += [name for name in inputs if name is not None]
    targets = [] if report is None else [Path(report)]
    targets += [each[0] for plot in plots for each in _targets(Path(plot), calibrations)]
    for target in targets:
        refuse_to_clobber(target, read, overwrite=overwrite)


def comparisons_of(
    calibrations: Sequence[Calibration], compare: Callable[[Observations], Comparison]
) -> tuple[list[Comparison | None], list[str]]:
    """The models of each lens side by side, as far as they can be compared.

    Args:
        calibrations: One a lens; a lens from a pair of pictures has no lines to compare by.
        compare: `plumbline.compare`, or one that shows its progress.

    Returns:
        One for each lens, None where there is none, and notes that say why.
    """
    found: list[Comparison | None] = []
    notes: list[str] = []
    for calibration in calibrations:
        comparison = None
        if not isinstance(calibration, PairCalibration):
            try:
                comparison = compare(calibration.kept_observations)
            except PlumblineError as error:
                notes.append(f"models are not compared in the report: {error.message}")
        found.append(comparison)
    return found, notes


def figure_bytes(subject: Subject, target: Path) -> bytes:
    """One figure as PNG or SVG, as the name of its file says.

    Raises:
        WriteError: the name says neither.
    """
    from plumbline.report.figures import FIGURES, encoding, style

    name = figure_name(target)
    with style.drawing():
        figure = FIGURES[name](subject)
        return (
            encoding.png_bytes(figure)
            if target.suffix.lower() == ".png"
            else encoding.svg_bytes(figure)
        )


def report_contents(
    calibrations: Sequence[Calibration],
    report: str | None,
    plots: Sequence[str],
    *,
    comparisons: Sequence[Comparison | None] = (),
    photo: str | None = None,
    source: str | None = None,
    case: str = "",
    examiner: str = "",
    overwrite: bool = False,
) -> tuple[dict[Path, bytes], list[str]]:
    """What goes into a report and into single figures; nothing is written yet.

    Args:
        calibrations: One a lens.
        report: The page to make, if any.
        plots: Figures to make, each named by the last part of its stem.
        comparisons: The comparison of models for each lens, for the page.
        photo: The photograph, where it is not found by name.
        source: The file of results, beside which photos are looked for too.
        case: Name or number of the case, for the page.
        examiner: Who calibrated, for the page.
        overwrite: Replace files that plumbline did not write.

    Returns:
        The bytes of each file, and notes on photos that are not shown.

    Raises:
        WriteError: a file exists and is not plumbline's, or its name says nothing.
        ReadError: the photograph cannot be read.
        UnsettledError: a fit did not reach a minimum.
    """
    from plumbline.report.figures import Subject

    found = find_photos(calibrations, photo, None if source is None else Path(source))
    shown = [str(p.path) for each in found for p in each.pictures if p is not None]
    refuse_targets(calibrations, report, plots, [*shown, source, photo], overwrite=overwrite)
    contents: dict[Path, bytes] = {}
    if report is not None:
        from plumbline.report.page.document import Assignment, Part, page_bytes

        compared = comparisons or [None] * len(calibrations)
        contents[Path(report)] = page_bytes(
            [Part(*each) for each in zip(calibrations, found, compared, strict=True)],
            Assignment(case, examiner),
        )
    for plot in plots:
        for target, lens, index in _targets(Path(plot), calibrations):
            subject = Subject(calibrations[lens], index, found[lens].pictures[index])
            contents[target] = figure_bytes(subject, target)
    return contents, list(dict.fromkeys(note for each in found for note in each.notes))


def write_report(
    result: Calibration | Sequence[Calibration],
    path: str | Path,
    *,
    comparisons: Sequence[Comparison | None] | None = None,
    photo: str | Path | None = None,
    case: str = "",
    examiner: str = "",
    overwrite: bool = False,
) -> Path:
    """Write the report of calibrations: one self-contained HTML page.

    Args:
        result: One calibration, or one for each lens.
        path: Where to, `.html`.
        comparisons: `plumbline.compare` of each lens, for the page; computed by default, and
            left out where this is empty.
        photo: The photograph, where it is not beside the points.
        case: Name or number of the case.
        examiner: Who calibrated.
        overwrite: Replace a file that plumbline did not write.

    Returns:
        The path written.

    Raises:
        WriteError: the file exists and is not plumbline's, or cannot be written.
        ReadError: the photograph cannot be read.
        UnsettledError: a fit did not reach a minimum.
    """
    from plumbline.fit.choice.compare import compare

    calibrations, target = as_calibrations(result), as_path(path)
    shown = None if photo is None else str(photo)
    refuse_targets(calibrations, str(target), (), [shown], overwrite=overwrite)
    if comparisons is None:
        comparisons, _ = comparisons_of(calibrations, compare)
    contents, _ = report_contents(
        calibrations,
        str(target),
        (),
        comparisons=comparisons,
        photo=shown,
        case=case,
        examiner=examiner,
        overwrite=overwrite,
    )
    write_atomically(contents)
    return target

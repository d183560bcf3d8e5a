"""What becomes of calibrations: files are written, a report drawn, a summary or JSON printed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from plumbline.cli.tools.report import draw
from plumbline.errors import printable
from plumbline.files import refuse_unknown_suffix
from plumbline.report.terminal.summary import WideConsole, print_summary
from plumbline.result.calibration import Calibration
from plumbline.result.given import refuse_unsettled
from plumbline.writing.beside import command_line, write_results
from plumbline.writing.results import RESULT_SUFFIXES

if TYPE_CHECKING:
    from rich.console import Console


def refuse_unclear(output: Sequence[str], report: str | None, plots: Sequence[str]) -> None:
    """Refuse names of which it is not clear what to write, before anything is computed.

    Raises:
        WriteError: a suffix stands for nothing, or a name for no figure.
    """
    for target in output:
        refuse_unknown_suffix(Path(target), RESULT_SUFFIXES, "results")
    if report is not None or plots:
        from plumbline.report.writing import check_targets

        check_targets(report, plots)


def deliver(
    fitted: Sequence[Calibration],
    source: str,
    narration: Console,
    *,
    output: Sequence[str],
    report: str | None,
    plots: Sequence[str],
    case: str | None,
    examiner: str | None,
    overwrite: bool,
    as_json: bool,
    verbose: bool,
    quiet: bool,
    photo: str | None = None,
    also: Mapping[Path, bytes] | None = None,
) -> None:
    """Write and print.

    Args:
        fitted: One a lens.
        source: The first input, beside which results go that are not named.
        narration: Where progress goes.
        output: Results that the user names.
        report: The page, if any.
        plots: Single figures.
        case: Name or number of the case, for the page.
        examiner: Who calibrated, for the page.
        overwrite: Replace files that plumbline did not write.
        as_json: Print JSON, and notes to the standard error.
        verbose: List every line.
        quiet: Print only the finding and the files.
        photo: The photograph, where it is not found by name.
        also: Further files, written with the others or not at all.

    Raises:
        UnsettledError: a fit did not reach a minimum.
        WriteError: a file cannot or must not be written.
    """
    calibrations = [replace(each, command=command_line()) for each in fitted]
    refuse_unsettled(calibrations)
    drawn: dict[Path, bytes] = dict(also or {})
    unseen: list[str] = []
    if report is not None or plots:
        figures, unseen = draw(
            calibrations,
            report,
            plots,
            narration,
            photo=photo,
            case=case or "",
            examiner=examiner or "",
            overwrite=overwrite,
        )
        drawn |= figures
    written, notes = write_results(calibrations, output, source, drawn, overwrite=overwrite)
    notes += unseen
    if as_json:
        _print_json(calibrations, written, notes)
    else:
        print_summary(WideConsole(), calibrations, written, notes, verbose=verbose, quiet=quiet)


def _print_json(
    calibrations: Sequence[Calibration], written: Sequence[Path], notes: Sequence[str]
) -> None:
    from plumbline.result.writing import to_json

    click.echo(to_json(calibrations), nl=False)
    for note in notes:
        click.echo(f"Note: {printable(note)}.", err=True)
    for path in written:
        click.echo(f"Wrote {printable(str(path))}", err=True)

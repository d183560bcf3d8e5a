"""The summary on the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from math import floor, isfinite, log10
from pathlib import Path

import numpy as np
from rich import box
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from plumbline.errors import printable
from plumbline.models import CENTRE
from plumbline.observations import Observations
from plumbline.report.terminal.checks import print_suspects
from plumbline.result.calibration import Calibration
from plumbline.result.pair import PairCalibration
from plumbline.result.sentence import finding_sentence
from plumbline.trust.straightness import edges_bend_px
from plumbline.wording import count, number, px

_MOST_LINES = 24
"""Rows; chosen, they fit a screen; `--verbose` shows all."""
_LEAST_WIDTH = 80
"""Characters; a table in less cannot be read."""
_TRUST = "correction", "line by line", "part by part", "model"


class WideConsole(Console):
    """A console at least 80 columns wide: a narrower terminal wraps lines and loses no digit."""

    def __init__(self, *, stderr: bool = False) -> None:
        super().__init__(stderr=stderr)
        self.width = max(self.width, _LEAST_WIDTH)


def print_summary(
    console: Console,
    calibrations: Sequence[Calibration],
    written: Sequence[Path],
    notes: Sequence[str] = (),
    *,
    verbose: bool = False,
    quiet: bool = False,
) -> None:
    """Print what was found, for every lens, and which files were written.

    Args:
        console: Where to.
        calibrations: One a lens.
        written: The files written.
        notes: What there is to say about the files.
        verbose: List every line, however many.
        quiet: Print only the finding, the error to quote, whether picks are wrong, and what there
            is to say about the files.
    """
    told: set[str] = set()
    for calibration in calibrations:
        if len(calibrations) > 1:
            print_title(console, calibration.observations)
        console.print(f"[bold]{finding_sentence(calibration)}[/]", highlight=False, soft_wrap=True)
        if quiet:
            if calibration.quoted is not None:
                console.print(_plain(calibration.quoted.sentence), highlight=False, soft_wrap=True)
            for check in calibration.checks:
                if check.name == "suspects" and not check.passed:
                    _print_note(console, check.sentence)
            continue
        console.print(coefficients_table(calibration))
        console.print(_fit_sentences(calibration), highlight=False, soft_wrap=True)
        console.print(lines_table(calibration, everything=verbose))
        for note in [note for note in calibration.notes if note not in told]:
            told.add(note)
            _print_note(console, note)
        print_suspects(console, calibration.suspects, everything=verbose or calibration.robust)
    for note in notes:
        _print_note(console, note)
    for path in written:
        console.print(f"Wrote {_plain(str(path))}", highlight=False, soft_wrap=True)


def _print_note(console: Console, note: str) -> None:
    console.print(f"• {_plain(note)}", style="yellow", highlight=False, soft_wrap=True)


def _plain(text: str) -> str:
    """Text from a file, without effect on the terminal."""
    return escape(printable(text))


def _paired(calibration: Calibration) -> bool:
    return isinstance(calibration, PairCalibration)


def coefficients_table(calibration: Calibration) -> Table:
    """Coefficients with their standard errors and start values."""
    table = Table(box=box.SIMPLE, pad_edge=False)
    table.add_column(f"{calibration.model}", style="bold")
    for title in ("value", "± std. error", "percent", "95 % interval", "start"):
        table.add_column(title, justify="right")
    errors = calibration.standard_errors
    for name, value in calibration.coefficients.items():
        least, unit = (3, " px") if name in CENTRE else (6, "")
        digits = decimals(errors.get(name, value), least)
        if name not in errors:
            table.add_row(name, number(value, f".{digits}f") + unit, "held", "", "", "")
            continue
        percent = f"{100 * errors[name] / abs(value):.1f} %" if value else ""
        table.add_row(
            name,
            number(value, f".{digits}f") + unit,
            f"± {errors[name]:.{digits}f}{unit}",
            percent,
            " to ".join(number(end, f".{digits}f") for end in calibration.intervals[name]),
            number(calibration.start[name], "g"),
        )
    return table


def decimals(size: float, least: int) -> int:
    """How many decimals show two significant digits of a number, and at least so many."""
    known = isfinite(size) and size != 0
    return max(least, 1 - floor(log10(abs(size)))) if known else least


def lines_table(calibration: Calibration, *, everything: bool = False) -> Table:
    """Straightness of the lines; only the worst of many, unless all are asked for."""
    lines = calibration.lines
    shown = list(lines)
    title = None
    if len(lines) > _MOST_LINES and not everything:
        shown = sorted(lines, key=lambda line: (line.left_out, -line.largest_after_px))
        shown = shown[:_MOST_LINES]
        title = f"the {_MOST_LINES} of {len(lines)} lines with the largest residuals (-v lists all)"
    table = Table(box=box.SIMPLE, pad_edge=False, title=title, title_justify="left")
    several = len(calibration.observations.photos) > 1
    table.add_column("part (row.column)" if _paired(calibration) else "line", style="bold")
    if several:
        table.add_column("photo")
    points = "matches" if _paired(calibration) else "points"
    bent = ["bend"] if calibration.bends is not None else []
    for heading in (points, "rms before", "rms after", "largest after", *bent):
        table.add_column(heading, justify="right")
    for line in shown:
        photo = calibration.observations.photos[line.photo]
        names = [_plain(line.label)]
        if several:
            names.append(_plain(photo.source or photo.name or str(photo.number)))
        if line.left_out:
            table.add_row(*names, str(line.n_points), "left out")
            continue
        numbers = [line.rms_before_px, line.rms_after_px, line.largest_after_px]
        numbers += [line.bend_px] if line.bend_px is not None else []
        table.add_row(*names, str(line.n_points), *(f"{number:.2f} px" for number in numbers))
    return table


def lens_title(observations: Observations) -> str:
    """The names of the photos of a lens, and its focal length where it is known."""
    photos = observations.photos
    names = ", ".join(photo.name or photo.source or f"photo {photo.number}" for photo in photos)
    focal_mm = observations.lenses[0].focal_length_mm(photos[0].frame)
    return names + (f" at {focal_mm:.4g} mm" if focal_mm else "")


def print_title(console: Console, observations: Observations) -> None:
    """Say which photos of a project follow."""
    title = _plain(lens_title(observations))
    console.print(f"[bold]{title}[/]", highlight=False, soft_wrap=True)


def _bootstrap_sentences(calibration: Calibration) -> list[str]:
    again, wide = calibration.bootstrap, calibration.bootstrap_displacement
    if again is None:
        return []
    errors = ", ".join(
        f"{name} ± {error:.6f}"
        for name, error in zip(calibration.free, np.sqrt(np.diag(again.covariance)), strict=True)
    )
    failed = f" ({again.failed:,} more found no minimum)" if again.failed else ""
    out = [f"bootstrap of {again.fits:,} fits: {errors}{failed}"]
    sure, quoted = calibration.displacement, calibration.quoted_displacement
    if wide is not None and sure is not None and quoted is not None:
        out.append(
            f"bootstrap: the correction is uncertain by {px(wide.worst_px)}; that checks the "
            f"{px(sure.worst_px)} of independent picking errors, and {px(quoted.worst_px)} stays "
            "the error to quote"
        )
    return out


def _fitted(calibration: Calibration) -> str:
    """What was fitted: "140 points on 14 lines", "98 of 126 points on 12 of 14 lines"."""
    paired = _paired(calibration)
    counts = [
        (
            sum(line.n_points for line in calibration.lines),
            calibration.observations.n_points,
            "matched point" if paired else "point",
        ),
        (
            sum(not line.left_out for line in calibration.lines),
            len(calibration.lines),
            "part" if paired else "line",
        ),
    ]
    points, lines = (
        ("" if used == every else f"{used:,} of ") + count(every, noun)
        for used, every, noun in counts
    )
    return f"{points} in {lines} of the photo" if paired else f"{points} on {lines}"


def _bend_clause(calibration: Calibration) -> str:
    """How straight the edges are, where that is told from noise."""
    straight_px = edges_bend_px(calibration.lines)
    return "" if straight_px is None else f"; the edges are straight to {px(straight_px)} (rms)"


def _fit_sentences(calibration: Calibration) -> str:
    out = [
        f"{_fitted(calibration)}; σ̂ {calibration.sigma_px:.3f} px with "
        f"{count(calibration.dof, 'degree')} of freedom{_bend_clause(calibration)}",
        f"rms {calibration.rms_before_px:.4f} px before, {calibration.rms_after_px:.4f} px after "
        f"({calibration.rms_corrected_px:.4f} px in the corrected photo)",
        f"largest residual {calibration.largest_before_px:.2f} px before, "
        f"{calibration.largest_after_px:.2f} px after",
    ]
    out += [check.finding for check in calibration.checks if check.name in _TRUST and check.passed]
    out += _bootstrap_sentences(calibration)
    return "\n".join(out)

"""The comparison of models on the terminal."""

from __future__ import annotations

from math import isfinite

from rich import box
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from plumbline.errors import printable
from plumbline.models import CENTRE
from plumbline.result.calibration import Calibration
from plumbline.result.comparison import Candidate, Comparison
from plumbline.wording import count, number


def print_comparison(console: Console, comparison: Comparison) -> None:
    """Print the table, the coefficients, what is recommended and why."""
    console.print(comparison_table(comparison))
    for candidate in comparison.candidates:
        calibration = candidate.calibration
        told = (
            candidate.failure if calibration is None else ", ".join(coefficient_texts(calibration))
        )
        names = " = ".join((candidate.name, *candidate.equals))
        _print(console, f"{names}: {escape(printable(told))}")
    chosen = comparison.candidates[comparison.recommended]
    _print(
        console, f"\n[bold]Recommended: {chosen.name}[/]; {escape(printable(comparison.reason))}"
    )
    for note in comparison.notes:
        _print(console, f"• {escape(printable(note))}")
    _print_suspects(console, comparison.calibration)
    fitted = f"--model {chosen.model} --free {','.join(chosen.free)}"
    same = "" if chosen.name.startswith(chosen.model) else f" (the same as {chosen.name})"
    robust = " --robust" if comparison.calibration.robust else ""
    _print(console, f"Fit it with {fitted}{robust}{same}, or with --model auto{robust}")


def _print_suspects(console: Console, calibration: Calibration) -> None:
    suspects = sum(len(suspect.picks) for suspect in calibration.suspects if suspect.left_out)
    if not suspects:
        return
    them = "it" if suspects == 1 else "them"
    told = f"took part: see plumbline check and correct {them} first, or leave {them} out with"
    if calibration.robust:
        told = f"{'was' if suspects == 1 else 'were'} left out: plumbline fit lists {them} with"
    _print(console, f"• {count(suspects, 'suspicious pick')} {told} --robust")


def comparison_table(comparison: Comparison) -> Table:
    """All models, simple ones first; the recommended one is marked."""
    table = Table(box=box.SIMPLE, pad_edge=False)
    table.add_column("model", no_wrap=True)
    for heading in ("rms\npx", "ΔAICc", "left\nout px", "off\nbest px", "error\npx", "folds"):
        table.add_column(heading, justify="right", no_wrap=True)
    for index, candidate in enumerate(comparison.candidates):
        style = "bold" if index == comparison.recommended else None
        table.add_row(candidate.name, *figures(candidate, comparison), style=style)
    return table


def figures(candidate: Candidate, comparison: Comparison) -> list[str]:
    """The numbers of a row: rms, AICc above the lowest, lines left out, off the best, fold."""
    calibration = candidate.calibration
    if calibration is None or candidate.aicc is None:
        return ["no fit", "", "", "", "", ""]
    return [
        f"{calibration.rms_after_px:.3f}",
        _shown(comparison.delta_aicc(candidate), "+.1f"),
        _shown(candidate.left_out_px, ".3f"),
        _shown(candidate.difference_px, ".2f"),
        _shown(candidate.overall_error_px, ".2f"),
        "no" if candidate.fold_px is None else f"at {candidate.fold_px:,.0f} px",
    ]


def _shown(value: float | None, form: str) -> str:
    return number(value, form) if value is not None and isfinite(value) else "–"


def coefficient_texts(calibration: Calibration) -> list[str]:
    """The free coefficients with their standard errors."""
    return [
        f"{name} {number(value, '+.1f')} ± {calibration.standard_errors[name]:.1f} px"
        if name in CENTRE
        else f"{name} {number(value, '+.4f')} ± {calibration.standard_errors[name]:.4f}"
        for name, value in calibration.coefficients.items()
        if name in calibration.free
    ]


def _print(console: Console, text: str) -> None:
    console.print(text, highlight=False, soft_wrap=True)

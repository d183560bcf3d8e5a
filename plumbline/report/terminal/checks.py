"""Checks and suspicious picks on the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite

from rich.console import Console
from rich.markup import escape

from plumbline.errors import printable
from plumbline.trust.check import Check
from plumbline.trust.suspect import Suspect

_MOST = 12
"""Rows; chosen, they fit a screen with the rest."""


def print_checks(console: Console, checks: Sequence[Check]) -> None:
    """Print what is good, what is doubtful, what is wrong, and what to do."""
    for check in checks:
        _print(console, f"{_mark(check)} {_plain(check.finding)}")
        if check.remedy:
            _print(console, f"  → {_plain(check.remedy)}")


def _mark(check: Check) -> str:
    if check.doubtful:
        return "[yellow]?[/]"
    return "[green]✓[/]" if check.passed else "[red]✗[/]"


def print_suspects(
    console: Console, suspects: Sequence[Suspect], *, everything: bool = False
) -> None:
    """Print the suspicious picks, worst first; of many only some, unless all are wanted."""
    ordered = sorted(suspects, key=lambda each: -each.residual_px)
    shown = ordered if everything else ordered[:_MOST]
    for suspect in shown:
        known = suspect.left_out and isfinite(suspect.studentised)
        size = f" ({suspect.studentised:,.1f} σ)" if known else ""
        _print(console, f"  {_plain(suspect.sentence)}{size}")
    if len(shown) < len(ordered):
        _print(console, f"  and {len(ordered) - len(shown)} more (-v lists all)")


def _print(console: Console, text: str) -> None:
    console.print(text, highlight=False, soft_wrap=True)


def _plain(text: str) -> str:
    return escape(printable(text))

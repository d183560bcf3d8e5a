"""Measurements on the terminal."""

from __future__ import annotations

from collections.abc import Sequence

from rich import box
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from plumbline.errors import printable
from plumbline.ground.measure import Measurement
from plumbline.wording import number

DIGITS = {"place": 3, "distance": 3, "angle": 2, "area": 2}
"""Decimal places of each kind; chosen: millimetres, hundredths of degrees and square metres."""


def print_measurements(console: Console, measurements: Sequence[Measurement]) -> None:
    """Print a table of values with their 95 % bars, and one of places with their ellipses."""
    places = [each for each in measurements if each.kind == "place"]
    others = [each for each in measurements if each.kind != "place"]
    if places:
        console.print(_places(places))
    if others:
        console.print(_values(others))


def _places(measurements: Sequence[Measurement]) -> Table:
    table = Table(box=box.SIMPLE, pad_edge=False)
    for heading in ("place", "X, m", "± 95 %", "Y, m", "± 95 %", "95 % ellipse, m", "long axis"):
        table.add_column(heading, justify="left" if heading == "place" else "right", no_wrap=True)
    for each in measurements:
        cells: list[str] = []
        for value, (low, high) in zip(each.values, each.intervals, strict=True):
            cells += [number(value, ".3f"), f"{(high - low) / 2:.3f}"]
        long, short, angle = each.ellipse or (0.0, 0.0, 0.0)
        table.add_row(_plain(each.names[0]), *cells, f"{long:.3f} x {short:.3f}", f"{angle:.0f}°")
    return table


def _values(measurements: Sequence[Measurement]) -> Table:
    table = Table(box=box.SIMPLE, pad_edge=False)
    for heading in ("quantity", "of", "value", "± 95 %", "unit"):
        right = heading in ("value", "± 95 %")
        table.add_column(heading, justify="right" if right else "left", no_wrap=heading != "of")
    for each in measurements:
        low, high = each.intervals[0]
        digits = DIGITS[each.kind]
        table.add_row(
            each.kind,
            _plain("-".join(each.names)),
            number(each.values[0], f".{digits}f"),
            f"{(high - low) / 2:.{digits}f}",
            each.unit,
        )
    return table


def _plain(text: str) -> str:
    return escape(printable(text))

"""Measurements on the page of a rectification: places with ellipses, values with bars."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from plumbline.ground.measure import Measurement
from plumbline.report.page.markup import Element, Node, table, tag
from plumbline.report.terminal.measurements import DIGITS
from plumbline.wording import number


def measured(measurements: Sequence[Measurement]) -> Iterator[Node]:
    """The section; nothing where nothing was measured."""
    if not measurements:
        return
    yield tag("h3", "Measurements")
    places = [each for each in measurements if each.kind == "place"]
    others = [each for each in measurements if each.kind != "place"]
    if places:
        yield _places(places)
    if others:
        yield _values(others)


def _places(places: Sequence[Measurement]) -> Element:
    heads = ("place", "X, m", "± 95 %", "Y, m", "± 95 %", "95 % ellipse, m", "long axis")
    rows: list[list[Node]] = []
    for each in places:
        long, short, angle = each.ellipse or (0.0, 0.0, 0.0)
        numbers: list[Node] = []
        for value, (low, high) in zip(each.values, each.intervals, strict=True):
            numbers += [number(value, ".3f"), f"{(high - low) / 2:.3f}"]
        rows.append([each.names[0], *numbers, f"{long:.3f} × {short:.3f}", f"{angle:.0f}°"])
    return table(heads, rows)


def _values(values: Sequence[Measurement]) -> Element:
    rows: list[list[Node]] = []
    for each in values:
        low, high = each.intervals[0]
        digits = DIGITS[each.kind]
        told = f"{each.values[0]:.{digits}f} {each.unit}"
        rows.append([f"{each.kind} {'-'.join(each.names)}", told, f"{(high - low) / 2:.{digits}f}"])
    return table(("quantity", "value", "± 95 %"), rows)

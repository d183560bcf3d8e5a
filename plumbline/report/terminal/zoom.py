"""A zoom lens on the terminal."""

from __future__ import annotations

from rich import box
from rich.console import Console
from rich.table import Table

from plumbline.frame import Frame
from plumbline.lenses.zoom.needs import needs
from plumbline.lenses.zoom.zoom_lens import ZoomLens
from plumbline.models import CENTRE
from plumbline.wording import count, number, power_of

_MOST_NEEDED = 2
"""Sentences; chosen, the next two steps are enough to do."""
_LABEL, _CELL, _WIDE = 24, 24, 200  # characters


def print_zoom(console: Console, lens: ZoomLens) -> None:
    """Print the coefficients over focal length, their scatter, and what is needed most."""
    low, high = lens.range_mm
    span = f"{low:g} mm" if low == high else f"{low:g} to {high:g} mm"
    n = sum(len(node.sources) for node in lens.nodes)
    console.print(
        f"[bold]{count(n, 'calibration')} at {count(len(lens.nodes), 'focal length')}, {span}[/]",
        highlight=False,
    )
    console.print(zoom_table(lens, console.width))
    for sentence in (*_scatter(lens), *_curves(lens), *_needed(lens)):
        console.print(f"• {sentence}", highlight=False, soft_wrap=True, markup=False)


def zoom_table(lens: ZoomLens, width: int = _WIDE) -> Table:
    """Coefficients with their standard errors at the calibrated focal lengths.

    Where the width in characters does not take them beside the values, they stand below.
    """
    radius_px = Frame(*lens.size, lens.pixel_aspect).radius_px
    shown = [name for name in lens.names if name in lens.free or name in lens.model.coefficients]
    beside = _LABEL + _CELL * len(shown) <= width
    between, heading = (" ", " ± std. error") if beside else ("\n", "\n± error")
    table = Table(box=box.SIMPLE, pad_edge=False, padding=(0, 1 if beside else 0))
    table.add_column("focal length" if beside else "focal\nlength", justify="right", style="bold")
    table.add_column("fits", justify="right")
    for name in shown:
        table.add_column(name + heading, justify="right", no_wrap=True)
    for node in lens.nodes:
        cells = [f"{node.focal_mm:g} mm", str(len(node.sources))]
        for name in shown:
            index = lens.names.index(name)
            scale, digits, unit = (radius_px, 2, " px") if name in CENTRE else (1.0, 6, "")
            value, error = node.values[index] * scale, node.errors[index] * scale
            held = "held" if name not in lens.free else f"± {error:.{digits}f}{unit}"
            cells.append(number(value, f".{digits}f") + f"{unit}{between}{held}")
        table.add_row(*cells)
    return table


def _scatter(lens: ZoomLens) -> list[str]:
    """How far calibrations at one focal length differ."""
    radius_px = Frame(*lens.size, lens.pixel_aspect).radius_px
    sentences: list[str] = []
    for node in lens.nodes:
        if len(node.sources) < 2:
            continue
        parts = [
            f"{name} {value:.6f}"
            for name, value in zip(lens.names, node.scatter, strict=True)
            if name in lens.free and name not in CENTRE
        ]
        centre = f"; centres up to {node.centre_spread * radius_px:.1f} px apart"
        told = f", {node.birge:.1f} times what their errors allow" if node.birge > 1 else ""
        sentences.append(
            f"{len(node.sources)} calibrations at {node.focal_mm:g} mm scatter (standard "
            f"deviation) by {', '.join(parts)}{told}{centre if any(node.values[-2:]) else ''}"
        )
    return sentences


def _curves(lens: ZoomLens) -> list[str]:
    if lens.method != "polynomial":
        return []
    radius_px = Frame(*lens.size, lens.pixel_aspect).radius_px
    sentences: list[str] = []
    for name, values in lens.polynomials().items():
        scale, unit = (radius_px, ", in pixels") if name in CENTRE else (1.0, "")
        terms = [
            number(value * scale, "+.7g") + ("" if power == 0 else f" {power_of('f', power)}")
            for value, power in zip(values, range(lens.degree, -1, -1), strict=True)
        ]
        sentences.append(f"{name}(f) = {' '.join(terms)}{unit}")
    return sentences


def _needed(lens: ZoomLens) -> list[str]:
    if len(lens.nodes) == 1:
        return ["one focal length makes no curve: calibrate at others, such as both ends"]
    sentences: list[str] = []
    for need in needs(lens)[:_MOST_NEEDED]:
        low, high = need.between
        where = "where there is one" if low == high else f"between {low:g} and {high:g} mm"
        sentences.append(
            f"another calibration is most needed at {need.focal_mm:.3g} mm, {where}: the "
            f"correction is uncertain there by {need.uncertainty_px:.2f} px"
        )
    return sentences

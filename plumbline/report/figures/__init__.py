"""The figures of a report, by name; each shows a `Subject`.

To add one: write a function from a `Subject` to a matplotlib `Figure` with units on its axes,
and its row in `FIGURES`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from plumbline.report.figures.corrected import corrected
from plumbline.report.figures.curve import curve
from plumbline.report.figures.maps import displacement, uncertainty
from plumbline.report.figures.photo import photo
from plumbline.report.figures.residuals import along, radius
from plumbline.report.figures.straight import lines
from plumbline.report.figures.subject import Subject

__all__ = ["FIGURES", "OF_EVERY_PHOTO", "Subject"]

FIGURES: dict[str, Callable[[Subject], Any]] = {
    "photo": photo,
    "lines": lines,
    "curve": curve,
    "displacement": displacement,
    "uncertainty": uncertainty,
    "corrected": corrected,
    "radius": radius,
    "along": along,
}
"""In the order of a report."""

OF_EVERY_PHOTO = ("photo", "corrected")
"""Drawn for every photo; the others once a lens."""

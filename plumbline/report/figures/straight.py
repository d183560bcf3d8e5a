"""How straight every line is, before and after."""

from __future__ import annotations

from typing import Any

import numpy as np

from plumbline.report.figures import style
from plumbline.report.figures.subject import Subject

_MOST = 48
"""Lines; chosen, more names cannot be read."""
_LEAST_PX = 1e-3
"""Chosen: nothing is straighter, and the axis is logarithmic."""
_LETTERS = 90
"""Letters that fit below the axis side by side."""
_LETTER = 0.075
"""Inches that a letter takes."""


def lines(subject: Subject) -> Any:
    """Root mean square residual of every line, or of the worst of many, on a logarithmic axis."""
    from matplotlib.ticker import LogLocator, NullLocator, StrMethodFormatter

    measured = [line for line in subject.calibration.lines if not line.left_out]
    label = "line"
    if len(measured) > _MOST:
        label = f"line (the {_MOST} of {len(measured):,} with the largest residuals)"
        measured = sorted(measured, key=lambda line: -line.largest_after_px)[:_MOST]
    names = [style.name(line.label) for line in measured]
    longest = max(map(len, names))
    upright = longest * len(names) > _LETTERS
    figure = style.sheet(style.FULL, 3.2 + (_LETTER * longest if upright else 0.0))
    axes = figure.subplots()
    places = np.arange(len(measured))
    before, after, largest = (
        np.array([getattr(line, name) for line in measured])
        for name in ("rms_before_px", "rms_after_px", "largest_after_px")
    )
    low, high = np.minimum(before, after), np.maximum(before, after)
    axes.vlines(places, np.maximum(low, _LEAST_PX), high, color=style.RULE, linewidth=3, zorder=1)
    axes.plot(
        places, before, "o", ms=5.5, mfc=style.PAPER, mec=style.ORANGE, mew=1.4, label="rms before"
    )
    axes.plot(places, after, "o", ms=5.5, color=style.BLUE, label="rms after")
    axes.plot(places, largest, "_", ms=8, mew=1.4, color=style.BLUE, label="largest after")
    axes.set_yscale("log")
    values = np.concatenate((before, after, largest))
    shown = values[np.isfinite(values) & (values > _LEAST_PX)]
    if len(shown):
        axes.set_ylim(shown.min() / 1.5, shown.max() * 1.5)
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.set_ylabel("distance from straight, px")
    axes.set_xticks(places, names, rotation=90 if upright else 0)
    axes.set_xlim(-0.7, len(measured) - 0.3)
    axes.set_xlabel(label)
    axes.grid(visible=False, axis="x")
    figure.legend(loc="outside upper left", ncols=3)
    return figure

"""Residuals against the distance from the centre, and along the lines."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil
from typing import Any

import numpy as np

from plumbline.frame import Array
from plumbline.report.figures import style
from plumbline.report.figures.subject import Drawn, Subject, drawn_lines, share_drawn
from plumbline.result.calibration import Calibration
from plumbline.result.pair import PairCalibration

_MOST = 24
"""Panels; chosen, they fill one page of A4."""
_COLUMNS = 4
"""Chosen: a panel is then 4 cm wide on A4."""


def radius(subject: Subject) -> Any:
    """Residuals over the distance from the distortion centre."""
    calibration = subject.calibration
    lines = drawn_lines(calibration)
    figure = style.sheet(style.FULL, 3.2)
    axes = figure.subplots()
    sigma = calibration.sigma_px
    for level, label in ((2 * sigma, "± 2 σ̂"), (-2 * sigma, None)):
        axes.axhline(level, color=style.SKY, linewidth=1.2, linestyle="--", label=label)
    axes.axhline(0.0, color=style.MUTED, linewidth=0.7)
    x, y, kept = (
        np.concatenate([getattr(line, name) for line in lines])
        for name in ("radius_px", "residual_px", "kept")
    )
    many = len(x) > style.MANY
    axes.plot(
        x[kept],
        y[kept],
        "o",
        ms=1.5 if many else 3.4,
        color=style.BLUE,
        label=("matches" if isinstance(calibration, PairCalibration) else "picks")
        + share_drawn(calibration, lines),
        rasterized=many,
    )
    limit = _limit(lines)
    _left_out(axes, x[~kept], y[~kept], limit)
    axes.set_ylim(-limit, limit)
    axes.set_xlim(0, calibration.lens.frame.corner_radius * calibration.lens.frame.radius_px)
    axes.set_xlabel("distance from the distortion centre, px (right end: corner)")
    axes.set_ylabel(f"residual outwards, {_pixels(calibration)}")
    figure.legend(loc="outside upper left", ncols=4)
    return figure


def along(subject: Subject) -> Any:
    """Residuals along every line, or the worst of many; a bow that they share is the model's."""
    from matplotlib.ticker import MaxNLocator

    calibration = subject.calibration
    lines = list(drawn_lines(calibration))
    what = ""
    if len(lines) > _MOST:
        n_lines = len(calibration.observations.lines)
        what = f" (the {_MOST} of {n_lines:,} lines with the largest residuals)"
        worst = [line.largest_after_px for line in calibration.lines]
        lines = sorted(lines, key=lambda line: -worst[line.index])[:_MOST]
        lines.sort(key=lambda line: line.index)
    columns = min(_COLUMNS, len(lines))
    rows = ceil(len(lines) / columns)
    figure = style.sheet(style.FULL, 0.9 + 1.05 * rows)
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
    limit = _limit(lines)
    for axes, line in zip(panels, lines, strict=False):
        axes.axhline(0.0, color=style.MUTED, linewidth=0.7)
        order = np.argsort(line.along_px)
        kept = order[line.kept[order]]
        axes.plot(
            line.along_px[kept],
            line.residual_px[kept],
            "o-",
            ms=3,
            linewidth=0.8,
            color=style.BLUE,
            rasterized=len(kept) > style.MANY // _MOST,
        )
        _left_out(axes, line.along_px[~line.kept], line.residual_px[~line.kept], limit)
        axes.set_title(style.name(line.label), loc="left", pad=2, fontsize=8)
    for axes in panels[len(lines) :]:
        axes.set_visible(False)
    panels[0].set_ylim(-limit, limit)
    panels[0].xaxis.set_major_locator(MaxNLocator(4))
    figure.supxlabel(f"position along the line, px of the corrected photo{what}", fontsize=9)
    figure.supylabel(f"residual outwards, {_pixels(calibration)}", fontsize=9)
    return figure


def _left_out(axes: Any, x: Array, y: Array, limit: float) -> None:
    """Mark picks left out, at the edge of the panel where they lie beyond it."""
    if len(x):
        axes.plot(
            x,
            np.clip(y, -limit, limit),
            "X",
            ms=5.5,
            color=style.PURPLE,
            clip_on=False,
            label="left out (at the edge: beyond it)",
        )


def _limit(lines: Sequence[Drawn]) -> float:
    """Half the range that shows the residuals of all fitted picks, above and below zero alike."""
    largest = max(float(np.max(np.abs(line.residual_px[line.kept]), initial=0.0)) for line in lines)
    return 1.1 * largest if largest > 0 else 1.0


def _pixels(calibration: Calibration) -> str:
    return "px" if calibration.residual == "image" else "px of the corrected photo"

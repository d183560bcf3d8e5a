"""Residuals against the distance from the centre, and along the lines."""

from __future__ import annotations

from math import ceil
from typing import Any

import numpy as np

from plumbline.calibration import Calibration
from plumbline.frame import Array
from plumbline.report.figures import style
from plumbline.report.figures.subject import Drawn, Subject, drawn_lines

_MOST = 24
_COLUMNS = 4


def radius(subject: Subject) -> Any:
    """Residuals over the distance from the distortion centre."""
    made = subject.made
    lines = drawn_lines(made)
    figure = style.sheet(style.FULL, 3.2)
    axes = figure.subplots()
    sigma = made.sigma_px
    for level, label in ((2 * sigma, "± 2 σ̂"), (-2 * sigma, None)):
        axes.axhline(level, color=style.SKY, linewidth=1.2, linestyle="--", label=label)
    axes.axhline(0.0, color=style.MUTED, linewidth=0.7)
    _dots(axes, lines, "radius_px", rasterized=made.observations.n_points > style.MANY)
    axes.set_xlim(0, made.lens.frame.corner_radius * made.lens.frame.radius_px)
    axes.set_xlabel("distance from the distortion centre, px (right end: corner)")
    axes.set_ylabel(f"residual outwards, {_pixels(made)}")
    figure.legend(loc="outside upper left", ncols=4)
    return figure


def along(subject: Subject) -> Any:
    """Residuals along every line, or the worst of many; a bow that they share is the model's."""
    made = subject.made
    lines = list(drawn_lines(made))
    what = ""
    if len(lines) > _MOST:
        what = f" (the {_MOST} of {len(lines):,} lines with the largest residuals)"
        worst = [line.largest_after_px for line in made.lines]
        lines = sorted(lines, key=lambda line: -worst[line.index])[:_MOST]
        lines.sort(key=lambda line: line.index)
    columns = min(_COLUMNS, len(lines))
    rows = ceil(len(lines) / columns)
    figure = style.sheet(style.FULL, 0.9 + 1.05 * rows)
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
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
        out = ~line.kept & np.isfinite(line.residual_px)
        axes.plot(line.along_px[out], line.residual_px[out], "X", ms=5, color=style.PURPLE)
        axes.set_title(style.name(line.label), loc="left", pad=2, fontsize=8)
    for axes in panels[len(lines) :]:
        axes.set_visible(False)
    limit = _limit([line.residual_px for line in lines])
    panels[0].set_ylim(-limit, limit)
    figure.supxlabel(f"position along the line, px of the corrected photo{what}", fontsize=9)
    figure.supylabel(f"residual outwards, {_pixels(made)}", fontsize=9)
    return figure


def _dots(axes: Any, lines: tuple[Drawn, ...], across: str, *, rasterized: bool) -> None:
    x = np.concatenate([getattr(line, across) for line in lines])
    y = np.concatenate([line.residual_px for line in lines])
    kept = np.concatenate([line.kept for line in lines])
    out = ~kept & np.isfinite(y)
    axes.plot(x[kept], y[kept], "o", ms=3.4, color=style.BLUE, label="picks", rasterized=rasterized)
    if out.any():
        axes.plot(x[out], y[out], "X", ms=5.5, color=style.PURPLE, label="left out")
    limit = _limit([y])
    axes.set_ylim(-limit, limit)


def _limit(values: list[Array]) -> float:
    """Half the range that shows all residuals, above and below zero alike."""
    every = np.abs(np.concatenate(values))
    every = every[np.isfinite(every)]
    return 1.08 * float(every.max()) if len(every) and every.max() > 0 else 1.0


def _pixels(made: Calibration) -> str:
    return "px" if made.residual == "image" else "px of the corrected photo"

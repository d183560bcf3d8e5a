"""The photo with its picks, the fitted lines as the lens shows them, and magnified residuals."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array, Frame
from plumbline.report.figures import style
from plumbline.report.figures.subject import Drawn, Subject, drawn_lines, round_factor, share_drawn

_TALLEST = 8.0
"""Inches; chosen, a portrait photo with its caption fits a page of A4."""
_MARGINS = 0.75, 1.0
"""Inches beside and below the photo, for the axes."""
_SHOWN = 0.04
"""A typical residual over the photo's longer side; chosen, to be seen without crossing."""
CASING = "#10131a"


def photo(subject: Subject) -> Any:
    """The photo, or an empty frame of its size, in its own pixels."""
    from matplotlib.collections import LineCollection

    calibration = subject.calibration
    frame = calibration.observations.photos[subject.photo].frame
    drawn = drawn_lines(calibration)
    lines = [line for line in drawn if line.photo == subject.photo]
    figure = style.sheet(*page_size(frame))
    axes = figure.subplots()
    blank(axes, frame, None if subject.picture is None else subject.picture.pixels)
    raster = sum(len(line.kept) for line in lines) > style.MANY
    thin = 0.4 if raster else 1.0
    lines_of_a_fit = [line.curve_px for line in lines if len(line.curve_px)]
    curves = LineCollection(
        lines_of_a_fit,
        colors=style.SKY,
        linewidths=1.1 * thin,
        path_effects=cased(2.2 * thin, CASING),
        rasterized=raster,
        label="fitted lines, as the lens shows them",
    )
    if lines_of_a_fit:
        axes.add_collection(curves, autolim=False)
    factor = magnification(lines, min(frame.square_size))
    axes.add_collection(
        LineCollection(
            list(_whiskers(lines, factor)),
            colors=style.ORANGE,
            linewidths=1.7 * thin,
            path_effects=cased(3.0 * thin, "white"),
            rasterized=raster,
            label=f"residuals, magnified {factor:g} times",
        ),
        autolim=False,
    )
    kept, out = (_points(lines, kept=which) for which in (True, False))
    dots: dict[str, Any] = {"linestyle": "none", "rasterized": raster, "zorder": 4}
    look: dict[str, Any] = {"mfc": CASING, "mec": "white", "mew": 0.8 * thin}
    axes.plot(
        *kept.T,
        "o",
        ms=3.2 * thin,
        label=("picks" if lines_of_a_fit else "matches") + share_drawn(calibration, drawn),
        **look,
        **dots,
    )
    if len(out):
        axes.plot(
            *out.T, "X", ms=6, mfc=style.PURPLE, mec="white", mew=0.8, label="left out", **dots
        )
    _suspects(axes, subject, lines, raster=raster)
    figure.legend(loc="outside upper left", ncols=5, handlelength=1.6, columnspacing=1.6)
    return figure


def page_size(frame: Frame) -> tuple[float, float]:
    """Width and height of the sheet around a photo."""
    ratio = frame.height / frame.width / frame.pixel_aspect
    across, down = _MARGINS
    height = min((style.FULL - across) * ratio, _TALLEST)
    return style.FULL, height + down


def blank(axes: Any, frame: Frame, pixels: NDArray[np.uint8] | None) -> None:
    """A frame in a photo's own pixels, with its picture where there is one."""
    right, bottom = frame.width - 0.5, frame.height - 0.5
    if pixels is not None:
        extent = (-0.5, right, bottom, -0.5)
        axes.imshow(pixels, extent=extent, interpolation="none", aspect="auto")
        axes.grid(visible=False)
    axes.set_xlim(-0.5, right)
    axes.set_ylim(bottom, -0.5)
    axes.set_aspect(1 / frame.pixel_aspect)
    axes.spines[["top", "right"]].set_visible(True)
    axes.set_xlabel("x, px")
    axes.set_ylabel("y, px")


def magnification(lines: list[Drawn], side_px: float) -> float:
    """A round factor that makes large residuals of fitted picks visible."""
    sizes = [np.abs(line.residual_px[line.kept]) for line in lines]
    every = np.concatenate([*sizes, np.zeros(1)])
    typical = float(np.quantile(every, 0.95)) or float(np.max(every))
    return round_factor(_SHOWN * side_px, typical)


def _whiskers(lines: list[Drawn], factor: float) -> Any:
    """From where each pick should lie towards where it lies; not of picks left out."""
    for line in lines:
        for foot, pick in zip(line.foot_px[line.kept], line.observed_px[line.kept], strict=True):
            yield np.stack((foot, foot + factor * (pick - foot)))


def _points(lines: list[Drawn], *, kept: bool) -> Array:
    chosen = [line.observed_px[line.kept == kept] for line in lines]
    return np.concatenate([*chosen, np.zeros((0, 2))])


def _suspects(axes: Any, subject: Subject, lines: list[Drawn], *, raster: bool) -> None:
    drawn = {line.index for line in lines}
    named = [each for each in subject.calibration.suspects if each.line in drawn]
    if not named:
        return
    every = subject.calibration.observations.lines
    rings = np.concatenate([every[each.line].points_px[list(each.picks)] for each in named])
    for width, colour, label in ((3.0, CASING, None), (1.5, style.YELLOW, "suspicious")):
        look = {
            "mfc": "none",
            "mec": colour,
            "mew": width,
            "ms": 10,
            "zorder": 5,
            "rasterized": raster,
        }
        axes.plot(*rings.T, "o", label=label, **look)


def cased(width: float, colour: str) -> list[Any]:
    """A line with a casing, which shows on every ground."""
    from matplotlib.patheffects import Normal, Stroke

    return [Stroke(linewidth=width, foreground=colour, alpha=0.75), Normal()]

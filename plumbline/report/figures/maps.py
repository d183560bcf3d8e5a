"""Displacement and its uncertainty, over the whole photo."""

from __future__ import annotations

from typing import Any

import numpy as np

from plumbline.frame import Array
from plumbline.geometry.lens import Lens
from plumbline.report.figures import style
from plumbline.report.figures.subject import (
    Subject,
    drawn_lines,
    round_factor,
)
from plumbline.result.calibration import Calibration
from plumbline.trust.displacement import grid_px

_FINE = 49
"""Nodes a side of the contours; chosen, finer ones look the same."""
_ARROWS = 11, 9
"""Across and down; chosen, more would touch each other."""
_LEVELS = 8
"""Contours at most; chosen, more cannot be told apart."""


def displacement(subject: Subject) -> Any:
    """How far the lens displaces every point, and which way."""
    lens = subject.calibration.lens
    points = grid_px(lens, _FINE)
    shift = displacement_px(lens, points)
    figure, axes = _map(lens)
    width, height = lens.frame.size
    x, y = np.meshgrid(
        *(
            np.linspace(side / (2 * n), side - side / (2 * n), n)
            for side, n in zip((width, height), _ARROWS, strict=True)
        )
    )
    at = np.stack((x.ravel(), y.ravel()), axis=-1)
    arrows = displacement_px(lens, at) / np.array([lens.frame.pixel_aspect, 1.0])
    seen = np.isfinite(arrows).all(axis=1)
    factor = round_factor(
        1.3 * width / _ARROWS[0], float(np.max(np.abs(arrows[seen]), initial=0.0))
    )
    _filled(figure, axes, points, np.hypot(*shift.T), "displacement, px", style.SIZES)
    axes.set_title(f"arrows magnified {factor:g} times", loc="left")
    axes.quiver(
        *at[seen].T,
        *factor * arrows[seen].T,
        angles="xy",
        scale_units="xy",
        scale=1,
        color="#10131a",
        width=0.005,
    )
    return figure


def uncertainty(subject: Subject) -> Any:
    """The standard error of the correction to quote, and where the picks lie."""
    calibration = subject.calibration
    points = grid_px(calibration.lens, _FINE)
    errors = calibration.trust.quoted_errors_px(points)
    figure, axes = _map(calibration.lens)
    if errors is None:
        axes.text(
            0.5,
            0.5,
            "not known: the model folds inside the photo",
            ha="center",
            va="center",
            transform=axes.transAxes,
        )
        return figure
    _filled(figure, axes, points, errors, "one standard error, px", style.ERRORS)
    picks = _picks(calibration)
    axes.set_title("dots: picks", loc="left")
    axes.plot(
        *picks.T,
        "o",
        ms=2.2,
        mfc="#10131a",
        mec="white",
        mew=0.4,
        rasterized=len(picks) > style.MANY,
    )
    return figure


def displacement_px(lens: Lens, points_px: Array) -> Array:
    """Observed less ideal point at the scale of the photo's centre, in square pixels.

    Args:
        lens: The lens.
        points_px: Observed points, shape (n, 2).

    Returns:
        Same shape; NaN beyond the fold of the model.
    """
    centre = lens.frame.normalise(lens.centre_px, 1.0)
    scale = lens.model.central_scale(lens.vector)
    ideal = lens.frame.normalise(lens.undistort_or_nan(points_px), 1.0)
    return lens.frame.normalise(points_px, 1.0) - centre - scale * ideal


def _map(lens: Lens) -> tuple[Any, Any]:
    frame = lens.frame
    ratio = frame.height / frame.width / frame.pixel_aspect
    figure = style.sheet(style.HALF, float(np.clip(3.3 * ratio + 0.6, 2.2, 5.5)))
    axes = figure.subplots()
    axes.set_xlim(-0.5, frame.width - 0.5)
    axes.set_ylim(frame.height - 0.5, -0.5)
    axes.set_aspect(1 / frame.pixel_aspect)
    axes.grid(visible=False)
    axes.set_xlabel("x, px")
    axes.set_ylabel("y, px")
    return figure, axes


def _filled(figure: Any, axes: Any, points: Array, values: Array, label: str, colours: str) -> None:
    """Filled contours of values on the fine grid, and their scale."""
    from matplotlib.ticker import MaxNLocator

    shape = (_FINE, _FINE)
    top = float(np.nanmax(values, initial=0.0))
    levels = MaxNLocator(_LEVELS).tick_values(0.0, top if top > 0 else 1.0)
    x, y = (points[:, axis].reshape(shape) for axis in (0, 1))
    shown = np.ma.masked_invalid(values.reshape(shape))
    filled = axes.contourf(x, y, shown, levels=levels, cmap=colours)
    filled.set(edgecolor="face", linewidth=0.4)  # no seams between the levels
    bar = figure.colorbar(filled, ax=axes, shrink=0.9, aspect=24)
    bar.set_label(label)
    bar.outline.set_visible(False)


def _picks(calibration: Calibration) -> Array:
    """All picks that were fitted, in the pixels of the lens's frame."""
    frame = calibration.lens.frame
    photos = calibration.observations.photos
    return np.concatenate(
        [
            frame.to_pixels(
                photos[line.photo].frame.normalise(line.observed_px[line.kept], 1.0), 1.0
            )
            for line in drawn_lines(calibration)
        ]
    )

"""Displacement over the distance from the centre, with the band of its error."""

from __future__ import annotations

from typing import Any

import numpy as np

from plumbline.frame import Array
from plumbline.geometry.finding import radial_curve
from plumbline.report.figures import style
from plumbline.report.figures.subject import Subject, drawn_lines
from plumbline.result.calibration import Calibration

_DIRECTIONS = 16
"""Chosen: decentring turns the error once or twice around the centre."""


def curve(subject: Subject) -> Any:
    """The radial curve with its 95 % band, and the band alone on a scale of its own.

    The band holds whatever scale and place the corrected photo has: lines see neither.
    """
    calibration = subject.calibration
    figure = style.sheet(style.FULL, 4.6)
    axes, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    observed, ideal = radial_curve(calibration.lens)
    observed, shift = np.append(0.0, observed), np.append(0.0, observed - ideal)
    band = band_px(calibration, observed)
    if band is not None:
        filled: dict[str, Any] = {"color": style.SKY, "alpha": 0.4, "linewidth": 0}
        label = "95 % band of the error to quote"
        axes.fill_between(observed, shift - band, shift + band, label=label, **filled)
        below.fill_between(observed, -band, band, **filled)
    axes.plot(observed, shift, color=style.BLUE, linewidth=1.6, label="displacement")
    picks = np.concatenate([line.radius_px[line.kept] for line in drawn_lines(calibration)])
    axes.plot(
        picks,
        np.full_like(picks, 0.03),
        "|",
        ms=9,
        color=style.ORANGE,
        alpha=0.7,
        transform=axes.get_xaxis_transform(),
        rasterized=len(picks) > style.MANY,
        label="picks",
    )
    corner = calibration.lens.frame.corner_radius * calibration.lens.frame.radius_px
    for panel in (axes, below):
        panel.axhline(0.0, color=style.MUTED, linewidth=0.7)
        _shade_beyond(panel, float(picks.max()), corner)
    axes.set_xlim(0, corner)
    axes.set_ylabel("displacement outwards, px")
    below.set_ylabel("95 % band, px")
    below.set_xlabel("distance from the distortion centre in the photo, px (right end: corner)")
    figure.align_ylabels()
    figure.legend(*axes.get_legend_handles_labels(), loc="outside upper left", ncols=4)
    return figure


def _shade_beyond(axes: Any, farthest: float, corner: float) -> None:
    if farthest < 0.995 * corner:
        axes.axvspan(
            farthest,
            corner,
            facecolor="none",
            edgecolor=style.MUTED,
            alpha=0.35,
            hatch="////",
            linewidth=0,
            zorder=0,
            label="beyond all picks: extrapolated",
        )


def band_px(calibration: Calibration, radius_px: Array) -> Array | None:
    """Half the width of the 95 % band at each radius, the widest of all directions.

    Args:
        calibration: The calibration.
        radius_px: Distances from the distortion centre in square pixels, shape (n,).

    Returns:
        Shape (n,), NaN where no direction leads to a point of the photo; None where the model
        folds inside the photo.
    """
    frame = calibration.lens.frame
    centre = frame.normalise(calibration.lens.centre_px, 1.0)
    half = np.array(frame.square_size) / 2
    first = float(np.arctan2(half[1], half[0]))  # a diagonal is the longest way in the photo
    turns = 2 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
    angles = np.concatenate((turns, [first, np.pi - first, np.pi + first, -first]))
    away = np.stack((np.cos(angles), np.sin(angles)), axis=-1)
    points = frame.to_pixels(centre + radius_px[:, None, None] * away, 1.0)
    inside = frame.contains(points)
    errors = np.full(inside.shape, -np.inf)
    found = calibration.trust.quoted_errors_px(points[inside])
    if found is None:
        return None
    errors[inside] = found
    widest = errors.max(axis=1)
    return calibration.trust.interval_factor * np.where(np.isfinite(widest), widest, np.nan)

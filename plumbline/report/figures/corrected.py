"""The corrected photo, with the picks and the straight lines that they are to lie on."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from plumbline.errors import FoldedError
from plumbline.frame import Array, Frame
from plumbline.geometry.lens import Lens
from plumbline.report.figures import style
from plumbline.report.figures.photo import CASING, blank, cased, page_size
from plumbline.report.figures.subject import Subject, drawn_lines, seen, share_drawn
from plumbline.report.photos import ShownPhoto


def corrected(subject: Subject) -> Any:
    """The photo without its distortion, or an empty frame of its size."""
    from matplotlib.collections import LineCollection

    calibration, index = subject.calibration, subject.photo
    frame = calibration.observations.photos[index].frame
    drawn = drawn_lines(calibration)
    lines = [line for line in drawn if line.photo == index]
    figure = style.sheet(*page_size(frame))
    axes = figure.subplots()
    blank(axes, frame, _pixels(calibration.lens, frame, subject.picture))
    raster = sum(len(line.kept) for line in lines) > style.MANY
    straight = [_ideal_px(calibration.lens, frame, line.curve_px) for line in lines]
    axes.add_collection(
        LineCollection(
            straight,
            colors=style.SKY,
            linewidths=1.1,
            path_effects=cased(2.2, CASING),
            rasterized=raster,
            label="straight lines",
        ),
        autolim=False,
    )
    picks = [_ideal_px(calibration.lens, frame, line.observed_px[line.kept]) for line in lines]
    every = np.concatenate([*picks, np.zeros((0, 2))])
    axes.plot(
        *every.T,
        "o",
        ms=3.2,
        mfc=CASING,
        mec="white",
        mew=0.8,
        linestyle="none",
        rasterized=raster,
        zorder=4,
        label=f"picks, corrected{share_drawn(calibration, drawn)}",
    )
    figure.legend(loc="outside upper left", ncols=2, handlelength=1.6, columnspacing=1.6)
    return figure


def _ideal_px(lens: Lens, frame: Frame, observed_px: Array) -> Array:
    """Observed points of a photo corrected, in its own pixels; nowhere beyond the fold."""
    placed = lens.frame.to_pixels(frame.normalise(observed_px, 1.0), 1.0)
    try:
        ideal = lens.undistort(placed)
    except FoldedError:
        return np.full_like(observed_px, np.nan)
    return frame.to_pixels(lens.frame.normalise(ideal, 1.0), 1.0)


def _pixels(lens: Lens, frame: Frame, picture: ShownPhoto | None) -> NDArray[np.uint8] | None:
    """The picture corrected, as large as it is shown; None where there is none or it folds."""
    from plumbline.imaging.resample import one_tile

    if picture is None:
        return None
    rows, columns = picture.pixels.shape[:2]
    shrink = np.array([columns / frame.width, rows / frame.height])
    grid = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1)
    ideal_px = (grid.reshape(-1, 2) + 0.5) / shrink - 0.5
    observed_px = seen(lens, frame, frame.normalise(ideal_px, 1.0))
    if np.isnan(observed_px).any():
        return None
    x, y = ((observed_px + 0.5) * shrink - 0.5).T.reshape(2, rows, columns).astype(np.float32)
    return one_tile(picture.pixels, x, y, "linear", (255.0, 255.0, 255.0), alpha=False)

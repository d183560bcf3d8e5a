"""What a figure shows, and what its parts have in common: picks beside their fitted lines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import floor, log10

import numpy as np
from numpy.typing import NDArray

from plumbline.errors import FoldedError
from plumbline.frame import Array, Frame
from plumbline.geometry.derivatives import undistorted
from plumbline.geometry.lens import Lens
from plumbline.geometry.lines import fit_lines
from plumbline.report.figures.thinning import drawn_picks
from plumbline.report.photos import ShownPhoto
from plumbline.result.calibration import Calibration
from plumbline.result.pair import PairCalibration
from plumbline.trust.linearised import in_frame

_CURVE = 48
"""Points along a line's curve; chosen, it looks smooth."""


@dataclass(frozen=True)
class Subject:
    """A calibration, and one of its photos.

    Attributes:
        calibration: The calibration.
        photo: Index of the photo.
        picture: That photo's pixels; None where there are none.
    """

    calibration: Calibration
    photo: int = 0
    picture: ShownPhoto | None = None


@dataclass(frozen=True, eq=False)
class Drawn:
    """The picks of one line beside the line that was fitted to them.

    Attributes:
        index: The line's place among the lines.
        label: Its name.
        photo: Index of its photo.
        kept: Which picks were fitted, shape (n,).
        observed_px: The picks, shape (n, 2), in their photo's own pixels.
        foot_px: Where they would lie without an error, shape (n, 2).
        curve_px: The straight line as the lens shows it, shape (m, 2).
        radius_px: Distance of the picks from the distortion centre, square pixels, shape (n,).
        along_px: Position along the line in the corrected photo, shape (n,).
        residual_px: Signed residuals, positive away from the distortion centre, shape (n,); NaN
            on a line that was left out as a whole.
    """

    index: int
    label: str
    photo: int
    kept: NDArray[np.bool_]
    observed_px: Array
    foot_px: Array
    curve_px: Array
    radius_px: Array
    along_px: Array
    residual_px: Array


def drawn_lines(calibration: Calibration) -> tuple[Drawn, ...]:
    """The lines of a calibration, some of very many, or every part of a pair's matches."""
    if isinstance(calibration, PairCalibration):
        return _drawn_parts(calibration)
    lens, linear = calibration.lens, calibration.linearised
    frames = [photo.frame for photo in calibration.observations.photos]
    observed = np.concatenate(in_frame(calibration.observations, lens.frame))
    # Ideal points are measured from the distortion centre, observed ones from the photo's.
    ideal = undistorted(lens, observed).uv
    line, kept = linear.line, linear.kept
    lines = fit_lines(ideal, np.bincount(line), kept.astype(np.float64))
    centre = lens.frame.normalise(lens.centre_px, 1.0)
    outwards = np.where(np.sum(lines.centre * lines.across, axis=1) < 0, -1.0, 1.0)
    away = np.where(lines.count[line] > 0, linear.residual_px * outwards[line], np.nan)
    foot = lines.centre[line] + linear.along_px[:, None] * lines.along[line]
    radius_px = np.hypot(*(lens.frame.normalise(observed, 1.0) - centre).T)
    shown = drawn_picks(np.bincount(line), np.abs(linear.residual_px), radius_px)
    starts = np.searchsorted(line, np.arange(linear.n_lines + 1))
    found: list[Drawn] = []
    for index in np.unique(line[shown]).tolist():
        first = int(starts[index])
        places = np.flatnonzero(shown[first : starts[index + 1]])
        which = first + places
        source = calibration.observations.lines[index]
        frame = frames[source.photo]
        span = linear.along_px[which][kept[which]]
        reach = np.linspace(span.min(), span.max(), _CURVE) if len(span) else np.zeros(0)
        found.append(
            Drawn(
                index=index,
                label=source.label,
                photo=source.photo,
                kept=kept[which],
                observed_px=source.points_px[places],
                foot_px=seen(lens, frame, foot[which]),
                curve_px=seen(
                    lens, frame, lines.centre[index] + reach[:, None] * lines.along[index]
                ),
                radius_px=radius_px[which],
                along_px=linear.along_px[which],
                residual_px=away[which],
            )
        )
    return tuple(found)


def share_drawn(calibration: Calibration, drawn: Sequence[Drawn]) -> str:
    """What a legend says beside picks of which some are not drawn."""
    shown, n_points = sum(len(line.kept) for line in drawn), calibration.observations.n_points
    return f" ({shown:,} of {n_points:,} drawn)" if shown < n_points else ""


def _drawn_parts(calibration: PairCalibration) -> tuple[Drawn, ...]:
    """Matches in the original beside where the lens puts them; there are no lines."""
    centre = np.array(calibration.lens.centre_px)
    found: list[Drawn] = []
    first = 0
    for index, (source, kept) in enumerate(
        zip(calibration.observations.lines, calibration.kept, strict=True)
    ):
        vectors = calibration.vectors_px[first : first + len(kept)]
        first += len(kept)
        outwards = source.points_px - centre
        radius_px = np.hypot(outwards[:, 0], outwards[:, 1])
        away = np.sum(outwards * vectors, axis=1) / np.maximum(radius_px, 1e-9)
        found.append(
            Drawn(
                index=index,
                label=source.label,
                photo=source.photo,
                kept=kept,
                observed_px=source.points_px,
                foot_px=source.points_px - vectors,
                curve_px=np.zeros((0, 2)),
                radius_px=radius_px,
                along_px=np.zeros(len(kept)),
                residual_px=np.where(np.isfinite(away), away, np.nan),
            )
        )
    return tuple(found)


def seen(lens: Lens, frame: Frame, ideal: Array) -> Array:
    """Where a photo shows ideal points; nowhere if the lens folds before it reaches one."""
    try:
        observed = lens.distort(lens.frame.to_pixels(ideal, 1.0))
    except FoldedError:
        return np.full_like(ideal, np.nan)
    return frame.to_pixels(lens.frame.normalise(observed, 1.0), 1.0)


def round_factor(wanted_px: float, size_px: float) -> float:
    """The largest of 1, 2, 5, 10, … that makes a size no larger than wanted; 1 if none does."""
    if size_px <= 0 or wanted_px <= size_px:
        return 1.0
    unit = 10.0 ** floor(log10(wanted_px / size_px))
    return unit * max(step for step in (1.0, 2.0, 5.0) if step * unit * size_px <= wanted_px)

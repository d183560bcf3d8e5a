"""Calibrations as JSON, with the observations they came from.

The names are those of `Calibration`. One lens is one object; several are listed under
`calibrations`. Floats are written so that they read back exactly.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from plumbline._version import __version__
from plumbline.files import RESULT
from plumbline.frame import Array
from plumbline.result.calibration import Calibration
from plumbline.result.pair import PairCalibration
from plumbline.result.records import record_text
from plumbline.result.schema import (
    FORMAT_VERSION,
    BendsRecord,
    BootstrapRecord,
    DisplacementRecord,
    JackknifeRecord,
    LineRecord,
    Matrix,
    ObservationsRecord,
    OriginRecord,
    Pair,
    PairRecord,
    PhotoRecord,
    QuotedRecord,
    ResultRecord,
    ResultsRecord,
    StraightnessRecord,
    SuspectRecord,
)
from plumbline.trust.straightness import LineStraightness, edges_bend_px
from plumbline.trust.suspect import Suspect


def to_json(calibrations: Sequence[Calibration]) -> str:
    """JSON text of one or several calibrations."""
    records = tuple(record_of(calibration) for calibration in calibrations)
    if len(records) == 1:
        return record_text(records[0])
    return record_text(ResultsRecord(**_head(), calibrations=records), depth=5)


def _head() -> dict[str, Any]:
    return {"format": RESULT, "format_version": FORMAT_VERSION, "plumbline": __version__}


def record_of(calibration: Calibration) -> ResultRecord:
    """One calibration as it is written."""
    return ResultRecord(
        **_head(),
        model=calibration.model,
        free=calibration.free,
        residual=calibration.residual,
        coefficients=calibration.coefficients,
        standard_errors=calibration.standard_errors,
        start=dict(calibration.start),
        covariance=_matrix(calibration.covariance),
        sigma_px=calibration.sigma_px,
        dof=calibration.dof,
        rms_before_px=calibration.rms_before_px,
        rms_after_px=calibration.rms_after_px,
        rms_corrected_px=calibration.rms_corrected_px,
        largest_before_px=calibration.largest_before_px,
        largest_after_px=calibration.largest_after_px,
        intervals=calibration.intervals,
        displacement=_displacement(calibration),
        quoted=_quoted(calibration),
        jackknife=_jackknife(calibration),
        bootstrap=_bootstrap(calibration),
        bends=_bends(calibration),
        model_error=calibration.model_error,
        robust=calibration.robust,
        checks=calibration.checks,
        suspects=tuple(_suspect(calibration, each) for each in calibration.suspects),
        rival_px=calibration.rival_px,
        converged=calibration.converged,
        reason=calibration.reason,
        finding=calibration.finding,
        focal_px=calibration.lens.focal_px,
        notes=calibration.notes,
        remarks=calibration.remarks,
        command=calibration.command,
        lines=tuple(_line(line) for line in calibration.lines),
        pair=PairRecord(scale=calibration.scale, place_px=calibration.place_px)
        if isinstance(calibration, PairCalibration)
        else None,
        observations=_observations(calibration),
    )


def _displacement(calibration: Calibration) -> DisplacementRecord | None:
    sure, quoted = calibration.displacement, calibration.quoted_displacement
    if sure is None or quoted is None:
        return None
    wide = calibration.jackknife_displacement
    return DisplacementRecord(
        quote_px=quoted.worst_px,
        quote_at_px=_pairs(quoted.worst_at_px),
        largest_px=sure.worst_px,
        at_px=_pairs(sure.worst_at_px),
        jackknife_largest_px=None if wide is None else wide.worst_px,
        quoted=_kind(calibration),
        points_px=_pairs(sure.points_px),
        errors_px=tuple(sure.errors_px.tolist()),
    )


def _kind(calibration: Calibration) -> str:
    """What the error to quote is made of, in a word or two."""
    if calibration.quoted is not None:
        return "picks and lens"
    return "jackknife" if calibration.quotes_jackknife else "independent"


def _quoted(calibration: Calibration) -> QuotedRecord | None:
    sure = calibration.quoted
    if sure is None:
        return None
    return QuotedRecord(
        worst_px=sure.worst_px,
        picks_px=sure.picks_px,
        missed_px=sure.missed_px,
        centre_px=sure.centre_px,
        curve_px=sure.curve_px,
        rectified_px=sure.rectified_px,
        reached=sure.reached,
    )


def _line(line: LineStraightness) -> StraightnessRecord:
    known = not line.left_out
    return StraightnessRecord(
        label=line.label,
        photo=line.photo,
        n_points=line.n_points,
        rms_before_px=line.rms_before_px if known else None,
        rms_after_px=line.rms_after_px if known else None,
        largest_after_px=line.largest_after_px if known else None,
        bend_px=line.bend_px if known else None,
    )


def _jackknife(calibration: Calibration) -> JackknifeRecord | None:
    left = calibration.jackknife
    return (
        None if left is None else JackknifeRecord(dof=left.dof, covariance=_matrix(left.covariance))
    )


def _bootstrap(calibration: Calibration) -> BootstrapRecord | None:
    again, wide = calibration.bootstrap, calibration.bootstrap_displacement
    if again is None:
        return None
    return BootstrapRecord(
        fits=again.fits,
        failed=again.failed,
        covariance=_matrix(again.covariance),
        intervals=dict(zip(calibration.free, _pairs(again.intervals), strict=True)),
        largest_px=None if wide is None else wide.worst_px,
    )


def _bends(calibration: Calibration) -> BendsRecord | None:
    found = calibration.bends
    if found is None:
        return None
    return BendsRecord(
        length=found.length,
        order=found.order,
        tau_px=tuple(found.tau_px.tolist()),
        bend_px=edges_bend_px(calibration.lines),
    )


def _suspect(calibration: Calibration, suspect: Suspect) -> SuspectRecord:
    return SuspectRecord(
        line=suspect.line,
        picks=suspect.picks,
        kind=suspect.kind,
        residual_px=_finite(suspect.residual_px),
        studentised=_finite(suspect.studentised),
        left_out=suspect.left_out,
        sentence=suspect.sentence,
        label=calibration.observations.lines[suspect.line].label,
    )


def _observations(calibration: Calibration) -> ObservationsRecord:
    observations = calibration.observations
    return ObservationsRecord(
        lens=observations.lenses[0],
        photos=tuple(
            PhotoRecord(
                name=photo.name,
                number=photo.number,
                size=photo.frame.size,
                pixel_aspect=photo.pixel_aspect,
                sha256=photo.sha256,
                taken=photo.taken,
                serial=photo.serial,
            )
            for photo in observations.photos
        ),
        lines=tuple(
            LineRecord(
                label=line.label,
                photo=line.photo,
                points_px=_pairs(line.points_px),
                before_px=tuple(before.tolist()),
                residuals_px=tuple(_finite(residual) for residual in after.tolist()),
                left_out=tuple(np.flatnonzero(~kept).tolist()),
                corrected_px=None if line.corrected_px is None else _pairs(line.corrected_px),
            )
            for line, before, after, kept in zip(
                observations.lines,
                calibration.before_px,
                calibration.residuals_px,
                calibration.kept,
                strict=True,
            )
        ),
        origins=tuple(
            OriginRecord(path=origin.path, format=origin.format, sha256=origin.sha256)
            for origin in observations.origins
        ),
        notes=observations.notes,
    )


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _pairs(values: Array) -> tuple[Pair, ...]:
    return tuple((x, y) for x, y in values.tolist())


def _matrix(values: Array) -> Matrix:
    return tuple(tuple(row) for row in values.tolist())

"""Read back the JSON of `plumbline.result.writing`.

Everything in a file is hostile until checked: the schema sees to types and to numbers, this
module to what they say of one another.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plumbline.errors import PlumblineError, ReadError
from plumbline.files import RESULT
from plumbline.frame import Array
from plumbline.geometry.lens import Lens
from plumbline.models import get_model
from plumbline.observations import Line, Observations, Origin, Photo
from plumbline.observations.facts import LensFacts
from plumbline.result.calibration import Calibration
from plumbline.result.pair import PairCalibration
from plumbline.result.records import DamageError, converted, parsed
from plumbline.result.schema import (
    FORMAT_VERSION,
    LARGEST,
    BendsRecord,
    BootstrapRecord,
    Head,
    LineRecord,
    Matrix,
    ObservationsRecord,
    PairRecord,
    ResultRecord,
    ResultsRecord,
    SuspectRecord,
)
from plumbline.trust.bends import ORDERS, Bends
from plumbline.trust.bootstrap import Bootstrap
from plumbline.trust.suspect import Suspect

_AGAIN = "fit again: plumbline fit POINTS -o result.json"
_ROUNDING = 1e-6
"""How far a covariance may be from symmetric and positive, as correlations: chosen, because
covariances are written exactly and rounding in double precision stays far below it."""


def read_records(text: str, path: str) -> tuple[ResultRecord, ...]:
    """What `to_json` wrote, as the file has it.

    Raises:
        ReadError: the text is not such JSON.
    """
    whole = parsed(text, path, _AGAIN)
    _refuse_others(whole, path)
    try:
        if "calibrations" in whole:
            return converted(whole, ResultsRecord).calibrations
        return (converted(whole, ResultRecord),)
    except DamageError as error:
        raise _damaged(path, error) from None


def calibration_of(record: ResultRecord, path: str) -> Calibration:
    """The calibration of a record.

    Raises:
        ReadError: its parts do not go together.
    """
    try:
        return _calibration(record)
    except (PlumblineError, DamageError) as error:
        raise _damaged(path, error) from None


def _damaged(path: str, error: Exception) -> ReadError:
    return ReadError(f"the calibration is damaged: {error}", path=path, hint=_AGAIN)


def _refuse_others(whole: Any, path: str) -> None:
    if not isinstance(whole, dict) or whole.get("format") != RESULT:
        raise ReadError("this is not a calibration written by plumbline", path=path, hint=_AGAIN)
    try:
        version = converted(whole, Head).format_version
    except DamageError as error:
        raise _damaged(path, error) from None
    if version > FORMAT_VERSION:
        raise ReadError(
            f"this calibration was written by plumbline {whole['plumbline']}, which is newer",
            path=path,
            hint="update plumbline",
        )


def _calibration(record: ResultRecord) -> Calibration:
    observations = _observations(record.observations)
    sizes = [len(line.points_px) for line in observations.lines]
    lines = record.observations.lines
    if [len(line.residuals_px) for line in lines] != sizes:
        raise DamageError("the residuals do not fit the points")
    kept = tuple(_kept(line) for line in lines)
    if not any(which.any() for which in kept):
        raise DamageError("every pick is left out")
    free = record.free
    lens = Lens(
        get_model(record.model), observations.photos[0].frame, record.coefficients, record.focal_px
    )
    names = set(lens.coefficients)
    if not set(free) <= names or len(set(free)) < len(free) or set(record.start) != names:
        raise DamageError("the coefficients do not fit the model")
    known = Calibration(
        observations=observations,
        lens=lens,
        free=free,
        start=record.start,
        residual=record.residual,
        covariance=_covariance(record.covariance, free),
        sigma_px=record.sigma_px,
        dof=record.dof,
        residuals_px=tuple(_residuals(line) for line in lines),
        rms_corrected_px=record.rms_corrected_px,
        converged=record.converged,
        reason=record.reason,
        remarks=record.remarks,
        kept=kept,
        suspects=tuple(_suspect(each, sizes) for each in record.suspects),
        robust=record.robust,
        bootstrap=_bootstrap(record.bootstrap, free),
        rival_px=record.rival_px,
        bends=_bends(record.bends, sizes),
        command=record.command,
        version=record.plumbline,
    )
    return known if record.pair is None else _paired(known, record.pair)


def _paired(calibration: Calibration, pair: PairRecord) -> PairCalibration:
    if any(line.corrected_px is None for line in calibration.observations.lines):
        raise DamageError("a pair lacks its matched points")
    values = {each.name: getattr(calibration, each.name) for each in fields(calibration)}
    return PairCalibration(**values, scale=pair.scale, place_px=pair.place_px)


def _observations(stored: ObservationsRecord) -> Observations:
    observations = Observations(
        photos=tuple(
            Photo(
                photo.size,
                photo.name,
                pixel_aspect=photo.pixel_aspect,
                number=photo.number,
                sha256=photo.sha256,
                taken=photo.taken,
                serial=photo.serial,
            )
            for photo in stored.photos
        ),
        lines=tuple(_line(line, len(stored.photos)) for line in stored.lines),
        lenses=(_facts(stored.lens),),
    ).checked(singly=any(line.corrected_px is not None for line in stored.lines))
    origins = tuple(Origin(each.path, each.format, checksum=each.sha256) for each in stored.origins)
    return replace(observations, origins=origins, notes=stored.notes)


def _line(line: LineRecord, photos: int) -> Line:
    if line.photo >= photos:
        raise DamageError(f"line {line.label} lies in photo {line.photo} of {photos}")
    points_px = np.array(line.points_px, dtype=np.float64).reshape(-1, 2)
    corrected_px = None
    if line.corrected_px is not None:
        corrected_px = np.array(line.corrected_px, dtype=np.float64).reshape(-1, 2)
        if len(corrected_px) != len(points_px):
            raise DamageError(f"line {line.label} has more points than matches, or fewer")
    return Line(points_px, line.photo, line.label, corrected_px=corrected_px)


def _facts(facts: LensFacts) -> LensFacts:
    for name, value in (asdict(facts) | dict(facts.stored)).items():
        if isinstance(value, float) and not abs(value) <= LARGEST:
            raise DamageError(f"observations.lens.{name} is a number out of range")
    return facts


def _covariance(values: Matrix, free: tuple[str, ...]) -> Array:
    if [len(row) for row in values] != [len(free)] * len(free):
        raise DamageError("the covariance does not fit the free coefficients")
    covariance = np.array(values, dtype=np.float64).reshape(len(free), len(free))
    if np.any(np.diag(covariance) < 0):
        raise DamageError("a variance is negative")
    deviations = np.sqrt(np.diag(covariance))
    scale = np.outer(deviations, deviations)
    correlation = np.divide(covariance, scale, out=np.zeros_like(scale), where=scale > 0)
    if not np.allclose(correlation, correlation.T, rtol=0, atol=_ROUNDING):
        raise DamageError("the covariance is not symmetric")
    if len(free) and np.min(np.linalg.eigvalsh(correlation)) < -_ROUNDING:
        raise DamageError("the covariance is not positive semi-definite")
    return covariance


def _bootstrap(data: BootstrapRecord | None, free: tuple[str, ...]) -> Bootstrap | None:
    if data is None:
        return None
    if set(data.intervals) != set(free):
        raise DamageError("the bootstrap does not fit the free coefficients")
    intervals = np.array([data.intervals[name] for name in free], dtype=np.float64).reshape(-1, 2)
    return Bootstrap(data.fits, data.failed, _covariance(data.covariance, free), intervals)


def _bends(data: BendsRecord | None, sizes: Sequence[int]) -> Bends | None:
    if data is None:
        return None
    known = data.order in ORDERS and len(data.tau_px) == len(sizes) and all(data.tau_px)
    if not known:
        raise DamageError("the bends do not fit the lines")
    return Bends(data.length, data.order, np.array(data.tau_px, dtype=np.float64))


def _residuals(line: LineRecord) -> Array:
    """Residuals of one line; null for a pick that was left out beyond the fold."""
    known = [np.inf if value is None else value for value in line.residuals_px]
    return np.array(known, dtype=np.float64)


def _kept(line: LineRecord) -> NDArray[np.bool_]:
    kept = np.ones(len(line.residuals_px), dtype=np.bool_)
    kept[_places(line.left_out, len(kept))] = False
    if not np.all(np.isfinite(_residuals(line)[kept])):
        raise DamageError("a pick without a residual is not left out")
    return kept


def _places(places: Sequence[int], n: int) -> list[int]:
    """Which of a line's n picks."""
    if not all(place < n for place in places):
        raise DamageError(f"pick {max(places)} of a line of {n} picks is named")
    return list(places)


def _suspect(record: SuspectRecord, sizes: Sequence[int]) -> Suspect:
    if record.line >= len(sizes):
        raise DamageError(f"line {record.line} of {len(sizes)} lines is called suspicious")
    away, size = record.residual_px, record.studentised
    return Suspect(
        record.line,
        tuple(_places(record.picks, sizes[record.line])),
        record.kind,
        np.inf if away is None else away,
        np.inf if size is None else size,
        record.left_out,
        record.sentence,
    )

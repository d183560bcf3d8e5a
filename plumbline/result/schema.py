"""The JSON of results: one schema for writing and for reading.

Fields without a default are in every file; those with one came later, and files without them
still read. Names that are not known are passed over, so that later versions may add some. What
is left out of a file but follows from the rest is computed again.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal

from msgspec import Meta, Struct

from plumbline.geometry.finding import Finding
from plumbline.observations.facts import LensFacts
from plumbline.trust.check import Check
from plumbline.trust.model_error import ModelError
from plumbline.trust.suspect import Kind

FORMAT_VERSION = 1
"""Rises when an older plumbline would misread a file, not when names are added."""

LARGEST = 1e100
"""Chosen, because sums of squares of larger numbers are not finite."""

_LARGEST_COUNT = 2**53
"""The largest whole number that every reader of JSON holds exactly (RFC 8259, section 6)."""

Number = Annotated[float, Meta(ge=-LARGEST, le=LARGEST)]
Size = Annotated[float, Meta(ge=0, le=LARGEST)]
Count = Annotated[int, Meta(ge=0, le=_LARGEST_COUNT)]
Pair = tuple[Number, Number]
Matrix = tuple[tuple[Number, ...], ...]


class Head(Struct, frozen=True, kw_only=True):
    """What a file is, and which version of plumbline wrote it."""

    format: str
    format_version: int
    plumbline: str


class PhotoRecord(Struct, frozen=True, kw_only=True):
    """A photo, without its picture; `sha256` is that of its file when the points were read."""

    name: str
    number: int
    size: tuple[Count, Count]
    pixel_aspect: Number
    sha256: str = ""
    taken: str = ""
    serial: str = ""


class LineRecord(Struct, frozen=True, kw_only=True):
    """A line's picks; `residuals_px` is null beyond the fold, `left_out` are indices of picks.

    `corrected_px` is where a corrected picture shows them, where they are matches.
    """

    label: str
    photo: Count
    points_px: tuple[Pair, ...]
    before_px: tuple[Number, ...] | None = None
    residuals_px: tuple[Number | None, ...]
    left_out: tuple[Count, ...] = ()
    corrected_px: tuple[Pair, ...] | None = None


class OriginRecord(Struct, frozen=True, kw_only=True):
    """A file that the picks were read from."""

    path: str
    format: str
    sha256: str = ""


class ObservationsRecord(Struct, frozen=True, kw_only=True):
    """What was fitted to."""

    lens: LensFacts
    photos: tuple[PhotoRecord, ...]
    lines: tuple[LineRecord, ...]
    origins: tuple[OriginRecord, ...]
    notes: tuple[str, ...]


class SuspectRecord(Struct, frozen=True, kw_only=True):
    """A suspicious pick; sizes beyond the fold are null."""

    line: Count
    picks: Annotated[tuple[Count, ...], Meta(min_length=1)]
    kind: Kind
    residual_px: Number | None
    studentised: Number | None
    left_out: bool
    sentence: str
    label: str = ""


class DisplacementRecord(Struct, frozen=True, kw_only=True):
    """Standard errors of the correction over the photo."""

    quote_px: Number
    quote_at_px: tuple[Pair, ...]
    largest_px: Number
    at_px: tuple[Pair, ...]
    jackknife_largest_px: Number | None
    quoted: str
    points_px: tuple[Pair, ...]
    errors_px: tuple[Number, ...]


class QuotedRecord(Struct, frozen=True, kw_only=True):
    """The error to quote and its parts, within the range of the picks."""

    worst_px: Number
    picks_px: Number
    missed_px: Number
    centre_px: Number
    curve_px: Number
    rectified_px: Number | None
    reached: Number


class JackknifeRecord(Struct, frozen=True, kw_only=True):
    """What leaving out lines says."""

    dof: int
    covariance: Matrix


class BootstrapRecord(Struct, frozen=True, kw_only=True):
    """What fits to resampled residuals say."""

    fits: Count
    failed: Count
    covariance: Matrix
    intervals: Mapping[str, Pair]
    largest_px: Number | None = None


class BendsRecord(Struct, frozen=True, kw_only=True):
    """How edges bend by themselves; the names are those of `Bends`."""

    length: Annotated[float, Meta(gt=0, le=LARGEST)]
    order: Annotated[float, Meta(gt=0, le=LARGEST)]
    tau_px: tuple[Size, ...]
    bend_px: Size | None = None


class StraightnessRecord(Struct, frozen=True, kw_only=True):
    """How straight a line is; null where it was left out as a whole."""

    label: str
    photo: int
    n_points: int
    rms_before_px: Number | None
    rms_after_px: Number | None
    largest_after_px: Number | None
    bend_px: Number | None = None


class PairRecord(Struct, frozen=True, kw_only=True):
    """How the corrected picture of a pair shows the original."""

    scale: Annotated[float, Meta(gt=0, le=LARGEST)]
    place_px: Pair


class ResultRecord(Head, frozen=True, kw_only=True):
    """One calibration; the names are those of `Calibration`."""

    model: str
    free: tuple[str, ...]
    residual: Literal["image", "corrected"]
    coefficients: Mapping[str, Number]
    standard_errors: Mapping[str, Number] | None = None
    start: Mapping[str, Number]
    covariance: Matrix
    sigma_px: Size
    dof: Annotated[int, Meta(ge=1, le=_LARGEST_COUNT)]
    rms_before_px: Number | None = None
    rms_after_px: Number | None = None
    rms_corrected_px: Size
    largest_before_px: Number | None = None
    largest_after_px: Number | None = None
    intervals: Mapping[str, Pair] | None = None
    displacement: DisplacementRecord | None = None
    quoted: QuotedRecord | None = None
    jackknife: JackknifeRecord | None = None
    bootstrap: BootstrapRecord | None = None
    bends: BendsRecord | None = None
    model_error: ModelError | None = None
    robust: bool = False
    checks: tuple[Check, ...] | None = None
    suspects: tuple[SuspectRecord, ...] = ()
    rival_px: Number | None = None
    converged: bool
    reason: str
    finding: Finding | None = None
    focal_px: Number | None
    notes: tuple[str, ...] | None = None
    remarks: tuple[str, ...]
    command: str = ""
    lines: tuple[StraightnessRecord, ...] | None = None
    pair: PairRecord | None = None
    observations: ObservationsRecord


class ResultsRecord(Head, frozen=True, kw_only=True):
    """Several calibrations of one file."""

    calibrations: Annotated[tuple[ResultRecord, ...], Meta(min_length=1)]

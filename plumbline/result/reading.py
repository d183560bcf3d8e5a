"""Read back the JSON of `plumbline.result.writing`.

Everything in a file is hostile until checked: shapes must fit, numbers be finite and indices
point at something.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeVar

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
from plumbline.result.values import (
    DamageError,
    array_of,
    finite,
    pair_of,
    size,
    truth,
    whole_number,
)
from plumbline.result.writing import FORMAT_VERSION
from plumbline.trust.bootstrap import Bootstrap
from plumbline.trust.suspect import KINDS, Suspect

T = TypeVar("T")

_AGAIN = "fit again: plumbline fit POINTS -o result.json"
_TEXTS = ("maker", "model", "camera", "mount", "projection")
_LATER_TEXTS = ("exif_make", "exif_model")  # absent from files of plumbline's first days
_NUMBERS = (
    "focal_mm",
    "crop_factor",
    "crop_factor_error",
    "hfov_deg",
    "hfov_width_px",
    "focal_px",
    "aspect_ratio",
)
_WRONG_KIND = (ValueError, TypeError, IndexError, AttributeError, OverflowError)


def from_json(text: str, path: str) -> tuple[Calibration, ...]:
    """Read back what `to_json` wrote.

    Raises:
        ReadError: the text is no such JSON.
    """
    try:
        whole = json.loads(text, parse_constant=_not_finite)
        _refuse_others(whole, path)
        made = tuple(_calibration(each) for each in whole.get("calibrations", [whole]))
    except ReadError:
        raise
    except RecursionError:
        raise ReadError("the JSON is nested too deeply", path=path, hint=_AGAIN) from None
    except KeyError as error:
        raise ReadError(f"the calibration lacks {error}", path=path, hint=_AGAIN) from None
    except json.JSONDecodeError as error:
        raise ReadError(
            "the file is damaged: its text is no JSON from here on",
            path=path,
            line=error.lineno,
            hint=_AGAIN,
        ) from None
    except (PlumblineError, DamageError) as error:
        raise ReadError(f"the calibration is damaged: {error}", path=path, hint=_AGAIN) from None
    except _WRONG_KIND:
        raise ReadError(
            "the calibration is damaged: something else stands where a number, a text or a list "
            "belongs",
            path=path,
            hint=_AGAIN,
        ) from None
    if not made:
        raise ReadError("there is no calibration in this file", path=path, hint=_AGAIN)
    return made


def _refuse_others(whole: Any, path: str) -> None:
    if not isinstance(whole, dict) or whole.get("format") != RESULT:
        raise ReadError("this is no calibration written by plumbline", path=path, hint=_AGAIN)
    if whole.get("format_version") != FORMAT_VERSION:
        raise ReadError(
            "this calibration was written by another version of plumbline", path=path, hint=_AGAIN
        )


def _not_finite(name: str) -> float:
    raise DamageError(f"{name} is no finite number")


def _calibration(data: Mapping[str, Any]) -> Calibration:
    stored = data["observations"]
    observations = _observations(stored)
    sizes = [len(line.points_px) for line in observations.lines]
    residuals_px = tuple(_residuals(line["residuals_px"]) for line in stored["lines"])
    if [len(values) for values in residuals_px] != sizes:
        raise DamageError("the residuals do not fit the points")
    every = zip(stored["lines"], residuals_px, strict=True)
    kept = tuple(_kept(line.get("left_out", []), values) for line, values in every)
    if not any(which.any() for which in kept):
        raise DamageError("every pick is left out")
    free = tuple(str(name) for name in data["free"])
    lens = _lens(data, observations)
    start = {str(name): finite(value) for name, value in data["start"].items()}
    names = set(lens.coefficients)
    if not set(free) <= names or len(set(free)) < len(free) or set(start) != names:
        raise DamageError("the coefficients do not fit the model")
    if data["residual"] not in ("image", "corrected"):
        raise DamageError("the kind of residual is not known")
    known: dict[str, Any] = {
        "observations": observations,
        "lens": lens,
        "free": free,
        "start": start,
        "residual": data["residual"],
        "covariance": _covariance(data["covariance"], free),
        "sigma_px": size(data["sigma_px"]),
        "dof": whole_number(data["dof"], least=1),
        "residuals_px": residuals_px,
        "rms_corrected_px": size(data["rms_corrected_px"]),
        "converged": truth(data["converged"]),
        "reason": str(data["reason"]),
        "remarks": tuple(str(note) for note in data["remarks"]),
        "kept": kept,
        "suspects": tuple(_suspect(each, sizes) for each in data.get("suspects", [])),
        "robust": truth(data.get("robust", False)),
        "bootstrap": _bootstrap(data.get("bootstrap"), free),
        "command": str(data.get("command", "")),
        "version": str(data["plumbline"]),
    }
    if "pair" not in data:
        return Calibration(**known)
    scale = finite(data["pair"]["scale"])
    if not scale > 0 or any(line.corrected_px is None for line in observations.lines):
        raise DamageError("a pair has a scale and matched points")
    return PairCalibration(**known, scale=scale, place_px=pair_of(data["pair"]["place_px"], finite))


def _observations(stored: Mapping[str, Any]) -> Observations:
    observations = Observations(
        photos=tuple(
            Photo(
                pair_of(p["size"], int),
                str(p["name"]),
                0,
                finite(p["pixel_aspect"]),
                int(p["number"]),
            )
            for p in stored["photos"]
        ),
        lines=tuple(
            Line(
                array_of(line["points_px"], 2),
                int(line["photo"]),
                str(line["label"]),
                corrected_px=_matched(line),
            )
            for line in stored["lines"]
        ),
        lenses=(_facts(stored["lens"]),),
    )
    paired = any(line.corrected_px is not None for line in observations.lines)
    observations = observations.checked(singly=paired)
    if not all(0 <= line.photo < len(observations.photos) for line in observations.lines):
        raise DamageError("a line lies in no photo")
    origins = tuple(
        Origin(str(o["path"]), str(o["format"]), checksum=str(o.get("sha256", "")))
        for o in stored["origins"]
    )
    notes = tuple(str(note) for note in stored["notes"])
    return replace(observations, origins=origins, notes=notes)


def _matched(line: Mapping[str, Any]) -> Array | None:
    """Where a corrected picture shows the points, if they are matches."""
    if "corrected_px" not in line:
        return None
    corrected_px = array_of(line["corrected_px"], 2)
    if corrected_px.shape != np.shape(line["points_px"]) or corrected_px.shape[1:] != (2,):
        raise DamageError("the matched points are not as many as the points")
    return corrected_px


def _lens(data: Mapping[str, Any], observations: Observations) -> Lens:
    return Lens(
        get_model(str(data["model"])),
        observations.photos[0].frame,
        {str(name): finite(value) for name, value in data["coefficients"].items()},
        None if data["focal_px"] is None else finite(data["focal_px"]),
    )


def _covariance(values: Any, free: tuple[str, ...]) -> Array:
    covariance = array_of(values, 2)
    if covariance.shape != (len(free), len(free)) or np.any(np.diag(covariance) < 0):
        raise DamageError("the covariance does not fit the free coefficients")
    deviations = np.sqrt(np.diag(covariance))
    scale = np.outer(deviations, deviations)
    correlation = np.divide(covariance, scale, out=np.zeros_like(scale), where=scale > 0)
    symmetric = np.allclose(correlation, correlation.T, rtol=0, atol=1e-6)
    if not symmetric or (len(free) and np.min(np.linalg.eigvalsh(correlation)) < -1e-6):
        raise DamageError("the covariance is none")
    return covariance


def _bootstrap(data: Any, free: tuple[str, ...]) -> Bootstrap | None:
    if data is None:
        return None
    if set(data["intervals"]) != set(free):
        raise DamageError("the bootstrap does not fit the free coefficients")
    intervals = array_of([pair_of(data["intervals"][name], finite) for name in free], 2)
    covariance = _covariance(data["covariance"], free)
    fits, failed = (whole_number(data[name], least=0) for name in ("fits", "failed"))
    return Bootstrap(fits, failed, covariance, intervals)


def _residuals(values: Any) -> Array:
    """Residuals of one line; null for a pick that was left out beyond the fold."""
    known = [np.inf if value is None else finite(value) for value in values]
    return np.array(known, dtype=np.float64)


def _kept(left_out: Any, residuals_px: Array) -> NDArray[np.bool_]:
    kept = np.ones(len(residuals_px), dtype=np.bool_)
    kept[_places(left_out, len(kept))] = False
    if not np.all(np.isfinite(residuals_px[kept])):
        raise DamageError("a pick without a residual is not left out")
    return kept


def _places(values: Any, n: int) -> list[int]:
    """Which of a line's n picks."""
    if not isinstance(values, list):
        raise DamageError("places of picks are no list")
    places = [whole_number(value, least=0) for value in values]
    if not all(place < n for place in places):
        raise DamageError("a pick is named that there is not")
    return places


def _suspect(data: Mapping[str, Any], sizes: Sequence[int]) -> Suspect:
    line = whole_number(data["line"], least=0)
    picks = tuple(_places(data["picks"], sizes[line]))
    if not picks:
        raise DamageError("a suspect is no pick at all")
    if data["kind"] not in KINDS:
        raise DamageError(f"there is no kind of suspect {data['kind']!r}")
    away, size = data["residual_px"], data["studentised"]
    return Suspect(
        line,
        picks,
        data["kind"],
        np.inf if away is None else finite(away),
        np.inf if size is None else finite(size),
        truth(data["left_out"]),
        str(data["sentence"]),
    )


def _facts(data: Mapping[str, Any]) -> LensFacts:
    facts: dict[str, Any] = {name: str(data[name]) for name in _TEXTS}
    facts |= {name: str(data.get(name, "")) for name in _LATER_TEXTS}
    facts |= {name: None if data[name] is None else finite(data[name]) for name in _NUMBERS}
    requested = data["requested"]
    return LensFacts(
        **facts,
        stored={str(name): finite(value) for name, value in data["stored"].items()},
        requested=None if requested is None else tuple(str(name) for name in requested),
    )

"""Read back the JSON of `plumbline.result_json`.

Everything in a file is hostile until checked: shapes must fit, numbers be finite and indices
point at something.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plumbline.bootstrap import Bootstrap
from plumbline.calibration import Calibration
from plumbline.errors import PlumblineError, ReadError
from plumbline.facts import LensFacts
from plumbline.files import RESULT
from plumbline.frame import Array
from plumbline.lens import Lens
from plumbline.models import get_model
from plumbline.observations import Line, Observations, Origin, Photo
from plumbline.result_json import FORMAT_VERSION
from plumbline.suspect import KINDS, Suspect

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
_MOST = 1e100
_DAMAGE = (ValueError, TypeError, IndexError, AttributeError, OverflowError)


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
    except (PlumblineError, *_DAMAGE) as error:
        raise ReadError(f"the calibration is damaged: {error}", path=path, hint=_AGAIN) from None
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
    raise ValueError(f"{name} is no finite number")


def _calibration(data: Mapping[str, Any]) -> Calibration:
    stored = data["observations"]
    observations = Observations(
        photos=tuple(
            Photo(_pair(p["size"]), str(p["name"]), 0, _number(p["pixel_aspect"]), int(p["number"]))
            for p in stored["photos"]
        ),
        lines=tuple(
            Line(_array(line["points_px"], 2), int(line["photo"]), str(line["label"]))
            for line in stored["lines"]
        ),
        lenses=(_facts(stored["lens"]),),
    ).checked()
    origins = tuple(
        Origin(str(o["path"]), str(o["format"]), checksum=str(o.get("sha256", "")))
        for o in stored["origins"]
    )
    residuals_px = tuple(_residuals(line["residuals_px"]) for line in stored["lines"])
    kept = tuple(
        _kept(line.get("left_out", []), len(values))
        for line, values in zip(stored["lines"], residuals_px, strict=True)
    )
    sizes = [len(line.points_px) for line in observations.lines]
    if [len(values) for values in residuals_px] != sizes:
        raise ValueError("the residuals do not fit the points")
    if not all(0 <= line.photo < len(observations.photos) for line in observations.lines):
        raise ValueError("a line lies in no photo")
    free = tuple(str(name) for name in data["free"])
    model = get_model(str(data["model"]))
    lens = Lens(
        model,
        observations.photos[0].frame,
        {str(name): _number(value) for name, value in data["coefficients"].items()},
        None if data["focal_px"] is None else _number(data["focal_px"]),
    )
    covariance = _array(data["covariance"], 2)
    names = set(lens.coefficients)
    if covariance.shape != (len(free), len(free)) or np.any(np.diag(covariance) < 0):
        raise ValueError("the covariance does not fit the free coefficients")
    start = {str(name): _number(value) for name, value in data["start"].items()}
    if not set(free) <= names or len(set(free)) < len(free) or set(start) != names:
        raise ValueError("the coefficients do not fit the model")
    if data["residual"] not in ("image", "corrected") or not isinstance(data["converged"], bool):
        raise ValueError("the kind of residual or the convergence is not known")
    return Calibration(
        observations=replace(
            observations,
            origins=origins,
            notes=tuple(str(note) for note in stored["notes"]),
        ),
        lens=lens,
        free=free,
        start=start,
        residual=data["residual"],
        covariance=covariance,
        sigma_px=_number(data["sigma_px"]),
        dof=int(data["dof"]),
        residuals_px=residuals_px,
        rms_corrected_px=_number(data["rms_corrected_px"]),
        converged=data["converged"],
        reason=str(data["reason"]),
        remarks=tuple(str(note) for note in data["remarks"]),
        kept=kept,
        suspects=tuple(_read_suspect(each, sizes) for each in data.get("suspects", [])),
        robust=bool(data.get("robust", False)),
        bootstrap=_read_bootstrap(data.get("bootstrap"), free),
        command=str(data.get("command", "")),
        version=str(data["plumbline"]),
    )


def _read_bootstrap(data: Any, free: tuple[str, ...]) -> Bootstrap | None:
    if data is None:
        return None
    covariance = _array(data["covariance"], 2)
    intervals = _array([data["intervals"][name] for name in free], 2)
    if covariance.shape != (len(free), len(free)) or intervals.shape != (len(free), 2):
        raise ValueError("the bootstrap does not fit the free coefficients")
    return Bootstrap(int(data["fits"]), int(data["failed"]), covariance, intervals)


def _residuals(values: Any) -> Array:
    """Residuals of one line; null for a pick that was left out beyond the fold."""
    known = [np.inf if value is None else _number(value) for value in values]
    return np.array(known, dtype=np.float64)


def _kept(left_out: Any, n: int) -> NDArray[np.bool_]:
    kept = np.ones(n, dtype=np.bool_)
    for place in left_out:
        if not 0 <= int(place) < n:
            raise ValueError("a pick is left out that there is not")
        kept[int(place)] = False
    return kept


def _read_suspect(data: Mapping[str, Any], sizes: Sequence[int]) -> Suspect:
    line, picks = int(data["line"]), tuple(int(place) for place in data["picks"])
    if not 0 <= line < len(sizes) or not all(0 <= place < sizes[line] for place in picks):
        raise ValueError("a pick is suspected that there is not")
    if data["kind"] not in KINDS:
        raise ValueError(f"there is no kind of suspect {data['kind']!r}")
    size, away = data["studentised"], data["residual_px"]
    return Suspect(
        line,
        picks,
        data["kind"],
        np.inf if away is None else _number(away),
        np.inf if size is None else _number(size),
        bool(data["left_out"]),
        str(data["sentence"]),
    )


def _pair(values: Any) -> tuple[int, int]:
    width, height = values
    return int(width), int(height)


def _array(values: Any, dimensions: int) -> Array:
    array = np.array(values, dtype=np.float64)
    if array.ndim != dimensions or not np.all(np.abs(array) <= _MOST):
        raise ValueError("an array has the wrong shape or holds an absurd number")
    return array


def _number(value: Any) -> float:
    number = float(value)
    if not abs(number) <= _MOST:
        raise ValueError(f"{number:g} is an absurd number")
    return number


def _facts(data: Mapping[str, Any]) -> LensFacts:
    facts: dict[str, Any] = {name: str(data[name]) for name in _TEXTS}
    facts |= {name: str(data.get(name, "")) for name in _LATER_TEXTS}
    facts |= {name: None if data[name] is None else _number(data[name]) for name in _NUMBERS}
    requested = data["requested"]
    return LensFacts(
        **facts,
        stored={str(name): _number(value) for name, value in data["stored"].items()},
        requested=None if requested is None else tuple(str(name) for name in requested),
    )

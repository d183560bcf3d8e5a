"""Calibrations as JSON, with the observations they came from.

The names are those of `Calibration`. One lens is one object; several are listed under
`calibrations`. Floats are written so that they read back exactly.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from plumbline._version import __version__
from plumbline.calibration import Calibration
from plumbline.errors import PlumblineError, ReadError
from plumbline.frame import Array
from plumbline.lens import Lens
from plumbline.models import get_model
from plumbline.observations import LensFacts, Line, Observations, Photo

FORMAT_NAME = "plumbline calibration"
FORMAT_VERSION = 1


def to_json(calibrations: Sequence[Calibration]) -> str:
    """JSON text of one or several calibrations."""
    objects = [as_dict(made) for made in calibrations]
    whole = objects[0] if len(objects) == 1 else _header() | {"calibrations": objects}
    return json.dumps(whole, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _header() -> dict[str, Any]:
    return {"format": FORMAT_NAME, "format_version": FORMAT_VERSION, "plumbline": __version__}


def as_dict(made: Calibration) -> dict[str, Any]:
    """One calibration as plain lists, dicts, strings and numbers."""
    finding = made.finding
    return _header() | {
        "model": made.model,
        "free": list(made.free),
        "residual": made.residual,
        "coefficients": made.coefficients,
        "standard_errors": made.standard_errors,
        "start": dict(made.start),
        "covariance": made.covariance.tolist(),
        "sigma_px": made.sigma_px,
        "dof": made.dof,
        "rms_before_px": made.rms_before_px,
        "rms_after_px": made.rms_after_px,
        "rms_corrected_px": made.rms_corrected_px,
        "largest_before_px": made.largest_before_px,
        "largest_after_px": made.largest_after_px,
        "converged": made.converged,
        "reason": made.reason,
        "finding": asdict(finding),
        "focal_px": made.lens.focal_px,
        "notes": list(made.notes),
        "lines": [line._asdict() for line in made.lines],
        "observations": _observations(made),
    }


def _observations(made: Calibration) -> dict[str, Any]:
    observations = made.observations
    return {
        "lens": asdict(observations.lenses[0]),
        "photos": [
            {
                "name": p.name,
                "number": p.number,
                "size": list(p.frame.size),
                "pixel_aspect": p.pixel_aspect,
            }
            for p in observations.photos
        ],
        "lines": [
            {
                "label": line.label,
                "photo": line.photo,
                "points_px": line.points_px.tolist(),
                "before_px": before.tolist(),
                "residuals_px": after.tolist(),
            }
            for line, before, after in zip(
                observations.lines, made.before_px, made.residuals_px, strict=True
            )
        ],
        "origins": [{"path": o.path, "format": o.format} for o in observations.origins],
    }


def from_json(text: str, path: str) -> tuple[Calibration, ...]:
    """Read back what `to_json` wrote.

    Raises:
        ReadError: the text is no such JSON.
    """
    try:
        whole = json.loads(text)
        if not isinstance(whole, dict) or whole.get("format") != FORMAT_NAME:
            raise ReadError(
                "this is no calibration written by plumbline",
                path=path,
                hint="make one with: plumbline fit POINTS -o result.json",
            )
        if whole.get("format_version") != FORMAT_VERSION:
            raise ReadError(
                "this calibration was written by another version of plumbline",
                path=path,
                hint="fit again with this version",
            )
        return tuple(_calibration(each) for each in whole.get("calibrations", [whole]))
    except ReadError:
        raise
    except PlumblineError as error:
        raise ReadError(error.message, path=path, hint=error.hint) from None
    except RecursionError:
        raise ReadError("the JSON is nested too deeply", path=path) from None
    except (ValueError, KeyError, TypeError, IndexError, AttributeError, OverflowError) as error:
        raise ReadError(f"the calibration is damaged ({error})", path=path) from None


def _calibration(data: Mapping[str, Any]) -> Calibration:
    stored = data["observations"]
    observations = Observations(
        photos=tuple(
            Photo(_pair(p["size"]), str(p["name"]), 0, float(p["pixel_aspect"]), int(p["number"]))
            for p in stored["photos"]
        ),
        lines=tuple(
            Line(_array(line["points_px"], 2), int(line["photo"]), str(line["label"]))
            for line in stored["lines"]
        ),
        lenses=(_facts(stored["lens"]),),
        notes=(),
    ).checked()
    free = tuple(str(name) for name in data["free"])
    model = get_model(str(data["model"]))
    lens = Lens(
        model,
        observations.photos[0].frame,
        {str(name): float(value) for name, value in data["coefficients"].items()},
        None if data["focal_px"] is None else float(data["focal_px"]),
    )
    covariance = _array(data["covariance"], 2)
    if covariance.shape != (len(free), len(free)) or not set(free) <= set(lens.coefficients):
        raise ValueError("the covariance does not fit the free coefficients")
    return Calibration(
        observations=observations,
        lens=lens,
        free=free,
        start={str(name): float(value) for name, value in data["start"].items()},
        residual="corrected" if data["residual"] == "corrected" else "image",
        covariance=covariance,
        sigma_px=float(data["sigma_px"]),
        dof=int(data["dof"]),
        residuals_px=tuple(_array(line["residuals_px"], 1) for line in stored["lines"]),
        before_px=tuple(_array(line["before_px"], 1) for line in stored["lines"]),
        rms_corrected_px=float(data["rms_corrected_px"]),
        converged=bool(data["converged"]),
        reason=str(data["reason"]),
        notes=tuple(str(note) for note in data["notes"]),
    )


def _pair(values: Any) -> tuple[int, int]:
    width, height = values
    return int(width), int(height)


def _array(values: Any, dimensions: int) -> Array:
    array = np.array(values, dtype=np.float64)
    if array.ndim != dimensions or not np.all(np.isfinite(array)):
        raise ValueError("an array has the wrong shape or is not finite")
    return array


def _facts(data: Mapping[str, Any]) -> LensFacts:
    texts = {k: str(data[k]) for k in ("maker", "model", "camera", "mount", "projection")}
    numbers = {
        k: None if data[k] is None else float(data[k])
        for k in ("focal_mm", "crop_factor", "hfov_deg", "focal_px", "aspect_ratio")
    }
    requested = data["requested"]
    return LensFacts(
        **texts,
        **numbers,
        stored={str(name): float(value) for name, value in data["stored"].items()},
        requested=None if requested is None else tuple(str(name) for name in requested),
    )

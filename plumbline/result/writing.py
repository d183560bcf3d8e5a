"""Calibrations as JSON, with the observations they came from.

The names are those of `Calibration`. One lens is one object; several are listed under
`calibrations`. Floats are written so that they read back exactly.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from plumbline._version import __version__
from plumbline.files import RESULT
from plumbline.observations import Line
from plumbline.result.calibration import Calibration
from plumbline.result.pair import PairCalibration
from plumbline.trust.straightness import LineStraightness
from plumbline.trust.suspect import Suspect

FORMAT_VERSION = 1


def to_json(calibrations: Sequence[Calibration]) -> str:
    """JSON text of one or several calibrations."""
    objects = [as_dict(made) for made in calibrations]
    whole = objects[0] if len(objects) == 1 else _header() | {"calibrations": objects}
    text = json.dumps(whole, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    # A file name that is no text is written in JSON's own escapes and reads back as it was.
    return text.encode("utf-8", "backslashreplace").decode()


def _header() -> dict[str, Any]:
    return {"format": RESULT, "format_version": FORMAT_VERSION, "plumbline": __version__}


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
        "intervals": {name: list(ends) for name, ends in made.intervals.items()},
        "displacement": _displacement(made),
        "jackknife": _jackknife(made),
        "bootstrap": _bootstrap(made),
        "model_error": None if made.model_error is None else asdict(made.model_error),
        "robust": made.robust,
        "checks": [asdict(check) for check in made.checks],
        "suspects": [_suspect(made, each) for each in made.suspects],
        "converged": made.converged,
        "reason": made.reason,
        "finding": asdict(finding),
        "focal_px": made.lens.focal_px,
        "notes": list(made.notes),
        "remarks": list(made.remarks),
        "command": made.command,
        **_pair(made),
        "lines": [_line(line) for line in made.lines],
        "observations": _observations(made),
    }


def _pair(made: Calibration) -> dict[str, Any]:
    """How the corrected picture lies, where there is one."""
    if not isinstance(made, PairCalibration):
        return {}
    return {"pair": {"scale": made.scale, "place_px": list(made.place_px)}}


def _displacement(made: Calibration) -> dict[str, Any] | None:
    sure, quoted = made.displacement, made.quoted_displacement
    if sure is None or quoted is None:
        return None
    wide = made.jackknife_displacement
    return {
        "quote_px": quoted.worst_px,
        "quote_at_px": quoted.worst_at_px.tolist(),
        "largest_px": sure.worst_px,
        "at_px": sure.worst_at_px.tolist(),
        "jackknife_largest_px": None if wide is None else wide.worst_px,
        "quoted": "jackknife" if made.quotes_jackknife else "independent",
        "points_px": sure.points_px.tolist(),
        "errors_px": sure.errors_px.tolist(),
    }


def _line(line: LineStraightness) -> dict[str, Any]:
    """Its straightness, null where it was left out as a whole."""
    known = line._asdict()
    return {n: None if line.left_out and n.endswith("_px") else v for n, v in known.items()}


def _jackknife(made: Calibration) -> dict[str, Any] | None:
    left = made.jackknife
    return None if left is None else {"dof": left.dof, "covariance": left.covariance.tolist()}


def _bootstrap(made: Calibration) -> dict[str, Any] | None:
    again, wide = made.bootstrap, made.bootstrap_displacement
    if again is None:
        return None
    return {
        "fits": again.fits,
        "failed": again.failed,
        "covariance": again.covariance.tolist(),
        "intervals": dict(zip(made.free, again.intervals.tolist(), strict=True)),
        "largest_px": None if wide is None else wide.worst_px,
    }


def _suspect(made: Calibration, suspect: Suspect) -> dict[str, Any]:
    size = suspect.studentised if np.isfinite(suspect.studentised) else None
    return asdict(suspect) | {
        "label": made.observations.lines[suspect.line].label,
        "picks": list(suspect.picks),
        "residual_px": suspect.residual_px if np.isfinite(suspect.residual_px) else None,
        "studentised": size,
    }


def _corrected(line: Line) -> dict[str, Any]:
    return {} if line.corrected_px is None else {"corrected_px": line.corrected_px.tolist()}


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
                **_corrected(line),
                "before_px": before.tolist(),
                "residuals_px": [r if np.isfinite(r) else None for r in after.tolist()],
                "left_out": np.flatnonzero(~kept).tolist(),
            }
            for line, before, after, kept in zip(
                observations.lines, made.before_px, made.residuals_px, made.kept, strict=True
            )
        ],
        "origins": [
            {"path": o.path, "format": o.format, "sha256": o.sha256} for o in observations.origins
        ],
        "notes": list(observations.notes),
    }

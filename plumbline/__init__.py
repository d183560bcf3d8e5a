"""Calibrate a lens from straight lines.

    import plumbline
    obs = plumbline.read("building.pto")
    cal = plumbline.calibrate(obs)
    cal.coefficients, cal.standard_errors, cal.rms_after_px
    plumbline.write(cal, "building.fit.pto")

Importing this package loads neither NumPy nor JAX; they come with the first name that needs
them.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from plumbline._version import __version__

if TYPE_CHECKING:
    from plumbline.calibration import Calibration
    from plumbline.checks import Check
    from plumbline.comparison import Candidate, Comparison
    from plumbline.errors import (
        CollapsedFitError,
        DegenerateLinesError,
        FoldedError,
        OptionError,
        PlumblineError,
        ReadError,
        UnsettledError,
        UnsupportedModelError,
        WriteError,
    )
    from plumbline.edges.snap import Snapped, snap
    from plumbline.facts import LensFacts
    from plumbline.fit.bootstrap import bootstrap
    from plumbline.fit.calibrate import calibrate, calibrate_many
    from plumbline.fit.compare import compare
    from plumbline.formats.known import FORMATS
    from plumbline.frame import Frame
    from plumbline.imaging.batch import Outcome, correct_many
    from plumbline.imaging.correct import Corrected, correct, correct_array
    from plumbline.lens import Lens
    from plumbline.models import MODELS, get_model
    from plumbline.observations import Line, Observations, Photo
    from plumbline.reading import join, read, read_calibration, read_calibrations
    from plumbline.suspect import Suspect
    from plumbline.writing import write, write_points

_HOMES = {
    "plumbline.calibration": ("Calibration",),
    "plumbline.errors": (
        "CollapsedFitError",
        "DegenerateLinesError",
        "FoldedError",
        "OptionError",
        "PlumblineError",
        "ReadError",
        "UnsettledError",
        "UnsupportedModelError",
        "WriteError",
    ),
    "plumbline.comparison": ("Candidate", "Comparison"),
    "plumbline.edges.snap": ("Snapped", "snap"),
    "plumbline.fit.bootstrap": ("bootstrap",),
    "plumbline.fit.compare": ("compare",),
    "plumbline.suspect": ("Suspect",),
    "plumbline.checks": ("Check",),
    "plumbline.fit.calibrate": ("calibrate", "calibrate_many"),
    "plumbline.formats.known": ("FORMATS",),
    "plumbline.frame": ("Frame",),
    "plumbline.imaging.batch": ("Outcome", "correct_many"),
    "plumbline.imaging.correct": ("Corrected", "correct", "correct_array"),
    "plumbline.lens": ("Lens",),
    "plumbline.models": ("MODELS", "get_model"),
    "plumbline.facts": ("LensFacts",),
    "plumbline.observations": ("Line", "Observations", "Photo"),
    "plumbline.reading": ("join", "read", "read_calibration", "read_calibrations"),
    "plumbline.writing": ("write", "write_points"),
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

__all__ = [
    "FORMATS",
    "MODELS",
    "Calibration",
    "Candidate",
    "Check",
    "CollapsedFitError",
    "Comparison",
    "Corrected",
    "DegenerateLinesError",
    "FoldedError",
    "Frame",
    "Lens",
    "LensFacts",
    "Line",
    "Observations",
    "OptionError",
    "Outcome",
    "Photo",
    "PlumblineError",
    "ReadError",
    "Snapped",
    "Suspect",
    "UnsettledError",
    "UnsupportedModelError",
    "WriteError",
    "__version__",
    "bootstrap",
    "calibrate",
    "calibrate_many",
    "compare",
    "correct",
    "correct_array",
    "correct_many",
    "get_model",
    "join",
    "read",
    "read_calibration",
    "read_calibrations",
    "snap",
    "write",
    "write_points",
]


def __getattr__(name: str) -> object:
    if name not in _HOME_OF:
        raise AttributeError(f"module 'plumbline' has no attribute {name!r}")
    return getattr(import_module(_HOME_OF[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)

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

from plumbline._version import __version__ as __version__

if TYPE_CHECKING:
    from plumbline.boards.find import (
        find_board as find_board,
    )
    from plumbline.boards.photographs import (
        calibrate_board as calibrate_board,
    )
    from plumbline.edges.find import (
        Found as Found,
        find_edges as find_edges,
    )
    from plumbline.edges.snap import (
        Snapped as Snapped,
        snap as snap,
    )
    from plumbline.errors import (
        CollapsedFitError as CollapsedFitError,
        DegenerateLinesError as DegenerateLinesError,
        FoldedError as FoldedError,
        OptionError as OptionError,
        PairError as PairError,
        PlumblineError as PlumblineError,
        ReadError as ReadError,
        UnsettledError as UnsettledError,
        UnsupportedModelError as UnsupportedModelError,
        WriteError as WriteError,
    )
    from plumbline.fit.bootstrap import (
        bootstrap as bootstrap,
    )
    from plumbline.fit.calibrate import (
        calibrate as calibrate,
    )
    from plumbline.fit.check import (
        check as check,
    )
    from plumbline.fit.choice.compare import (
        compare as compare,
    )
    from plumbline.fit.many import (
        calibrate_many as calibrate_many,
    )
    from plumbline.formats.known import (
        FORMATS as FORMATS,
    )
    from plumbline.frame import (
        Frame as Frame,
    )
    from plumbline.geometry.lens import (
        Lens as Lens,
    )
    from plumbline.ground.rectification import (
        Rectification as Rectification,
    )
    from plumbline.ground.rectify import (
        rectify as rectify,
    )
    from plumbline.ground.stored import (
        read_rectification as read_rectification,
    )
    from plumbline.imaging.batch import (
        Outcome as Outcome,
        correct_many as correct_many,
    )
    from plumbline.imaging.correct import (
        Corrected as Corrected,
        correct as correct,
        correct_array as correct_array,
    )
    from plumbline.lenses.lookup import (
        find_lens as find_lens,
    )
    from plumbline.lenses.request import (
        LensRequest as LensRequest,
    )
    from plumbline.models import (
        MODELS as MODELS,
        get_model as get_model,
    )
    from plumbline.observations import (
        Line as Line,
        Observations as Observations,
        Photo as Photo,
    )
    from plumbline.observations.board import (
        Board as Board,
    )
    from plumbline.observations.facts import (
        LensFacts as LensFacts,
    )
    from plumbline.pairs.calibrate import (
        calibrate_pair as calibrate_pair,
    )
    from plumbline.pairs.files import (
        calibrate_pair_files as calibrate_pair_files,
    )
    from plumbline.reading.joining import (
        join as join,
    )
    from plumbline.reading.points import (
        read as read,
    )
    from plumbline.rectified.picture import (
        PictureRequest as PictureRequest,
    )
    from plumbline.rectified.writing import (
        write_rectified as write_rectified,
    )
    from plumbline.report.writing import (
        write_report as write_report,
    )
    from plumbline.result.calibration import (
        Calibration as Calibration,
    )
    from plumbline.result.checked import (
        Checked as Checked,
    )
    from plumbline.result.comparison import (
        Candidate as Candidate,
        Comparison as Comparison,
    )
    from plumbline.result.files import (
        read_calibration as read_calibration,
        read_calibrations as read_calibrations,
    )
    from plumbline.result.pair import (
        PairCalibration as PairCalibration,
    )
    from plumbline.trust.check import (
        Check as Check,
    )
    from plumbline.trust.suspect import (
        Suspect as Suspect,
    )
    from plumbline.writing.beside import (
        write_beside as write_beside,
    )
    from plumbline.writing.files import (
        write_export as write_export,
    )
    from plumbline.writing.results import (
        write as write,
        write_points as write_points,
    )
    from plumbline.writing.zoom import (
        read_zoom_lens as read_zoom_lens,
        write_zoom as write_zoom,
    )

_HOMES = {
    "plumbline.boards.find": ("find_board",),
    "plumbline.boards.photographs": ("calibrate_board",),
    "plumbline.edges.find": (
        "Found",
        "find_edges",
    ),
    "plumbline.edges.snap": (
        "Snapped",
        "snap",
    ),
    "plumbline.errors": (
        "CollapsedFitError",
        "DegenerateLinesError",
        "FoldedError",
        "OptionError",
        "PairError",
        "PlumblineError",
        "ReadError",
        "UnsettledError",
        "UnsupportedModelError",
        "WriteError",
    ),
    "plumbline.fit.bootstrap": ("bootstrap",),
    "plumbline.fit.calibrate": ("calibrate",),
    "plumbline.fit.check": ("check",),
    "plumbline.fit.choice.compare": ("compare",),
    "plumbline.fit.many": ("calibrate_many",),
    "plumbline.formats.known": ("FORMATS",),
    "plumbline.frame": ("Frame",),
    "plumbline.geometry.lens": ("Lens",),
    "plumbline.ground.rectification": ("Rectification",),
    "plumbline.ground.rectify": ("rectify",),
    "plumbline.ground.stored": ("read_rectification",),
    "plumbline.imaging.batch": (
        "Outcome",
        "correct_many",
    ),
    "plumbline.imaging.correct": (
        "Corrected",
        "correct",
        "correct_array",
    ),
    "plumbline.lenses.lookup": ("find_lens",),
    "plumbline.lenses.request": ("LensRequest",),
    "plumbline.models": (
        "MODELS",
        "get_model",
    ),
    "plumbline.observations": (
        "Line",
        "Observations",
        "Photo",
    ),
    "plumbline.observations.board": ("Board",),
    "plumbline.observations.facts": ("LensFacts",),
    "plumbline.pairs.calibrate": ("calibrate_pair",),
    "plumbline.pairs.files": ("calibrate_pair_files",),
    "plumbline.reading.joining": ("join",),
    "plumbline.reading.points": ("read",),
    "plumbline.rectified.picture": ("PictureRequest",),
    "plumbline.rectified.writing": ("write_rectified",),
    "plumbline.report.writing": ("write_report",),
    "plumbline.result.calibration": ("Calibration",),
    "plumbline.result.checked": ("Checked",),
    "plumbline.result.comparison": (
        "Candidate",
        "Comparison",
    ),
    "plumbline.result.files": (
        "read_calibration",
        "read_calibrations",
    ),
    "plumbline.result.pair": ("PairCalibration",),
    "plumbline.trust.check": ("Check",),
    "plumbline.trust.suspect": ("Suspect",),
    "plumbline.writing.beside": ("write_beside",),
    "plumbline.writing.files": ("write_export",),
    "plumbline.writing.results": (
        "write",
        "write_points",
    ),
    "plumbline.writing.zoom": (
        "read_zoom_lens",
        "write_zoom",
    ),
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

__all__ = [*sorted([*_HOME_OF, "__version__"])]  # noqa: PLE0604  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> object:
    if name not in _HOME_OF:
        raise AttributeError(f"module 'plumbline' has no attribute {name!r}")
    return getattr(import_module(_HOME_OF[name]), name)


def __dir__() -> list[str]:
    return list(__all__)

"""Results read for a report, and a clear word where a file holds none."""

from __future__ import annotations

from plumbline.calibration import Calibration
from plumbline.consistency import consistent_results
from plumbline.files import ZOOM, read_bytes
from plumbline.formats.base import Source


def read_results(path: str) -> tuple[Calibration, ...]:
    """The calibrations of a JSON that `fit` wrote, one a lens.

    Raises:
        ReadError: the file is damaged or another one; a project or a LensFun file holds a lens,
            but neither residuals nor errors; lens, picks and residuals contradict each other.
    """
    source = Source(path, read_bytes(path))
    head = source.head.lstrip()
    if not head.startswith("{"):
        raise source.error(
            "a report needs residuals and error bars, which only plumbline's JSON holds",
            hint="make it with plumbline fit POINTS -o building.json, then plumbline report "
            "building.json",
        )
    if f'"{ZOOM}"' in head[:1024]:
        raise source.error(
            "this is a zoom lens, and a report is of the calibrations it was joined from",
            hint="plumbline report RESULT for each of them",
        )
    return consistent_results(source.text(), path)

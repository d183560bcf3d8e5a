"""Results read for a report, and a clear word where a file holds none."""

from __future__ import annotations

import numpy as np

from plumbline.calibration import Calibration
from plumbline.files import ZOOM, read_bytes
from plumbline.formats.base import Source
from plumbline.result_reading import from_json


def read_results(path: str) -> tuple[Calibration, ...]:
    """The calibrations of a JSON that `fit` wrote, one a lens.

    Raises:
        ReadError: the file is damaged or another one; a project or a LensFun file holds a lens,
            but neither residuals nor errors; the lens cannot be that of the picks.
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
    calibrations = from_json(source.text(), path)
    for made in calibrations:
        if not _belongs_together(made):
            raise source.error(
                "the lens does not go with the picks it is said to be fitted to",
                hint="fit again: plumbline fit POINTS -o building.json",
            )
    return calibrations


def _belongs_together(made: Calibration) -> bool:
    """Whether there are picks to judge by, and the lens reaches all of them without a fold."""
    kept = np.concatenate(made.kept)
    centre = float(made.lens.model.factor(np.float64(0.0), made.lens.vector))
    used = sum(bool(which.any()) for which in made.kept)
    dof = int(np.count_nonzero(kept)) - 2 * used - len(made.free)
    return made.dof == dof and centre > 0 and np.array_equal(made.linearised.kept, kept)

"""The one door to results in files: every reader of a result comes through here.

What is read must hang together: lens, picks, residuals, σ̂ and covariance are of one fit, and the
figures beside them follow from it.
"""

from __future__ import annotations

from pathlib import Path

from plumbline.errors import ReadError
from plumbline.files import ZOOM, read_bytes
from plumbline.formats.base import Source
from plumbline.result.calibration import Calibration
from plumbline.result.consistency import contradiction
from plumbline.result.reading import calibration_of, read_records


def read_calibrations(path: str | Path) -> tuple[Calibration, ...]:
    """Read the calibrations of a JSON file that plumbline wrote, one a lens.

    Raises:
        ReadError: it is missing, damaged or another file, or was changed since it was written.
    """
    source = Source(str(path), read_bytes(path))
    head = source.head.lstrip()
    if not head.startswith("{"):
        raise source.error(
            "only plumbline's JSON holds the residuals and error bars of a fit",
            hint="write it with plumbline fit POINTS -o building.json",
        )
    if f'"{ZOOM}"' in head[:1024]:
        raise source.error(
            "this is a zoom lens, which was joined from several calibrations",
            hint="give the RESULT.json of one focal length",
        )
    return consistent_results(source.text(), source.path)


def read_calibration(path: str | Path) -> Calibration:
    """Read the one calibration of a JSON file that plumbline wrote.

    Raises:
        ReadError: as `read_calibrations`, or it holds several lenses.
    """
    found = read_calibrations(path)
    if len(found) != 1:
        raise ReadError(
            f"the file holds {len(found)} calibrations",
            path=path,
            hint="take them all with plumbline.read_calibrations",
        )
    return found[0]


def consistent_results(text: str, path: str) -> tuple[Calibration, ...]:
    """Read back what `to_json` wrote, and compute again what follows from lens and picks.

    Raises:
        ReadError: the text is not such JSON, or it contradicts itself.
    """
    records = read_records(text, path)
    calibrations = tuple(calibration_of(record, path) for record in records)
    for calibration, record in zip(calibrations, records, strict=True):
        wrong = contradiction(calibration, record)
        if wrong:
            raise ReadError(
                f"this result was changed since it was written: {wrong}",
                path=path,
                hint="fit again: plumbline fit POINTS -o result.json",
            )
    return calibrations

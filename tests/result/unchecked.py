"""Results read without asking whether they hang together, for those made up number by number."""

from __future__ import annotations

from plumbline.result.calibration import Calibration
from plumbline.result.reading import calibration_of, read_records


def from_json(text: str, path: str) -> tuple[Calibration, ...]:
    """Read back what `to_json` wrote."""
    return tuple(calibration_of(record, path) for record in read_records(text, path))

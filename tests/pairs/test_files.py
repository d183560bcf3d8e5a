"""Pairs of files in one call."""

from __future__ import annotations

import hashlib
from pathlib import Path

import pytest

import plumbline
from plumbline.errors import OptionError, PairError

SAMPLE = Path(__file__).parents[2] / "sample_projects" / "pair"
ORIGINAL, CORRECTED = SAMPLE / "developed.jpg", SAMPLE / "camera.jpg"


def test_the_checksums_of_both_files_are_kept() -> None:
    calibration = plumbline.calibrate_pair_files(ORIGINAL, CORRECTED, free=("b",))
    assert [origin.sha256 for origin in calibration.observations.origins] == [
        hashlib.sha256(path.read_bytes()).hexdigest() for path in (ORIGINAL, CORRECTED)
    ]


def test_one_file_twice_is_no_pair() -> None:
    with pytest.raises(OptionError, match="the two pictures are one file"):
        plumbline.calibrate_pair_files(ORIGINAL, ORIGINAL)
    other = SAMPLE.parent / "building" / "facade.jpg"
    with pytest.raises(PairError, match=r"developed\.jpg and .*facade\.jpg"):
        plumbline.calibrate_pair_files(ORIGINAL, other)

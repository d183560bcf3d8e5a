"""A fixed subset of LensFun's lenses is recovered; the whole database on demand."""

from __future__ import annotations

import pytest

from tests.benchmarks.lensfun_recovery import (
    ACTION_CAMERAS,
    Entry,
    database,
    ideal_corner,
    read_database,
    run,
)

EVERY = 40


def test_lenses_of_the_database_are_recovered_from_zero() -> None:
    folder = database()
    if folder is None:
        pytest.skip("LensFun's database is not installed (Debian: liblensfun-data-v1)")
    entries = read_database(folder)
    assert len(entries) > 4000
    outcome = run(entries[::EVERY])
    assert outcome.entries - outcome.folding > 95
    assert not outcome.inexact
    assert not outcome.wrong_minima


def test_action_cameras_are_recovered_from_zero() -> None:
    entries = [Entry("action camera", abc, 4 / 3) for abc in ACTION_CAMERAS]
    assert all(ideal_corner(entry) for entry in entries)
    outcome = run(entries)
    assert outcome.folding == 0
    assert not outcome.inexact
    assert not outcome.wrong_minima

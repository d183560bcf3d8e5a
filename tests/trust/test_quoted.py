"""The one figure: what it consists of, and that everything that prints an error prints it."""

from __future__ import annotations

import io
import json
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from plumbline import Observations, calibrate, check, read
from plumbline.report.terminal.summary import print_summary
from plumbline.result.files import consistent_results
from plumbline.result.writing import to_json
from plumbline.trust.nuisances import CENTRE_SPREAD, nuisances_of
from tests.benchmarks.groups import FACADE, GRID, lens
from tests.benchmarks.outside import true_px
from tests.benchmarks.simulated import Group

BUILDING = Path(__file__).parents[2] / "sample_projects" / "building" / "building.pto"


def told(made: object, *, quiet: bool) -> str:
    out = io.StringIO()
    print_summary(Console(file=out, width=400), [made], [], quiet=quiet)  # type: ignore[list-item]
    return out.getvalue()


def test_summary_quiet_check_and_json_state_one_figure_and_one_verdict() -> None:
    obs = read(BUILDING)
    made, found = calibrate(obs), check(obs)
    assert made.quoted is not None
    figure = made.quoted.sentence
    assert figure in told(made, quiet=False)
    assert figure in told(made, quiet=True)
    assert any(figure in each.finding for each in found.checks)
    assert json.loads(to_json([made]))["displacement"]["quote_px"] == made.quoted.worst_px


def test_the_json_tells_the_parts_and_reads_back_without_them() -> None:
    made = calibrate(read(BUILDING))
    assert made.quoted is not None
    told = json.loads(to_json([made]))
    parts = told["quoted"]
    assert parts["worst_px"] == pytest.approx(np.hypot(parts["picks_px"], parts["missed_px"]))
    assert parts["worst_px"] == told["displacement"]["quote_px"]
    assert told["displacement"]["quoted"] == "picks and lens"
    del told["quoted"], told["rival_px"]
    (again,) = consistent_results(json.dumps(told), "x.json")
    assert again.quoted is not None
    assert again.quoted.worst_px == made.quoted.worst_px


def test_the_error_at_the_worst_place_is_the_figure() -> None:
    made = calibrate(read(BUILDING))
    assert made.quoted is not None
    found = made.trust.quoted_errors_px(made.quoted.total.worst_at_px)
    assert found is not None
    assert np.max(found) == pytest.approx(made.quoted.worst_px, rel=1e-9)


def test_a_centre_that_is_off_is_in_the_error_and_in_the_first_line() -> None:
    true = lens("S120 5.2 mm", d=20.0, e=-12.0)
    group = Group("off", true, GRID, 0.3)
    picks = group.picks_px(1)[0]
    made = calibrate(Observations.from_arrays(group.by_line(picks), true.size))
    assert made.quoted is not None
    assert true_px(true, made) < 2 * made.quoted.worst_px
    assert true_px(true, made) > 5 * made.quoted.picks_px / 3
    first = told(made, quiet=True).splitlines()[0]
    assert "the picks put the distortion centre at d = +" in first
    assert "--free a,b,c,d,e" in first
    freed = calibrate(made.observations, free=("a", "b", "c", "d", "e"))
    assert freed.doubt == ""


def test_the_parts_add_up_and_the_centre_is_told_apart() -> None:
    group = Group("S120", lens("S120 5.2 mm"), FACADE, 0.3)
    made = calibrate(Observations.from_arrays(group.by_line(group.picks_px(1)[0]), group.lens.size))
    sure = made.quoted
    assert sure is not None
    assert sure.worst_px == pytest.approx(np.hypot(sure.picks_px, sure.missed_px), rel=1e-12)
    assert "the distortion centre is not known" in sure.sentence
    assert sure.rectified_px is not None
    assert sure.rectified_px < sure.worst_px
    assert "beyond" in sure.sentence
    assert made.doubt == ""


def test_the_spread_of_the_centre_can_be_changed() -> None:
    made = calibrate(read(BUILDING))
    usual = nuisances_of(made.lens, made.free).spreads
    wider = nuisances_of(made.lens, made.free, 2 * CENTRE_SPREAD).spreads
    np.testing.assert_array_equal(wider[:2], 2 * usual[:2])
    assert usual[0] == CENTRE_SPREAD * min(made.lens.frame.size) / 2
    np.testing.assert_array_equal(wider[2:], usual[2:])

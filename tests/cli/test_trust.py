"""`check`, `compare` and the options of `fit` that say how far to trust a result."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.cli.process import Run
from tests.readme import ROOT

BUILDING = ROOT / "sample_projects" / "building" / "building.pto"


@pytest.fixture(autouse=True)
def sample(run: Run) -> None:  # run first, since it chooses the folder
    """The picks of the first sample project as CSV, and with three of them spoiled."""
    shutil.copy(BUILDING, "building.pto")
    assert run("convert", "building.pto", "good.csv").status == 0
    rows = [row.split(",") for row in Path("good.csv").read_text().splitlines()]
    head, picks = rows[0], rows[1:]
    at = {name: head.index(name) for name in ("line", "x", "y")}

    def of_line(label: str) -> list[list[str]]:
        return [row for row in picks if row[at["line"]] == label]

    first, second = of_line(picks[0][at["line"]]), of_line(picks[10][at["line"]])
    first[4][at["y"]] = str(float(first[4][at["y"]]) + 60)
    first[7][at["x"]], second[7][at["x"]] = second[7][at["x"]], first[7][at["x"]]
    first[7][at["y"]], second[7][at["y"]] = second[7][at["y"]], first[7][at["y"]]
    Path("spoiled.csv").write_text("\n".join(",".join(row) for row in (head, *picks)) + "\n")


SIZE = ("--size", "2256x1504")


def test_check_writes_nothing_and_names_remedies(run: Run) -> None:
    before = sorted(Path().iterdir())
    done = run("check", "building.pto")
    assert done.status == 0
    assert "✓ 140 points on 14 lines leave 109 degrees of freedom" in done.out
    assert sorted(Path().iterdir()) == before


def test_check_of_few_central_lines(run: Run) -> None:
    rows = [f"{i},{x},{500 + 20 * i + 0.1 * (x % 3)}" for i in range(3) for x in (300, 500, 700)]
    Path("few.csv").write_text("line,x,y\n" + "\n".join(rows) + "\n")
    done = run("check", "few.csv", "--size", "1000x1000", "--free", "b")
    assert "✗" in done.out
    assert "→ pick" in done.out
    assert "Traceback" not in done.err


def test_check_says_what_it_can_where_no_fit_is_possible(run: Run) -> None:
    Path("one.csv").write_text("line,x,y\n" + "".join(f"1,{x},500\n" for x in (1, 400, 800)))
    done = run("check", "one.csv", "--size", "1000x1001")
    assert done.status == 1
    assert "✗ 3 points on 1 line are too few for 3 coefficients" in done.out
    assert "Error: " in done.err


def test_check_as_json(run: Run) -> None:
    done = run("check", "spoiled.csv", *SIZE, "--json")
    (lens,) = json.loads(done.out)["lenses"]
    assert {"name", "passed", "finding", "remedy", "doubtful"} == set(lens["checks"][0])
    assert not next(c for c in lens["checks"] if c["name"] == "suspects")["passed"]
    assert len(lens["suspects"]) == 3


def test_suspects_are_named_and_used_by_a_plain_fit(run: Run) -> None:
    done = run("fit", "spoiled.csv", *SIZE, "--json", "-o", "made.json")
    made = json.loads(done.out)
    assert made["dof"] == 140 - 2 * 14 - 3
    kinds = sorted(suspect["kind"] for suspect in made["suspects"])
    assert kinds == ["exchanged", "exchanged", "stray"]
    assert all(line["left_out"] == [] for line in made["observations"]["lines"])


def test_a_robust_fit_lists_what_it_leaves_out(run: Run) -> None:
    good = json.loads(run("fit", "good.csv", *SIZE, "--json", "-o", "good.json").out)
    done = run("fit", "spoiled.csv", *SIZE, "--robust", "-o", "made.json")
    assert done.status == 0
    assert "3 picks of 140 left out as suspicious" in done.out
    assert done.out.count(" px from its line") == 3
    assert "exchanged with pick 8 of line" in done.out
    made = json.loads(Path("made.json").read_text())
    assert made["robust"]
    assert made["dof"] == good["dof"] - 3
    for name, error in good["standard_errors"].items():
        assert abs(made["coefficients"][name] - good["coefficients"][name]) < error
    assert made["command"].startswith("plumbline fit spoiled.csv")


@pytest.fixture
def garbage() -> str:
    """Fourteen lines as a lens with r (1 - 0.03 r^2) shows them, one of them rubbish."""
    rng = np.random.default_rng(1)
    rows = ["line,x,y"]
    for line in range(14):
        along, across = np.linspace(50, 950, 9), np.full(9, 40 + 66 * line)
        ideal = np.stack((along, across) if line % 2 else (across, along), axis=1)
        q = (ideal - 499.5) / 500
        picks = 499.5 + 500 * q * (1 - 0.03 * (q**2).sum(axis=1, keepdims=True))
        if line == 4:
            picks = rng.uniform(20, 980, (9, 2))
        rows += [f"{line},{x:.2f},{y:.2f}" for x, y in picks + rng.normal(0, 0.2, (9, 2))]
    Path("garbage.csv").write_text("\n".join(rows) + "\n")
    return "garbage.csv"


def test_check_names_the_picks_that_stop_the_plain_fit(run: Run, garbage: str) -> None:
    done = run("check", garbage, "--size", "1000x1000")
    assert done.status == 1
    assert "too few picks of line 4 agree on a straight line" in done.out
    assert "9 picks of 126 are suspicious" in done.out
    assert "plumbline fit --robust leaves them out" in done.err


def test_a_refused_fit_names_robust_where_that_works(run: Run, garbage: str) -> None:
    done = run("fit", garbage, "--size", "1000x1000")
    assert done.status == 1
    assert "9 picks of 126 are suspicious: --robust fits the others" in done.err
    assert run("fit", garbage, "--size", "1000x1000", "--robust").status == 0


def test_a_refused_fit_names_no_robust_where_it_does_not_help(run: Run) -> None:
    rng = np.random.default_rng(2)
    picks = [f"{line},{x},{y}" for line in range(6) for x, y in rng.uniform(1, 998, (6, 2))]
    Path("noise.csv").write_text("line,x,y\n" + "\n".join(picks) + "\n")
    for words in (("fit",), ("check",)):
        done = run(*words, "noise.csv", "--size", "1000x1000")
        assert done.status == 1
        assert "--robust" not in done.err
    assert run("fit", "noise.csv", "--size", "1000x1000", "--robust").status == 1


def test_compare_recommends_and_says_why(run: Run) -> None:
    done = run("compare", "building.pto")
    assert done.status == 0
    assert "Recommended: ptlens a, b, c; b alone is not enough" in done.out
    assert "the distortion centre" in done.out
    assert "--model ptlens --free a,b,c" in done.out
    table = json.loads(run("compare", "building.pto", "--json").out)["comparisons"][0]
    assert table["recommended"] == "ptlens a, b, c"
    assert len(table["candidates"]) >= 12
    least = min(row["aicc"] for row in table["candidates"])
    for row in table["candidates"]:
        assert row["delta_aicc"] == row["aicc"] - least
        assert row["overall_error_px"] > 0
        assert f"{row['delta_aicc']:+.1f}" in done.out
    assert table["quote"] in done.out


def test_a_robust_comparison_says_what_it_left_out(run: Run) -> None:
    plain = run("compare", "spoiled.csv", *SIZE)
    assert "suspicious picks took part: see plumbline check" in plain.out
    done = run("compare", "spoiled.csv", *SIZE, "--robust")
    assert done.status == 0
    assert "3 suspicious picks were left out" in done.out
    assert "Recommended: ptlens a, b, c; " in done.out
    fitted = run("fit", "spoiled.csv", *SIZE, "--robust", "--model", "auto", "-o", "made.json")
    assert "ptlens a, b, c was chosen: b alone is not enough" in fitted.out
    assert "3 picks of 140 left out as suspicious" in fitted.out


def test_an_older_result_that_is_not_replaced_is_mentioned(run: Run) -> None:
    assert run("fit", "building.pto").status == 0
    told = "the one that is there is not of this fit"
    done = run("fit", "building.pto", "--model", "division")
    assert done.status == 0
    assert done.out.count(told) == 2
    Path("building.fit.pto").unlink()
    assert run("fit", "building.pto", "--model", "division").out.count(told) == 1


def test_the_recommended_model_is_fitted(run: Run) -> None:
    done = run("fit", "building.pto", "--model", "auto", "--json", "-o", "made.json")
    made = json.loads(done.out)
    assert (made["model"], made["free"]) == ("ptlens", ["a", "b", "c"])
    assert any("ptlens a, b, c was chosen" in note for note in made["remarks"])


def test_auto_chooses_coefficients_itself(run: Run) -> None:
    done = run("fit", "building.pto", "--model", "auto", "--free", "b")
    assert done.status == 2
    assert "chooses the model and its coefficients itself" in done.err


def test_bootstrap_beside_the_other_errors(run: Run) -> None:
    done = run("fit", "building.pto", "--bootstrap", "200", "-o", "made.json")
    assert "bootstrap of 200 fits: a ± " in done.out
    made = json.loads(Path("made.json").read_text())
    assert made["bootstrap"]["fits"] == 200
    for name, (low, high) in made["bootstrap"]["intervals"].items():
        assert low < made["coefficients"][name] < high


def test_a_bootstrap_of_nearly_no_fits_makes_no_sense(run: Run) -> None:
    done = run("fit", "building.pto", "--bootstrap", "5")
    assert done.status == 2
    assert "5 is not in the range 50<=x<=100000" in done.err
    assert not Path("building.fit.pto").exists()


def test_what_compare_recommends_of_believed_picks_is_fitted_robustly(
    run: Run, garbage: str
) -> None:
    done = run("compare", garbage, "--size", "1000x1000", "--robust")
    assert done.status == 0
    advice = done.out.splitlines()[-1]
    assert advice.startswith("Fit it with --model")
    assert advice.count("--robust") == 2

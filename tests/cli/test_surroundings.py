"""The command in other surroundings: Windows' code page, and values that overflow."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.report.made import BUILDING

SIGNS = "✓", "✗", "σ", "→", "•", "±"


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """The first sample, beside which results go."""
    return Path(shutil.copytree(BUILDING.parent, tmp_path / "büro"))


def on_windows(folder: Path, *words: str) -> subprocess.CompletedProcess[bytes]:
    """Run the command as a Windows console has it, as far as another system can."""
    surroundings = {
        "PYTHONUTF8": "0",
        "PYTHONIOENCODING": "cp1252",
        "XDG_DATA_HOME": str(folder / "data"),
        "COLUMNS": "120",
    }
    return subprocess.run(
        [sys.executable, "-m", "plumbline", *words],
        cwd=folder,
        env=os.environ | surroundings,
        capture_output=True,
        timeout=120,
        check=False,
    )


VERBS = {
    "fit": (
        "fit",
        "building.pto",
        "-o",
        "a.json",
        "-o",
        "a.xml",
        "-o",
        "a.pto",
        "--report",
        "a.html",
    ),
    "check": ("check", "building.pto"),
    "convert": ("convert", "building.pto", "points.csv"),
    "models": ("models",),
    "lens": ("lens", "facade.jpg"),
    "correct": ("correct", "facade.jpg", "--lens", "building.pto", "-o", "c.jpg"),
    "help": ("fit", "--help"),
}


@pytest.mark.parametrize("words", VERBS.values(), ids=VERBS)
def test_a_code_page_that_lacks_our_signs(project: Path, words: tuple[str, ...]) -> None:
    done = on_windows(project, *words)
    told = (done.stdout + done.stderr).decode("cp1252")  # fails where a byte is no letter of it
    assert "Traceback" not in told
    assert done.returncode in (0, 1)
    assert not {sign for sign in SIGNS if f"\\u{ord(sign):04x}" in told}


def test_marks_stay_distinct_there(project: Path) -> None:
    rows = (project / "building.pto").read_text().splitlines(keepends=True)
    picks = [row for row in rows if row.startswith("c ")]
    few = [row for row in rows if not row.startswith("c ")] + [
        p for p in picks if " t3" in p or " t4" in p
    ]
    (project / "few.pto").write_text("".join(few))
    told = on_windows(project, "check", "few.pto").stdout.decode("cp1252")
    marks = {row.split(" ")[0] for row in told.splitlines() if row and row[0] != " "}
    assert {"OK", "BAD"} <= marks <= {"OK", "BAD", "?"}


def test_names_with_backslashes(project: Path) -> None:
    """A project made on Windows names its photo by a path of that system."""
    text = (project / "building.pto").read_text()
    (project / "win.pto").write_text(text.replace('n"facade.jpg"', 'n"C:\\fotos\\facade.jpg"'))
    done = on_windows(project, "fit", "win.pto", "-q", "--plot", "photo.svg")
    assert done.returncode == 0
    assert b"not found" not in done.stdout + done.stderr
    assert b"C:\\fotos" in (project / "win.fit.pto").read_bytes()


@pytest.mark.parametrize(
    "words",
    [
        ("fit", "building.pto", "-q", "--start", "a=1e308"),
        ("fit", "building.pto", "-q", "--start", "a=1e14"),
        ("fit", "far.pto", "-q"),
        ("correct", "facade.jpg", "--lens", "far.pto", "-o", "o.jpg"),
        ("correct", "facade.jpg", "--ptlens", "a=0,b=0,c=0,e=1e100", "-o", "o.jpg"),
    ],
    ids=" ".join,
)
def test_values_that_overflow_end_in_one_sentence(project: Path, words: tuple[str, ...]) -> None:
    text = (project / "building.pto").read_text()
    assert " e0 " in text
    (project / "far.pto").write_text(text.replace(" e0 ", " e1e100 ", 1))
    done = on_windows(project, *words)
    assert done.returncode == 1
    sentence, remedy = done.stderr.decode("cp1252").splitlines()
    assert sentence.startswith("Error: ")
    assert remedy.startswith("  ")
    assert not (project / "o.jpg").exists()

"""No fit depends on the cache: absent, whole, broken, unwritable or shared, it is the same."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import plumbline
from plumbline.fit.program import blocks, compiled as programs
from tests.many import all_calibrated
from tests.truth import TrueLens

LENS = TrueLens("ptlens", {"a": 0.0213, "b": -0.0864, "c": 0.0321})
LINES = LENS.lines(16, 8, noise_px=0.4, seed=5)


def command(folder: Path, cache: Path) -> subprocess.Popen[str]:
    """A fit in a process of its own, with that cache."""
    points = folder / "points.csv"
    rows = [f"{i},{x!r},{y!r}" for i, line in enumerate(LINES) for x, y in line.tolist()]
    points.write_text("line,x,y\n" + "\n".join(rows) + "\n")
    size = "x".join(map(str, LENS.size))
    how = ["--size", size, "--json", "-q", "-o", str(folder / "made.json")]
    return subprocess.Popen(
        [sys.executable, "-m", "plumbline", "fit", str(points), *how],
        env=os.environ | {"PLUMBLINE_CACHE_DIR": str(cache)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def result(running: subprocess.Popen[str]) -> dict[str, Any]:
    out, err = running.communicate(timeout=200)
    assert running.returncode == 0, err
    assert "Warning" not in err
    return json.loads(out)["coefficients"]


def furthest_px(one: dict[str, float], other: dict[str, float]) -> float:
    """Largest difference of two lenses over the photo."""
    model, frame = plumbline.get_model("ptlens"), plumbline.Frame(*LENS.size)
    x, y = np.meshgrid(np.linspace(0, LENS.size[0] - 1, 21), np.linspace(0, LENS.size[1] - 1, 21))
    grid = np.stack((x, y), axis=-1)
    ideal = [plumbline.Lens(model, frame, values).undistort(grid) for values in (one, other)]
    return float(np.max(np.abs(ideal[0] - ideal[1])))


def fresh(folder: Path, name: str) -> Path:
    made = folder / name
    made.mkdir()
    return made


def test_a_fit_is_the_same_whatever_the_cache(tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    first = result(command(fresh(tmp_path, "first"), cache))
    assert list(cache.glob("*.program"))
    assert list(cache.glob("jit_*-cache"))
    kept = result(command(fresh(tmp_path, "kept"), cache))
    for path in cache.iterdir():
        path.write_bytes(path.read_bytes()[:1000])
    broken = result(command(fresh(tmp_path, "broken"), cache))
    rebuilt = result(command(fresh(tmp_path, "rebuilt"), cache))
    assert all(path.stat().st_size > 1000 for path in cache.glob("*.program"))
    no_folder = tmp_path / "a file"
    no_folder.write_text("")
    without = result(command(fresh(tmp_path, "without"), no_folder))
    for other in (kept, broken, rebuilt, without):
        assert furthest_px(first, other) < 1e-9


def test_two_processes_may_make_one_cache(tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    both = [command(fresh(tmp_path, name), cache) for name in ("one", "two")]
    one, two = (result(running) for running in both)
    assert furthest_px(one, two) < 1e-9


def test_a_program_of_other_code_or_another_version_is_not_taken(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    fit = programs.Fit(plumbline.get_model("ptlens"), centre=False)
    key = programs._key(fit, (), None)  # pyright: ignore[reportPrivateUsage]
    assert key == programs._key(fit, (), None)  # pyright: ignore[reportPrivateUsage]
    with_centre = fit._replace(centre=True)
    assert key != programs._key(with_centre, (), None)  # pyright: ignore[reportPrivateUsage]
    monkeypatch.setattr(programs, "_sources", lambda: "other code")
    assert key != programs._key(fit, (), None)  # pyright: ignore[reportPrivateUsage]
    monkeypatch.undo()
    monkeypatch.setattr(programs, "version", str.upper)
    assert key != programs._key(fit, (), None)  # pyright: ignore[reportPrivateUsage]


@pytest.mark.parametrize("rows", [32, 64])
def test_the_size_of_the_bucket_changes_nothing(rows: int, monkeypatch: pytest.MonkeyPatch) -> None:
    observations = plumbline.Observations.from_arrays(LINES, LENS.size)
    small = plumbline.calibrate(observations)
    monkeypatch.setattr(blocks, "_LEAST_ROWS", rows)
    large = plumbline.calibrate(observations)
    assert furthest_px(small.coefficients, large.coefficients) < 1e-9


def test_a_batch_changes_nothing() -> None:
    observations = plumbline.Observations.from_arrays(LINES, LENS.size)
    single = plumbline.calibrate(observations)
    for made in all_calibrated([observations] * 6):
        assert furthest_px(single.coefficients, made.coefficients) < 1e-9


def test_clearing_takes_only_what_belongs_to_the_cache(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    names = ("a.program", "jit_call-1-cache", "jit_call-1-atime", "notes.txt", "b-cache")
    for name in names:
        (tmp_path / name).write_text("x")
    monkeypatch.setenv("PLUMBLINE_CACHE_DIR", str(tmp_path))
    assert len(programs.kept(programs.cache_folder())) == 3
    assert programs.clear(tmp_path) == 3
    assert sorted(path.name for path in tmp_path.iterdir()) == ["b-cache", "notes.txt"]
    assert programs.clear(tmp_path / "nowhere") == 0

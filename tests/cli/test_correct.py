"""`plumbline correct` as a process: lenses, points, maps, many photographs, refusals."""

from __future__ import annotations

import csv
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from PIL import Image

import plumbline
from tests.imaging.painted import centroids, dots, grid_inside, texture
from tests.truth import Array, TrueLens

ROOT = Path(__file__).parents[2]
OLYMPUS = ROOT.parent / "shared" / "data" / "olympus"
PTLENS = ("--ptlens", "a=0,b=-0.05,c=0")
POINTS = ("--points", "p.csv", "--size", "9x9")
MAP = ("--map", "m.tif")
FOLDED = ("--ptlens", "a=-0.3,b=-0.4")
SIZE = (600, 400)
TRUTH = TrueLens("ptlens", {"a": 0.0, "b": -0.05, "c": 0.0}, SIZE)


def plumb(folder: Path, *arguments: str, status: int = 0) -> subprocess.CompletedProcess[str]:
    done = subprocess.run(
        [sys.executable, "-m", "plumbline", *arguments],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(ROOT), "COLUMNS": "100"},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == status, done.stderr
    assert "Traceback" not in done.stderr
    return done


def photo(path: Path, seed: int = 0) -> Path:
    Image.fromarray(texture(SIZE, seed=seed)).save(path)
    return path


def test_a_remedy_is_one(tmp_path: Path) -> None:
    """--size goes with points, not with photographs."""
    assert "--size" not in plumb(tmp_path, "correct", "missing.jpg", status=1).stderr
    (tmp_path / "p.csv").write_text("1,2\n")
    (tmp_path / "p.bin").write_text("hello")
    arguments = ("correct", "--points", "p.bin", "--size", "9x9", *PTLENS)
    told = plumb(tmp_path, *arguments, status=1).stderr
    assert "name it with --format" in told
    assert ": plumbline convert takes that, and makes a CSV" in told
    photo(tmp_path / "a.jpg")
    done = plumb(tmp_path, "correct", "a.jpg", "--lens", "p.bin", status=1)
    assert "p.bin: this file holds no lens that is known here" in done.stderr
    assert "a PTLens profile, a zoom JSON, a result JSON" in done.stderr
    assert "--format" not in done.stderr
    arguments = ("correct", "missing.jpg", "--points", "p.csv", *PTLENS)
    assert "--size WIDTHxHEIGHT" in plumb(tmp_path, *arguments, status=1).stderr


def test_it_says_what_was_found_and_written(tmp_path: Path) -> None:
    photo(tmp_path / "a.jpg")
    done = plumb(tmp_path, "correct", "a.jpg", *PTLENS)
    assert done.stdout.startswith("Wrote a_corrected.jpg, used: ")
    assert "b = −0.05" in done.stdout
    assert (tmp_path / "a_corrected.jpg").exists()
    assert plumb(tmp_path, "correct", "a.jpg", *PTLENS, "-q").stdout == ""


@pytest.mark.parametrize(
    ("arguments", "target"),
    [
        (("--suffix", "_ptr"), "a_ptr.jpg"),
        (("-o", "b.png"), "b.png"),
        (("-o", "new/"), "new/a.jpg"),
        (("-o", "new", "--suffix", "_x"), "new/a_x.jpg"),
    ],
)
def test_names_of_results(tmp_path: Path, arguments: tuple[str, ...], target: str) -> None:
    photo(tmp_path / "a.jpg")
    plumb(tmp_path, "correct", "a.jpg", *PTLENS, *arguments)
    assert (tmp_path / target).exists()


def test_many_photographs_one_of_them_bad(tmp_path: Path) -> None:
    (tmp_path / "in" / "sub").mkdir(parents=True)
    for seed, name in enumerate(("a.jpg", "b.jpg", "sub/c.jpg")):
        photo(tmp_path / "in" / name, seed)
    (tmp_path / "in" / "bad.jpg").write_bytes(b"nonsense")
    for jobs in ("1", "2"):
        out = f"out{jobs}"
        done = plumb(tmp_path, "correct", "in", *PTLENS, "-o", out, "--jobs", jobs, status=1)
        assert "Corrected 3 photos, 1 failed: in/bad.jpg." in done.stdout
        assert "Error: in/bad.jpg: this is not a picture that can be read." in done.stderr
        written = {
            str(path.relative_to(tmp_path / out)) for path in (tmp_path / out).rglob("*.jpg")
        }
        assert written == {"a.jpg", "b.jpg", "sub/c.jpg"}
    (tmp_path / "in" / "bad.jpg").unlink()
    done = plumb(tmp_path, "correct", "in", *PTLENS, "-o", "out1", "--skip-existing")
    assert "Corrected 0 photos, skipped 3 done before." in done.stdout


def test_a_lens_file_that_is_not_there_is_told_once(tmp_path: Path) -> None:
    for seed in range(3):
        photo(tmp_path / f"{seed}.jpg", seed)
    done = plumb(tmp_path, "correct", ".", "--lens", "no.json", status=1)
    assert done.stderr.count("no.json: there is no such file") == 1
    assert len(list(tmp_path.iterdir())) == 3


def test_a_dask_scheduler_does_it(tmp_path: Path) -> None:
    """Two worker processes that have another working folder, over the loopback."""
    distributed = pytest.importorskip(
        "distributed", reason="Dask is not installed, so there is no cluster to try"
    )
    names = ("a.jpg", "b.jpg", "c.jpg", "bad.jpg")
    for seed, name in enumerate(names):
        photo(tmp_path / name, seed)
    (tmp_path / "bad.jpg").write_bytes(b"nonsense")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, host="127.0.0.1",
        dashboard_address="127.0.0.1:0",
    ) as cluster:  # fmt: skip
        address = cluster.scheduler_address
        assert address.startswith("tcp://127.0.0.1:")
        done = plumb(tmp_path, "correct", *names, *PTLENS, "--scheduler", address, status=1)
    assert f"Corrected 3 photos, 1 failed: {tmp_path / 'bad.jpg'}." in done.stdout
    assert f"Error: {tmp_path / 'bad.jpg'}: this is not a picture that can be read." in done.stderr
    plumb(tmp_path, "correct", "a.jpg", *PTLENS, "-o", "here.jpg")
    made = (tmp_path / "a_corrected.jpg").read_bytes()
    assert made == (tmp_path / "here.jpg").read_bytes()
    for name in ("b_corrected.jpg", "c_corrected.jpg"):
        assert (tmp_path / name).exists()


def test_a_scheduler_that_is_not_there(tmp_path: Path) -> None:
    pytest.importorskip("distributed", reason="Dask is not installed")
    photo(tmp_path / "a.jpg")
    arguments = ("correct", "a.jpg", *PTLENS, "--scheduler", "tcp://127.0.0.1:1")
    assert "does not answer" in plumb(tmp_path, *arguments, status=1).stderr


_PICKS = [(i, x, y) for i in (0, 1) for y in (120, 280) for x in (120, 220, 350)]


def _rows(path: Path) -> tuple[list[str], Array]:
    header, *rows = list(csv.reader(path.read_text().splitlines()))
    assert header == ["line", "x", "y"]
    return [row[0] for row in rows], np.array([[float(v) for v in row[1:]] for row in rows])


def test_points_instead_of_pixels_and_back(tmp_path: Path) -> None:
    ideal = grid_inside(SIZE, 6, 4, 50)
    observed = TRUTH.distort(ideal)
    lines = ["line,x,y", *(f"{i // 6},{x!r},{y!r}" for i, (x, y) in enumerate(observed.tolist()))]
    (tmp_path / "picks.csv").write_text("\n".join(lines))
    plumb(tmp_path, "correct", "--points", "picks.csv", "--size", "600x400", *PTLENS)
    labels, found = _rows(tmp_path / "picks_corrected.csv")
    assert labels == [str(i // 6) for i in range(24)]
    assert np.max(np.abs(found - ideal)) < 1e-9
    plumb(
        tmp_path, "correct", "--points", "picks_corrected.csv", "--inverse", *PTLENS,
        "--size", "600x400", "-o", "back.csv",
    )  # fmt: skip
    assert np.max(np.abs(_rows(tmp_path / "back.csv")[1] - observed)) < 1e-9
    photo(tmp_path / "a.jpg")
    plumb(tmp_path, "correct", "a.jpg", "--points", "picks.csv", *PTLENS, "-o", "again.csv")
    assert np.array_equal(_rows(tmp_path / "again.csv")[1], found)
    done = plumb(tmp_path, "correct", "--points", "picks.csv", *PTLENS, status=1)
    assert "--size WIDTHxHEIGHT" in done.stderr


def test_points_at_the_edge_go_and_come_back(tmp_path: Path) -> None:
    edge = "line,x,y\n" + "".join(f"top,{x},{y}\n" for x, y in ((0, 0), (300, 1), (599, 0)))
    (tmp_path / "edge.csv").write_text(edge + "short,5,5\nshort,5,5\none,7,7\n")
    frame = (*PTLENS, "--size", "600x400")
    plumb(tmp_path, "correct", "--points", "edge.csv", *frame)
    labels, found = _rows(tmp_path / "edge_corrected.csv")
    assert found.min() < -1
    assert labels == ["top"] * 3 + ["short"] * 2 + ["one"]  # points need no lines
    plumb(tmp_path, "correct", "--points", "edge_corrected.csv", "--inverse", *frame, "-o", "b.csv")
    expected = [(0, 0), (300, 1), (599, 0), (5, 5), (5, 5), (7, 7)]
    assert np.max(np.abs(_rows(tmp_path / "b.csv")[1] - expected)) < 1e-9


def test_rows_come_out_in_the_order_in_which_they_came(tmp_path: Path) -> None:
    rows = [
        ("a", 40, 60),
        ("b", 300, 90),
        ("a", 50, 61),
        ("#c", 99, 98),
        ("b", 310, 91),
        ("a", 7, 8),
    ]
    table = "".join(f'{x},"{label}",{y}\n' for label, x, y in rows)
    (tmp_path / "mixed.csv").write_text("x,line,y\n" + table)
    plumb(tmp_path, "correct", "--points", "mixed.csv", *PTLENS, "--size", "600x400")
    labels, found = _rows(tmp_path / "mixed_corrected.csv")
    assert labels == [label for label, _, _ in rows]
    assert np.max(np.abs(found - TRUTH.undistort([[x, y] for _, x, y in rows]))) < 1e-9


def test_corrected_points_leave_the_old_lenses_behind(tmp_path: Path) -> None:
    image = 'i w600 h400 f0 v50 Ra0 a0.01 b-0.05 c0.02 d3 e0 n"{}.jpg"\n'
    lines = (f"c n{i} N{i} x{x} y{y} X{x + 90} Y{y} t{3 + y // 50}\n" for i, x, y in _PICKS)
    (tmp_path / "two.pto").write_text(image.format("a") + image.format("b") + "".join(lines))
    arguments = ("correct", "--points", "two.pto", *PTLENS)
    for name in ("new.pto", "new.csv"):
        plumb(tmp_path, *arguments, "-o", name)
    for lens in plumbline.read(tmp_path / "new.pto").lenses:
        assert not any(lens.stored.get(each) for each in "abcde")
        assert lens.hfov_deg is None
    assert (tmp_path / "new.csv").read_text().startswith("line,x,y,photo\n")


def test_the_map_as_a_file(tmp_path: Path) -> None:
    photo(tmp_path / "a.jpg")
    for name in ("map.tif", "map.npz"):
        plumb(tmp_path, "correct", "a.jpg", *PTLENS, "--map", name)
    assert not (tmp_path / "a_corrected.jpg").exists()
    x, y = np.meshgrid(np.arange(SIZE[0]), np.arange(SIZE[1]))
    expected = TRUTH.distort(np.stack((x, y), axis=-1).astype(float))
    observed = np.load(tmp_path / "map.npz")["observed_px"]
    assert np.max(np.abs(observed - expected)) < 0.01
    stmap: Any = cv2.imread(str(tmp_path / "map.tif"), cv2.IMREAD_UNCHANGED)
    assert stmap.dtype == np.float32
    red, green = stmap[..., 2] * SIZE[0] - 0.5, (1 - stmap[..., 1]) * SIZE[1] - 0.5
    assert np.max(np.abs(np.stack((red, green), axis=-1) - expected)) < 0.01
    assert not stmap[..., 0].any()


@pytest.mark.parametrize("name", ["map.tif", "map.npz"])
def test_a_map_is_plumbline_s_own_and_is_written_again(tmp_path: Path, name: str) -> None:
    photo(tmp_path / "a.jpg")
    (tmp_path / name).write_bytes(b"mine")
    arguments = ("correct", "a.jpg", *PTLENS, "--map", name)
    assert "not written by plumbline" in plumb(tmp_path, *arguments, status=1).stderr
    assert (tmp_path / name).read_bytes() == b"mine"
    plumb(tmp_path, *arguments, "--overwrite")
    first = (tmp_path / name).read_bytes()
    plumb(tmp_path, "correct", "a.jpg", "--ptlens", "b=-0.02", "--map", name)
    assert (tmp_path / name).read_bytes() != first


def test_pixels_the_other_way(tmp_path: Path) -> None:
    ideal = grid_inside(SIZE, 6, 4, 60)
    Image.fromarray(np.rint(dots(SIZE, ideal) * 250).astype(np.uint8)).save(tmp_path / "a.png")
    plumb(tmp_path, "correct", "a.png", *PTLENS, "--inverse")
    found = centroids(np.asarray(Image.open(tmp_path / "a_corrected.png")), TRUTH.distort(ideal))
    assert np.max(np.hypot(*(found - TRUTH.distort(ideal)).T)) < 0.05


@pytest.mark.parametrize(
    ("arguments", "status", "sentence"),
    [
        (("correct", *PTLENS), 2, "name a photo"),
        (("correct", "a.jpg", "b.jpg", *PTLENS, "--map", "m.tif"), 1, "one photo"),
        (("correct", "a.jpg", *PTLENS, "--map", "m.png"), 1, "cannot be written as .png"),
        (("correct", "a.jpg", *PTLENS, "--size", "5x5"), 1, "--points"),
        (("correct", "a.jpg", *PTLENS, "-o", "a.jpg"), 1, "never overwritten"),
        (
            ("correct", "--points", "p.csv", "--size", "9x9", *PTLENS, "--suffix", "x/y"),
            1,
            "the suffix 'x/y' cannot be part of a file name",
        ),
        (("correct", "a.jpg", *PTLENS, "-o", "no/b.jpg"), 1, "folder does not exist"),
        (("correct", "a.jpg", *PTLENS, "--border", "transparent"), 1, "cannot be transparent"),
        (("correct", "missing.jpg", *PTLENS), 1, "no such photo"),
        (("correct", "a.jpg", *PTLENS, "--quality", "101"), 2, "--quality"),
        (("correct", "a.jpg", "--ptlens", "file"), 2, "--ptlens"),
        *(
            (("correct", *POINTS, *PTLENS, *useless), 2, f"--points does not use {useless[0]};")
            for useless in (
                *(("--scale", "keep"), ("--border", "white"), ("--difference",), ("--jobs", "2")),
                *(("--quality", "95"), ("--interpolation", "cubic"), ("--skip-existing",)),
            )
        ),
        *(
            (("correct", "a.jpg", *MAP, *PTLENS, *useless), 2, f"--map does not use {useless[0]}")
            for useless in (("-o", "x.tif"), ("--border", "edge"), ("--difference",))
        ),
        (
            ("correct", "a.jpg", *PTLENS, "--scheduler", "tcp://127.0.0.1:1", "--jobs", "2"),
            2,
            "--scheduler does not use --jobs",
        ),
        (
            ("correct", *POINTS, *PTLENS, "-o", "b.csv", "--suffix", "_x"),
            2,
            "--points with -o does not use --suffix",
        ),
        (
            ("correct", "a.jpg", *PTLENS, "-o", "b.jpg", "--suffix", "_x"),
            1,
            "the suffix _x does not belong in it",
        ),
        *(
            (("correct", "a.jpg", *PTLENS, name, "x"), 2, f"leave out {name}")
            for name in ("--camera", "--lens", "--lens-name", "--like")
        ),
        (("correct", "a.jpg", *PTLENS, "--focal", "9"), 2, "leave out --focal"),
        (("correct", "a.jpg", "--ptlens", "b=5"), 1, "hardly anything of the photo remains"),
    ],
)
def test_refusals(tmp_path: Path, arguments: tuple[str, ...], status: int, sentence: str) -> None:
    photo(tmp_path / "a.jpg")
    before = (tmp_path / "a.jpg").read_bytes()
    assert sentence in plumb(tmp_path, *arguments, status=status).stderr
    assert [path.name for path in tmp_path.iterdir()] == ["a.jpg"]
    assert (tmp_path / "a.jpg").read_bytes() == before


def test_only_what_is_used_is_imported(tmp_path: Path) -> None:
    photo(tmp_path / "a.jpg")
    script = (
        "import sys\nfrom plumbline.cli import command\n"
        f"command(['correct', 'a.jpg', {', '.join(map(repr, PTLENS))}], standalone_mode=False)\n"
        "bad = {'jax', 'matplotlib', 'lxml', 'lensfunpy', 'plumbline.formats.points.csv'}\n"
        "bad &= set(sys.modules)\n"
        "assert not bad, bad\n"
    )
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    subprocess.run([sys.executable, "-c", script], cwd=tmp_path, env=environment, check=True)
    assert (tmp_path / "a_corrected.jpg").exists()


def _rms_px(lines: dict[str, list[Array]]) -> float:
    """Root mean square distance of points from their total least-squares lines."""
    squares: list[Array] = []
    for points in lines.values():
        away = np.array(points) - np.mean(points, axis=0)
        squares.append((away @ np.linalg.svd(away)[2][1]) ** 2)
    return float(np.sqrt(np.mean(np.concatenate(squares))))


def test_the_worked_example_has_straight_joints(tmp_path: Path) -> None:
    if not OLYMPUS.exists():
        pytest.skip("the worked example's photograph is not here")
    for name in ("building.pto", "olympus_c250l_9.2mm.JPG"):
        shutil.copy(OLYMPUS / name, tmp_path)
    plumb(tmp_path, "fit", "building.pto", "-o", "result.json")
    plumb(tmp_path, "correct", "--points", "building.pto", "--lens", "result.json")
    rms: list[float] = []
    for points in ("building.pto", "building_corrected.csv"):
        if points.endswith(".csv"):
            labels, found = _rows(tmp_path / points)
        else:
            observations = plumbline.read(tmp_path / points)
            labels = [line.label for line in observations.lines for _ in line.points_px]
            found = np.concatenate([line.points_px for line in observations.lines])
        lines: dict[str, list[Array]] = {}
        for label, point in zip(labels, found, strict=True):
            lines.setdefault(label, []).append(point)
        rms.append(_rms_px(lines))
    assert abs(rms[0] - 2.870) < 0.001
    assert rms[1] < 0.405
    done = plumb(tmp_path, "correct", "olympus_c250l_9.2mm.JPG", "--lens", "result.json")
    assert "ptlens" in done.stdout
    assert json.loads((tmp_path / "result.json").read_text())["model"] == "ptlens"
    with (
        Image.open(tmp_path / "olympus_c250l_9.2mm.JPG") as before,
        Image.open(tmp_path / "olympus_c250l_9.2mm_corrected.JPG") as after,
    ):
        assert after.size == before.size


def test_a_fold_is_told(tmp_path: Path) -> None:
    """r (1.7 - 0.4 r^2 - 0.3 r^3) is largest at r = 0.855, of half the shorter side."""
    photo(tmp_path / "a.png")
    done = plumb(tmp_path, "correct", "a.png", *FOLDED)
    r = np.linspace(0, 1.5, 100_001)
    fold = r[np.argmax(r * (1.7 - 0.4 * r**2 - 0.3 * r**3))] * SIZE[1] / 2
    told = f"fold {fold - 0.5:.0f} px from the centre"
    assert told in done.stderr
    assert told in plumb(tmp_path, "correct", "a.png", *FOLDED, "--map", "m.npz").stderr
    assert "fold" not in plumb(tmp_path, "correct", "a.png", *PTLENS).stderr


def test_a_corrected_photo_may_be_distorted(tmp_path: Path) -> None:
    photo(tmp_path / "a.jpg")
    plumb(tmp_path, "correct", "a.jpg", *PTLENS, "-o", "b.jpg")
    assert "bends it again" in plumb(tmp_path, "correct", "b.jpg", *PTLENS).stderr
    for more in ((), ("--map", "m.npz")):
        assert plumb(tmp_path, "correct", "b.jpg", *PTLENS, "--inverse", *more).stderr == ""


@pytest.mark.parametrize("inverse", [["--inverse"], []])
def test_points_beyond_the_fold_are_refused_either_way(tmp_path: Path, inverse: list[str]) -> None:
    """r (1 − b + b r²) with b = −0.4 turns back at r = 1.08 half shorter sides."""
    (tmp_path / "p.csv").write_text("line,x,y\na,10,1000\na,1500,1000\na,3000,1000\n")
    fold = ("--ptlens", "a=0,b=-0.4,c=0", "--size", "3001x2001")
    result = plumb(tmp_path, "correct", "--points", "p.csv", *fold, *inverse, status=1)
    assert "folds before it reaches 2 of the points" in result.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == ["p.csv"]


def test_no_line_of_a_decoder_reaches_the_user(tmp_path: Path) -> None:
    """libjpeg, libpng and libtiff print to the process's standard error by themselves."""
    photo(tmp_path / "a.jpg")
    data = (tmp_path / "a.jpg").read_bytes()
    start = data.index(b"\xff\xda")
    (tmp_path / "half.jpg").write_bytes(data[: start + (len(data) - start) // 2] + b"\xff\xd9")
    at = data.index(b"\xff\xd9", start)
    (tmp_path / "extra.jpg").write_bytes(data[:at] + bytes(50) + data[at:])
    photo(tmp_path / "a.tif")
    whole = (tmp_path / "a.tif").read_bytes()
    (tmp_path / "cut.tif").write_bytes(whole[: len(whole) // 2])
    for name in ("half.jpg", "cut.tif"):
        done = plumb(tmp_path, "correct", name, *PTLENS, status=1)
        assert [line[:7] for line in done.stderr.splitlines() if line[:2] != "  "] == ["Error: "]
    done = plumb(tmp_path, "correct", "half.jpg", "extra.jpg", *PTLENS, "--jobs", "2", status=1)
    assert [line[:7] for line in done.stderr.splitlines() if line[:2] != "  "] == ["Error: "]


def test_a_folder_tells_what_it_passes_over(tmp_path: Path) -> None:
    folder = tmp_path / "in"
    folder.mkdir()
    photo(folder / "a.jpg")
    for name in ("a.nef", "b.heic", "c.txt", ".hidden.nef"):
        (folder / name).write_text("x")
    done = plumb(tmp_path, "correct", "in", *PTLENS)
    assert "Passed over 3 other files: " in done.stdout
    assert "1 .heic" in done.stdout
    again = plumb(tmp_path, "correct", "in", *PTLENS)
    assert "Passed over 3 other files: " in again.stdout  # results are not counted

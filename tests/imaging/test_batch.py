"""Many photographs: plans, executors, bad files, dying workers and kills."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import plumbline
from plumbline.errors import OptionError, ReadError
from plumbline.imaging import batch
from plumbline.imaging.batch import Outcome, Work, run_in_processes
from plumbline.imaging.targets import PhotoTarget, photo_targets
from plumbline.lenses.request import LensRequest
from tests.imaging.painted import texture

ROOT = Path(__file__).parents[2]
BARREL = LensRequest(ptlens={"a": 0.0, "b": -0.05, "c": 0.0})


def _photos(folder: Path, *names: str, size: tuple[int, int] = (120, 80)) -> None:
    for seed, name in enumerate(names):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        Image.fromarray(texture(size, seed=seed)).save(folder / name)


def test_folders_are_searched_and_results_left_out(tmp_path: Path) -> None:
    _photos(tmp_path, "a.jpg", "b.PNG", "sub/a.jpg", "sub/a_corrected.jpg", ".hidden.jpg")
    (tmp_path / "notes.txt").write_text("no picture")
    photos = {
        task.photo.relative_to(tmp_path): task.target for task in photo_targets([tmp_path], None)
    }
    assert set(map(str, photos)) == {"a.jpg", "b.PNG", "sub/a.jpg"}
    assert photos[Path("sub/a.jpg")] == tmp_path / "sub" / "a_corrected.jpg"


def test_an_output_folder_keeps_the_tree_and_is_not_searched(tmp_path: Path) -> None:
    _photos(tmp_path, "a.jpg", "sub/a.jpg", "out/sub/old.jpg")
    tasks = photo_targets([tmp_path], tmp_path / "out")
    assert {task.target for task in tasks} == {
        tmp_path / "out" / "a.jpg",
        tmp_path / "out" / "sub" / "a.jpg",
    }
    (task,) = photo_targets([tmp_path / "a.jpg"], "elsewhere/", "_x")
    assert task.target == Path("elsewhere/a_x.jpg")
    (task,) = photo_targets([tmp_path / "a.jpg"], "b.png")
    assert task.target == Path("b.png")


def test_two_differences_do_not_become_one_file(tmp_path: Path) -> None:
    _photos(tmp_path, "a.jpg", "a.png")
    assert len(photo_targets([tmp_path], None)) == 2
    with pytest.raises(OptionError, match=r"would both become .*a_corrected_difference\.png"):
        photo_targets([tmp_path], None, difference=True)


def test_a_photo_with_two_targets_is_written_to_both(tmp_path: Path) -> None:
    _photos(tmp_path, "in/sub/a.jpg")
    tasks = photo_targets([tmp_path / "in", tmp_path / "in" / "sub" / "a.jpg"], tmp_path / "out")
    targets = {tmp_path / "out" / "a.jpg", tmp_path / "out" / "sub" / "a.jpg"}
    assert {task.target for task in tasks} == targets
    done = list(run_in_processes(tasks, Work(BARREL), ThreadPoolExecutor, 2))
    assert {outcome.output for outcome in done} == targets
    again = plumbline.correct_many(
        [tmp_path / "in", tmp_path / "in" / "sub" / "a.jpg"], BARREL, tmp_path / "out"
    )
    assert {outcome.output for outcome in again} == targets


def test_a_result_named_beside_its_original_is_left_out(tmp_path: Path) -> None:
    _photos(tmp_path, "a.jpg", "a_corrected.jpg", "b_corrected.jpg")
    with pytest.raises(OptionError, match=r"a\.jpg would be written over .*a_corrected\.jpg"):
        photo_targets(sorted(tmp_path.glob("*.jpg")), None)
    plumbline.correct(tmp_path / "a.jpg", BARREL, overwrite=True)
    tasks = photo_targets(sorted(tmp_path.glob("*.jpg")), None)
    assert [task.photo.name for task in tasks] == ["a.jpg", "b_corrected.jpg"]


def test_plans_that_make_no_sense(tmp_path: Path) -> None:
    _photos(tmp_path, "x/a.jpg", "y/a.jpg")
    (tmp_path / "empty").mkdir()
    with pytest.raises(OptionError, match="would both become"):
        photo_targets([tmp_path / "x" / "a.jpg", tmp_path / "y" / "a.jpg"], tmp_path / "out")
    with pytest.raises(OptionError, match="one file for 2"):
        photo_targets([tmp_path / "x", tmp_path / "y"], tmp_path / "b.jpg")
    with pytest.raises(ReadError, match="no picture"):
        photo_targets([tmp_path / "empty"], None)
    with pytest.raises(OptionError, match="suffix"):
        photo_targets([tmp_path / "x"], None, "/../b")


def _check(outcomes: list[Outcome], folder: Path) -> None:
    states = {outcome.photo.name: outcome.state for outcome in outcomes}
    assert states == {"a.jpg": "corrected", "bad.jpg": "failed", "c.jpg": "corrected"}
    (bad,) = (outcome for outcome in outcomes if outcome.state == "failed")
    assert "bad.jpg" in bad.error
    assert "cannot be read" in bad.error or "not a picture" in bad.error
    assert bad.hint
    assert [outcome.photo.name for outcome in outcomes] == ["a.jpg", "bad.jpg", "c.jpg"]
    assert (folder / "a_corrected.jpg").exists()
    assert not (folder / "bad_corrected.jpg").exists()


def _three(folder: Path) -> list[Path]:
    _photos(folder, "a.jpg", "c.jpg")
    (folder / "bad.jpg").write_bytes(b"\xff\xd8 nonsense")
    return [folder / "a.jpg", folder / "bad.jpg", folder / "c.jpg"]


@pytest.mark.parametrize("kind", ["none", "threads", "processes"])
def test_one_bad_file_stops_nothing_with_any_executor(tmp_path: Path, kind: str) -> None:
    photos = _three(tmp_path)
    executor: Executor | None = None
    if kind == "threads":
        executor = ThreadPoolExecutor(2)
    elif kind == "processes":
        executor = ProcessPoolExecutor(2, mp_context=get_context("spawn"))
    outcomes = plumbline.correct_many(photos, BARREL, executor=executor)
    if executor is not None:
        executor.shutdown()
    _check(outcomes, tmp_path)
    plain = plumbline.correct(tmp_path / "a.jpg", BARREL, tmp_path / "plain.jpg")
    assert plain.output.read_bytes() == (tmp_path / "a_corrected.jpg").read_bytes()


def test_a_cluster_of_dask_corrects_a_folder(tmp_path: Path) -> None:
    distributed = pytest.importorskip(
        "distributed", reason="Dask is not installed, so there is no cluster to try"
    )
    photos = _three(tmp_path)
    options = {"n_workers": 2, "threads_per_worker": 1, "processes": True, "host": "127.0.0.1"}
    with (
        distributed.LocalCluster(**options, dashboard_address="127.0.0.1:0") as cluster,
        distributed.Client(cluster) as client,
    ):
        executor = client.get_executor(pure=False)
        _check(plumbline.correct_many(photos, BARREL, executor=executor), tmp_path)


def test_existing_results_are_skipped_when_asked(tmp_path: Path) -> None:
    photos = _three(tmp_path)
    plumbline.correct_many(photos, BARREL)
    stamp = (tmp_path / "a_corrected.jpg").stat().st_mtime_ns
    outcomes = plumbline.correct_many(photos, BARREL, skip_existing=True)
    assert [outcome.state for outcome in outcomes] == ["skipped", "failed", "skipped"]
    assert (tmp_path / "a_corrected.jpg").stat().st_mtime_ns == stamp


def _dies_on_bad(task: PhotoTarget, work: Work) -> Outcome:
    if task.photo.name == "bad.jpg":
        os.kill(os.getpid(), signal.SIGKILL)
    return batch.do(task, work)


class _Pool(ProcessPoolExecutor):
    """A pool whose workers die of bad.jpg."""

    def submit(self, fn, /, *args, **kwargs):  # type: ignore[no-untyped-def]
        return super().submit(_dies_on_bad, *args, **kwargs)


def test_a_worker_that_dies_takes_only_its_own_photo_with_it(tmp_path: Path) -> None:
    names = [f"{letter}.jpg" for letter in "abcdefgh"]
    _photos(tmp_path, *names)
    (tmp_path / "b.jpg").rename(tmp_path / "bad.jpg")

    def pool(jobs: int) -> Executor:
        return _Pool(jobs, mp_context=get_context("spawn"))

    outcomes = list(
        run_in_processes(photo_targets([tmp_path], None), Work(BARREL, threads=1), pool, 2)
    )
    failed = [outcome for outcome in outcomes if outcome.state == "failed"]
    assert [outcome.photo.name for outcome in failed] == ["bad.jpg"]
    assert "died" in failed[0].error
    assert len(outcomes) == 8
    assert sum(outcome.state == "corrected" for outcome in outcomes) == 7


def _complete(folder: Path, expected: dict[str, bytes]) -> int:
    """How many results are there; each is whole, and nothing bears a name of its own besides."""
    names = {path.name for path in folder.iterdir() if not path.name.startswith(".plumbline-")}
    assert names <= set(expected)
    for name in names:
        assert (folder / name).read_bytes() == expected[name]
    return len(names)


@pytest.mark.parametrize("jobs", ["1", "2"])
def test_killing_the_process_at_any_moment_leaves_no_partial_result(
    tmp_path: Path, jobs: str
) -> None:
    names = [f"{number}.tif" for number in range(6)]  # large files, which take time to write
    (tmp_path / "in").mkdir()
    _photos(tmp_path / "in", *names, size=(1500, 1000))
    originals = {name: (tmp_path / "in" / name).read_bytes() for name in names}
    command = [sys.executable, "-m", "plumbline", "correct", "in", "-q", "--jobs", jobs]
    command += ["--ptlens", "a=0,b=-0.05,c=0", "-o"]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    subprocess.run([*command, "whole"], cwd=tmp_path, env=environment, check=True)
    expected = {name: (tmp_path / "whole" / name).read_bytes() for name in names}
    out = tmp_path / "out"
    out.mkdir()
    rng = np.random.default_rng()
    found: list[int] = []
    for done in (1, *rng.integers(0, len(names), 5)):  # results that are there when it is killed
        for path in out.iterdir():
            path.unlink(missing_ok=True)
        process = subprocess.Popen([*command, "out"], cwd=tmp_path, env=environment)
        # Whoever looks while it runs sees whole results only.
        while process.poll() is None and _complete(out, expected) < done:
            pass
        process.kill()
        process.wait()
        found.append(_complete(out, expected))
    assert min(found) < len(names), "it was killed too late each time"
    assert _complete(tmp_path / "in", originals) == len(names)
    subprocess.run([*command, "out", "--skip-existing"], cwd=tmp_path, env=environment, check=True)
    assert _complete(out, expected) == len(names)


@pytest.mark.parametrize("moment", ["token_hex", "fsync", "replace"])
def test_dying_while_writing_leaves_no_partial_result(tmp_path: Path, moment: str) -> None:
    _photos(tmp_path, "a.jpg")
    where = {"token_hex": "secrets", "fsync": "os", "replace": "pathlib.Path"}[moment]
    script = (
        "import os, secrets, pathlib, signal, plumbline\n"
        "from plumbline.lenses.request import LensRequest\n"
        "import plumbline.imaging.correct\n"
        "def die(*_, **__): os.kill(os.getpid(), signal.SIGKILL)\n"
        f"{where}.{moment} = die\n"
        "plumbline.correct('a.jpg', LensRequest(ptlens={'a': 0, 'b': -0.05, 'c': 0}))\n"
    )
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=tmp_path, env=environment, check=False
    )
    assert done.returncode == -signal.SIGKILL
    left = {path.name for path in tmp_path.iterdir() if not path.name.startswith(".plumbline-")}
    assert left == {"a.jpg"}

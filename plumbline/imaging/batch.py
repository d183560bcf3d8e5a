"""Many photographs, spread over the workers of any executor; one bad file stops nothing."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path
from typing import Any, Literal

from plumbline.errors import PlumblineError
from plumbline.imaging.correct import Corrected, LensSource, correct_file, looks_for_name
from plumbline.imaging.settings import Settings
from plumbline.imaging.targets import PhotoTarget, photo_targets
from plumbline.photos.exif import read_photo
from plumbline.photos.exiftool import installed, lacks_name, lens_names

_IN_FLIGHT = 128
"""Photographs handed to an executor at a time: chosen, more than any pool has workers."""

_DIED = "the process that corrected it died, perhaps for lack of memory"


@dataclass(frozen=True)
class Outcome:
    """What became of one photograph of many.

    Attributes:
        photo: The original.
        output: The file that was to be written.
        state: "corrected", "skipped" because the output exists already, or "failed".
        corrected: What was done, if it was.
        error: Why it failed, in one sentence.
        hint: The remedy.
    """

    photo: Path
    output: Path
    state: Literal["corrected", "skipped", "failed"]
    corrected: Corrected | None = None
    error: str = ""
    hint: str = ""


@dataclass(frozen=True)
class Work:
    """What every photograph of a batch shares; sent to the workers.

    Attributes:
        lens: The lens, as `correct` takes it.
        settings: How to correct.
        overwrite: Replace files that plumbline did not write.
        skip_existing: Leave out photographs whose output exists.
        threads: Number of threads in each worker; one a core by default.
        lens_names: Names of lenses by exiftool, for photos that do not tell them; each worker
            asks for its own if None.
    """

    lens: LensSource = None
    settings: Settings = field(default_factory=Settings)
    overwrite: bool = False
    skip_existing: bool = False
    threads: int | None = None
    lens_names: Mapping[Path, str] | None = None


def correct_many(
    photos: Iterable[str | Path],
    lens: LensSource = None,
    output: str | Path | None = None,
    *,
    executor: Executor | None = None,
    suffix: str | None = None,
    overwrite: bool = False,
    skip_existing: bool = False,
    **settings: Any,
) -> list[Outcome]:
    """Correct many photographs; a bad one is told of and stops nothing.

    Args:
        photos: Files and folders; folders are searched to any depth.
        lens: As `correct` takes it; each photo's own by EXIF by default.
        output: A folder; beside each photo by default.
        executor: Where to do the work: any `concurrent.futures.Executor`, such as a pool of
            processes or that of a Dask client. One after the other in this process by default.
        suffix: What results bear after their names; `_corrected` by default beside their
            originals, and nothing in an output folder.
        overwrite: Replace files that plumbline did not write.
        skip_existing: Leave out photographs whose output exists.
        **settings: The fields of `Settings`.

    Returns:
        One outcome for each photograph, in their order.

    Raises:
        PlumblineError: the photographs or settings themselves make no sense.
    """
    how = Settings(**settings)
    tasks = photo_targets(list(photos), output, suffix, difference=how.difference)
    work = Work(lens, how, overwrite, skip_existing, threads=1 if executor else None)
    work = with_lens_names(tasks, work)
    outcomes = {each.output: each for each in run(tasks, work, executor)}
    return [outcomes[task.target] for task in tasks]


def with_lens_names(tasks: Sequence[PhotoTarget], work: Work) -> Work:
    """The work with the lenses that photos do not name, asked of exiftool in one process."""
    if not looks_for_name(work.lens) or not installed():
        return work
    unnamed: list[Path] = []
    for task in tasks:
        if work.skip_existing and task.target.exists():
            continue
        try:
            if lacks_name(read_photo(task.photo)):
                unnamed.append(task.photo)
        except PlumblineError:
            continue  # told of when its turn comes
    return replace(work, lens_names=lens_names(unnamed))


def run(tasks: Sequence[PhotoTarget], work: Work, executor: Executor | None) -> Iterator[Outcome]:
    """Outcomes of all tasks, each as soon as it is known.

    A worker that dies takes its pool with it: what was under way then is told of as failed.
    """
    if executor is None:
        yield from (do(task, work) for task in tasks)
        return
    waiting = iter(tasks)
    under_way: dict[Future[Outcome], PhotoTarget] = {}
    try:
        while True:
            for task in islice(waiting, _IN_FLIGHT - len(under_way)):
                try:
                    under_way[executor.submit(do, task, work)] = task
                except BrokenExecutor:
                    yield _failed(task, _DIED)
            if not under_way:
                return
            done, _ = wait(under_way, return_when=FIRST_COMPLETED)
            for future in done:
                yield _result(future, under_way.pop(future))
    finally:
        for future in under_way:
            future.cancel()


def run_in_processes(
    tasks: Sequence[PhotoTarget], work: Work, make_pool: Callable[[int], Executor], jobs: int
) -> Iterator[Outcome]:
    """As `run` in pools of processes; where one dies, the rest goes on in another.

    The photographs that were worked on then are tried again, each in a process of its own.

    Args:
        tasks: The photographs.
        work: What they share.
        make_pool: Makes a pool of that many processes.
        jobs: Number of processes.
    """
    left = {task.target: task for task in tasks}
    while left:
        with make_pool(jobs) as pool:
            for outcome in run(list(left.values()), work, pool):
                if outcome.error == _DIED:
                    break
                del left[outcome.output]
                yield outcome
        for task in list(left.values())[:jobs]:
            with make_pool(1) as pool:
                yield from run([task], work, pool)
            del left[task.target]


def do(task: PhotoTarget, work: Work) -> Outcome:
    """Correct one photograph of a batch; whatever goes wrong becomes its outcome."""
    try:
        if work.skip_existing and task.target.exists():
            return Outcome(task.photo, task.target, "skipped")
        task.target.parent.mkdir(parents=True, exist_ok=True)
        done = correct_file(
            task.photo,
            task.target,
            work.lens,
            work.settings,
            overwrite=work.overwrite,
            threads=work.threads,
            lens_name=None if work.lens_names is None else work.lens_names.get(task.photo, ""),
        )
    except PlumblineError as error:
        return _failed(task, error.message, error.hint)
    except Exception as error:  # a bug in one photograph must not stop the others
        return _failed(task, f"{type(error).__name__}: {error}")
    return Outcome(task.photo, task.target, "corrected", done)


def _result(future: Future[Outcome], task: PhotoTarget) -> Outcome:
    try:
        return future.result()
    except BrokenExecutor:
        return _failed(task, _DIED)
    except Exception as error:  # whatever an executor raises for a task that it lost
        return _failed(task, f"{type(error).__name__}: {error}")


def _failed(task: PhotoTarget, error: str, hint: str = "") -> Outcome:
    return Outcome(task.photo, task.target, "failed", error=error, hint=hint)

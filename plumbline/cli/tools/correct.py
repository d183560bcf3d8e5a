"""`plumbline correct` without its parsing: pictures, points and maps."""

from __future__ import annotations

import sys
from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from plumbline.errors import OptionError, printable
from plumbline.files import read_bytes
from plumbline.imaging.batch import Outcome, Work, run, run_in_processes, with_lens_names
from plumbline.imaging.correct import Corrected, correct_file, correction_for
from plumbline.imaging.quiet import libraries_silenced
from plumbline.imaging.resample import cores
from plumbline.imaging.settings import Settings
from plumbline.imaging.targets import SUFFIX, PhotoTarget, passed_over, photo_targets, refuse_suffix
from plumbline.lenses.request import LensRequest
from plumbline.wording import count, listed

_SETTINGS = ("interpolation", "scale", "border", "quality", "inverse", "difference")


def pictures(sources: Sequence[str], request: LensRequest, how: Mapping[str, Any]) -> None:
    """Correct photographs, and say what was done; status 1 if one of them failed."""
    with libraries_silenced():
        _pictures(sources, request, how)


def _pictures(sources: Sequence[str], request: LensRequest, how: Mapping[str, Any]) -> None:
    if how["scheduler"] and request.source:  # workers have a working folder of their own
        request = replace(request, source=str(Path(request.source).absolute()))
    settings = Settings(**{name: how[name] for name in _SETTINGS})
    tasks = photo_targets(sources, how["output"], how["suffix"], difference=settings.difference)
    single = len(sources) == len(tasks) == 1 and not Path(sources[0]).is_dir()
    here = single and not how["scheduler"]
    if here and not (how["skip_existing"] and tasks[0].target.exists()):
        _make_folder(tasks[0], how["output"])
        done = correct_file(
            tasks[0].photo, tasks[0].target, request, settings, overwrite=how["overwrite"]
        )
        _tell(done, quiet=how["quiet"])
        return
    if request.source is not None and not Path(request.source).is_dir():
        read_bytes(request.source)  # what is wrong with it is told once, not for every photo
    work = Work(request, settings, how["overwrite"], how["skip_existing"])
    failed = _many(tasks, with_lens_names(tasks, work), how)
    over = passed_over(sources, how["output"], how["suffix"])
    if over and not how["quiet"]:
        kinds = listed([f"{number:,} {kind}" for kind, number in over.items()])
        click.echo(f"Passed over {count(sum(over.values()), 'other file')}: {kinds}.")
    if failed:
        sys.exit(1)


def _make_folder(task: PhotoTarget, output: str | None) -> None:
    """Make the folder that -o names, but not the one that a file is to lie in."""
    if output is not None and task.target != Path(output):
        try:
            task.target.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise OptionError(
                f"the folder {output} cannot be created: {error.strerror}", hint="choose another -o"
            ) from None


def _tell(done: Corrected, *, quiet: bool) -> None:
    for note in done.notes:
        click.echo(f"Note: {printable(str(done.photo))}: {printable(note)}.", err=True)
    if quiet:
        return
    for path in filter(None, (done.output, done.difference)):
        click.echo(f"Wrote {printable(str(path))}, used: {printable(done.description)}")


def _many(tasks: Sequence[PhotoTarget], work: Work, how: Mapping[str, Any]) -> list[Outcome]:
    """Correct a batch under a progress bar; the photographs that failed."""
    outcomes: list[Outcome] = []
    with _workers(tasks, work, how) as results:
        for outcome in _with_progress(results, len(tasks)):
            outcomes.append(outcome)
            if outcome.corrected is not None:
                _tell(outcome.corrected, quiet=how["quiet"])
            elif outcome.state == "failed":
                _tell_failure(outcome)
    failed = [outcome for outcome in outcomes if outcome.state == "failed"]
    skipped = sum(outcome.state == "skipped" for outcome in outcomes)
    sentence = f"Corrected {count(len(outcomes) - len(failed) - skipped, 'photo')}"
    if skipped:
        sentence += f", skipped {skipped:,} done before"
    if failed:
        names = listed([printable(str(outcome.photo)) for outcome in failed])
        sentence += f", {len(failed):,} failed: {names}"
    click.echo(sentence + ".")
    return failed


def _tell_failure(outcome: Outcome) -> None:
    name = str(outcome.photo)
    message = outcome.error if name in outcome.error else f"{name}: {outcome.error}"
    click.secho(f"Error: {printable(message)}.", fg="red", err=True)
    if outcome.hint:
        click.echo(f"  {printable(outcome.hint)}.", err=True)


@contextmanager
def _workers(
    tasks: Sequence[PhotoTarget], work: Work, how: Mapping[str, Any]
) -> Generator[Iterable[Outcome]]:
    """The outcomes, from a cluster, from processes, or from this process."""
    if how["scheduler"]:
        from plumbline.imaging.workers import dask_client

        with dask_client(how["scheduler"]) as client:
            absolute = [
                PhotoTarget(task.photo.absolute(), task.target.absolute()) for task in tasks
            ]
            pool = client.get_executor(pure=False)
            yield run(absolute, replace(work, threads=1), pool)
        return
    jobs = min(how["jobs"] or cores(), len(tasks))
    if jobs <= 1:
        yield run(tasks, work, None)
    else:
        from plumbline.imaging.workers import processes

        yield run_in_processes(tasks, replace(work, threads=1), processes, jobs)


def _with_progress(results: Iterable[Outcome], total: int) -> Iterator[Outcome]:
    """Pass results through, moving a bar on the terminal."""
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        ProgressColumn,
        Task as Shown,
        TextColumn,
        TimeRemainingColumn,
    )
    from rich.text import Text

    class Rate(ProgressColumn):
        """Photographs a second."""

        def render(self, task: Shown) -> Text:
            return Text(f"{task.finished_speed or task.speed or 0:.2f}/s")

    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), Rate())
    with Progress(
        *columns,
        TimeRemainingColumn(),
        console=console,
        disable=not console.is_terminal,
        redirect_stdout=sys.stdout.isatty(),
    ) as progress:
        bar = progress.add_task("Correcting", total=total)
        for result in results:
            progress.advance(bar)
            yield result


def points(
    path: str,
    photo: str | None,
    size: tuple[int, int] | None,
    request: LensRequest,
    how: Mapping[str, Any],
) -> None:
    """Correct picked points into a CSV."""
    from plumbline.imaging.points import correct_points, read_points
    from plumbline.writing.results import write_points

    suffix = how["suffix"] or ("_distorted" if how["inverse"] else SUFFIX)
    refuse_suffix(suffix)
    inverse: bool = how["inverse"]
    observations = read_points(path, photo, size, inverse=inverse)
    moved, found = correct_points(observations, request, photo=photo, inverse=inverse)
    notes = (*observations.notes, *(note for each in found for note in each.notes))
    for note in dict.fromkeys(notes):
        click.echo(f"Note: {printable(note)}.", err=True)
    target = how["output"] or Path(path).with_name(f"{Path(path).stem}{suffix}.csv")
    written = write_points(moved, target, overwrite=how["overwrite"])
    used = "; ".join(dict.fromkeys(each.description for each in found))
    if not how["quiet"]:
        click.echo(f"Wrote {printable(str(written))}, used: {printable(used)}")


def sampling_map(photo: str, target: str, request: LensRequest, how: Mapping[str, Any]) -> None:
    """Write the sampling map of one photograph."""
    from plumbline.files import refuse_to_clobber, write_atomically
    from plumbline.imaging.maps.mapfile import map_bytes
    from plumbline.photos.exif import read_photo

    refuse_to_clobber(Path(target), [photo], overwrite=how["overwrite"])
    facts = read_photo(photo)
    found = correction_for(facts.taken_as_corrected() if how["inverse"] else facts, request)
    content, notes = map_bytes(found, target, scale=how["scale"], inverse=how["inverse"])
    write_atomically({Path(target): content})
    for note in (*found.notes, *notes):
        click.echo(f"Note: {printable(note)}.", err=True)
    if not how["quiet"]:
        click.echo(f"Wrote {printable(target)}, used: {printable(found.description)}")

"""Progress on long work, and whose fault an error is."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, contextmanager
from typing import TYPE_CHECKING

import click

from plumbline.errors import PlumblineError, printable
from plumbline.wording import listed

if TYPE_CHECKING:
    from collections.abc import Generator

    from rich.console import Console

    from plumbline.observations import Observations


def progress_bar(
    narration: Console, what: str, total: int
) -> AbstractContextManager[Callable[[int], object]]:
    """A bar on a terminal, nothing elsewhere; yields what advances it by some steps."""
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeRemainingColumn as Remaining,
    )

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), Remaining())

    @contextmanager
    def running() -> Generator[Callable[[int], object]]:
        hidden = not narration.is_terminal
        with Progress(*columns, console=narration, transient=True, disable=hidden) as progress:
            task = progress.add_task(what, total=total)
            yield lambda steps: progress.advance(task, steps)

    return running()


@contextmanager
def named(part: Observations, n_parts: int) -> Generator[None]:
    """Say in errors raised inside which files and photos they are about."""
    try:
        yield
    except PlumblineError as error:
        raise name_the_source(error, part, n_parts) from None


def name_the_source(error: PlumblineError, part: Observations, n_parts: int) -> PlumblineError:
    """Say which files an error is about, and which photos where a project has several lenses."""
    message = error.message
    if n_parts > 1:
        names = [f"{photo.number} {photo.name}".strip() for photo in part.photos]
        message = f"photo {listed(names)}: {message}"
    files = listed(list(dict.fromkeys(origin.path for origin in part.origins)), 3)
    if not message.startswith(files):
        message = f"{files}: {message}"
    told = type(error).__new__(type(error))  # `copy` may share the attributes once Dask is loaded
    told.__dict__.update(error.__dict__)
    told.message, told.args = message, (message,)
    return told


def tell_notes(parts: Sequence[Observations]) -> None:
    """Print what reading assumed, left aside or counted once."""
    for note in dict.fromkeys(note for part in parts for note in part.notes):
        click.echo(f"Note: {printable(note)}.", err=True)

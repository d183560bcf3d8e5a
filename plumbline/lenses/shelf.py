"""The user's own calibrations listed, and deleted."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from plumbline.errors import OptionError, ReadError, UnsettledError, WriteError
from plumbline.lenses import store
from plumbline.observations.facts import LensFacts
from plumbline.wording import listed


@dataclass(frozen=True)
class Kept:
    """One of the user's own calibrations.

    Attributes:
        path: Its file.
        facts: What it says of camera and lens.
        range_mm: Shortest and longest focal length.
        error: Why it cannot be used; else empty.
    """

    path: Path
    facts: LensFacts = field(default_factory=LensFacts)
    range_mm: tuple[float, float] = (0.0, 0.0)
    error: str = ""


def kept() -> tuple[Kept, ...]:
    """All of the user's own calibrations, in the order of their names."""
    found: list[Kept] = []
    for path in store.files():
        try:
            _, facts, range_mm = store.read_kept(path)
        except (ReadError, UnsettledError) as error:
            found.append(Kept(path, error=error.message))
        else:
            found.append(Kept(path, facts, range_mm))
    return tuple(found)


def remove(name: str) -> Path:
    """Delete one of the user's own calibrations.

    Args:
        name: Name of its file, with or without `.json`.

    Returns:
        The file that was deleted.

    Raises:
        OptionError: there is none of that name.
        WriteError: it cannot be deleted.
    """
    files = {path.name: path for path in store.files()}
    path = files.get(name) or files.get(f"{name}.json")
    if path is None:
        known = f"there are: {listed(sorted(files))}" if files else "there are none"
        raise OptionError(
            f"you have no calibration of your own named {name}",
            hint=f"{known}; plumbline lens list shows them",
        )
    try:
        path.unlink()
    except OSError as error:
        raise WriteError(
            f"the file cannot be deleted: {error.strerror or error}",
            path=path,
            hint="make its folder writable",
        ) from None
    return path

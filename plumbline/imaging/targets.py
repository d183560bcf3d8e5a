"""Which files to correct, where each result goes, and what must not be written over."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from plumbline.errors import OptionError, ReadError, WriteError
from plumbline.files import refuse_to_clobber
from plumbline.photos.files.metadata import CORRECTED

SUFFIX = "_corrected"
DIFFERENCE = "_difference"

_PICTURES = frozenset((".jpg", ".jpeg", ".jpe", ".tif", ".tiff", ".png", ".webp"))
_LOOKED_AT = 2**18
"""Bytes at either end of a file, where the note of a correction is looked for: chosen because
EXIF, which is first, has at most 64 KiB in JPEG, and WebP has it last."""


@dataclass(frozen=True)
class PhotoTarget:
    """One photograph to correct.

    Attributes:
        photo: The original.
        target: The file to write.
    """

    photo: Path
    target: Path


def beside(path: Path, suffix: str) -> Path:
    """The file's name with something after its stem."""
    return path.with_name(f"{path.stem}{suffix}{path.suffix}")


def difference_of(target: Path) -> Path:
    """The picture of the differences that belongs to a corrected photograph."""
    return beside(target, DIFFERENCE).with_suffix(".png")


def photo_targets(
    sources: Sequence[str | Path],
    output: str | Path | None,
    suffix: str | None = None,
    *,
    difference: bool = False,
) -> list[PhotoTarget]:
    """The photographs that files and folders name, each with its target.

    Folders are searched to any depth; hidden files, and results of an earlier run, which bear
    the suffix, are left out; so is a named file that is the result of another one. Photographs
    of a folder keep their places below an output folder.

    Args:
        sources: Files and folders.
        output: A folder, or a file where there is one photograph; None writes beside it.
        suffix: What results bear after their names; `_corrected` by default beside their
            originals, and nothing in an output folder.
        difference: Whether pictures of the differences are written too.

    Raises:
        ReadError: a folder cannot be read, or holds no picture.
        OptionError: one output file is named for several photographs, two photographs have the
            same target, or one of them is the target of another.
    """
    refuse_suffix(suffix or "")
    result = SUFFIX if suffix is None else suffix
    found: list[tuple[Path, Path]] = []  # the photo, and its place below an output folder
    for source in map(Path, sources):
        if source.is_dir():
            photos = _pictures(source, result, output)
            found += [(photo, photo.relative_to(source)) for photo in photos]
        else:
            found.append((source, Path(source.name)))
    if output is None:
        tasks = [PhotoTarget(photo, beside(photo, result)) for photo, _ in found]
    elif _is_folder(output):
        tasks = [
            PhotoTarget(photo, Path(output) / beside(place, suffix or "")) for photo, place in found
        ]
    elif suffix is not None:
        raise OptionError(
            f"{output} is a complete file name, and the suffix {suffix} does not belong in it",
            hint="leave out --suffix, or name a folder with -o",
        )
    elif len(found) == 1:
        tasks = [PhotoTarget(found[0][0], Path(output))]
    else:
        raise OptionError(
            f"{output} is one file for {len(found)} photographs", hint="name a folder with -o"
        )
    tasks = list(dict.fromkeys(tasks))
    sources_of = {task.target.absolute(): task.photo for task in tasks}
    results = [t for t in tasks if sources_of.get(t.photo.absolute(), t.photo) != t.photo]
    for photo in (task.photo for task in results):
        if photo.is_file() and not _is_ours(photo):
            raise OptionError(
                f"{sources_of[photo.absolute()]} would be written over {photo}, which is to be "
                "corrected itself",
                hint="choose another --suffix, or name a folder with -o",
            )
    tasks = [task for task in tasks if task not in results]
    _refuse_collisions(tasks, difference=difference)
    return tasks


def passed_over(
    sources: Iterable[str | Path], output: str | Path | None, suffix: str | None = None
) -> dict[str, int]:
    """How many files of folders are not corrected, by the ends of their names.

    Hidden files and results of an earlier run are not counted.

    Args:
        sources: Files and folders, as `photo_targets` takes them.
        output: As `photo_targets` takes it.
        suffix: As `photo_targets` takes it.
    """
    result = SUFFIX if suffix is None else suffix
    kinds: Counter[str] = Counter()
    for folder in filter(Path.is_dir, map(Path, sources)):
        for path in _files(folder, output):
            plain = not path.name.startswith(".") and not _is_result(path, result)
            if plain and path.suffix.lower() not in _PICTURES:
                kinds[path.suffix.lower() or "without suffix"] += 1
    return dict(kinds.most_common())


def refuse_suffix(suffix: str) -> None:
    """Refuse a suffix of results that cannot be part of a file name.

    Raises:
        OptionError: as said.
    """
    if os.sep in suffix or "/" in suffix or "\0" in suffix:
        raise OptionError(
            f"the suffix {suffix!r} cannot be part of a file name", hint="name a folder with -o"
        )


def _is_folder(output: str | Path) -> bool:
    """Whether the user means a folder: there is one, or the name looks like one."""
    return Path(output).is_dir() or str(output).endswith(("/", os.sep)) or not Path(output).suffix


def _pictures(folder: Path, suffix: str, output: str | Path | None) -> list[Path]:
    """Originals below a folder, those in the output folder left out."""
    found = [path for path in _files(folder, output) if _is_original(path, suffix)]
    if not found:
        raise ReadError(
            "this folder holds no pictures",
            path=folder,
            hint="JPEG, TIFF, PNG and WebP are recognised",
        )
    return found


def _files(folder: Path, output: str | Path | None) -> Iterator[Path]:
    """All files below a folder, those in hidden folders and in the output folder left out."""
    results = None if output is None else Path(output).absolute()

    def stop(error: OSError) -> None:
        raise ReadError(
            f"the folder cannot be read: {error.strerror}", path=error.filename or folder
        ) from None

    for place, folders, files in os.walk(folder, onerror=stop):
        folders[:] = sorted(
            name
            for name in folders
            if not name.startswith(".") and Path(place, name).absolute() != results
        )
        yield from (Path(place, name) for name in sorted(files))


def _is_original(path: Path, suffix: str) -> bool:
    hidden = path.name.startswith(".")
    return path.suffix.lower() in _PICTURES and not hidden and not _is_result(path, suffix)


def _is_result(path: Path, suffix: str) -> bool:
    return bool(suffix) and path.stem.endswith((suffix, suffix + DIFFERENCE))


def _refuse_collisions(tasks: Iterable[PhotoTarget], *, difference: bool) -> None:
    taken: dict[Path, Path] = {}
    for task in tasks:
        for target in (task.target, difference_of(task.target))[: 1 + difference]:
            other = taken.setdefault(target.absolute(), task.photo)
            if other != task.photo:
                raise OptionError(
                    f"{other} and {task.photo} would both become {target}",
                    hint="correct one of them into another folder with -o",
                )


def check_target(target: Path, photo: Path, *, overwrite: bool) -> None:
    """Refuse to write over the original, or over a file that plumbline did not write.

    Raises:
        WriteError: as said, or the folder does not exist.
    """
    if not target.parent.is_dir():
        raise WriteError("the folder does not exist", path=target, hint="create it first")
    refuse_to_clobber(target, [str(photo)], overwrite=overwrite, is_ours=_is_ours)


def _is_ours(target: Path) -> bool:
    """Whether the file bears the note that every corrected photograph gets."""
    try:
        with target.open("rb") as file:
            looked_at = file.read(_LOOKED_AT)
            file.seek(max(file.seek(0, os.SEEK_END) - _LOOKED_AT, 0))
            looked_at += file.read(_LOOKED_AT)
    except OSError:
        return False
    return CORRECTED.encode() in looked_at

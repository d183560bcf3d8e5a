"""Files on disk: read whole, written atomically, never lost."""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
import secrets
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from plumbline.errors import OptionError, ReadError, WriteError

MARK = "made by plumbline"
"""Stands in the head of every PTO and XML that plumbline creates, and ends its maps."""

RESULT = "plumbline calibration"
"""Stands in the head of every JSON of calibrations that plumbline makes."""

POINTS = "plumbline points"
"""Stands in the head of every JSON of picked points that plumbline makes."""

_SEAL = re.compile(rb"(made by plumbline \S+) \[([0-9a-f]{16})\]")
"""The mark with a checksum of the file, which tells whether someone edited it since."""

ZOOM = "plumbline zoom"
"""Stands in the head of every JSON of a zoom lens that plumbline makes."""

RECTIFICATION = "plumbline rectification"
"""Stands in the head of every JSON of a rectified photo that plumbline makes."""

FITTED_DECIMALS = 18
"""Digits after the point: more than a double has, so that every value reads back bit for bit."""
FITTED_VALUE = re.compile(rb"^i[ \t][^\n]*[ \t][a-e]-?\d+\.\d{18}(?!\S)", re.MULTILINE)
"""A lens value as plumbline writes it into a project that it otherwise leaves byte for byte.

Hugin writes at most 15 digits, so a project with a longer one was not saved by it since.
"""

_MOST_BYTES = 2**31
"""Chosen, because a file of ten million control points has 0.6 GB."""
_NAME_A_FILE = "name another file"
_MOST_LOOKED_AT = 2**20
"""Of a project, to find its `i` lines: Hugin writes them before all control points, and 1 MiB holds
some thousand."""
_MOST_OF_HEADER = 1024
"""Every file of plumbline bears its mark within this many bytes of its start or its end."""
_MARKED_AT_THE_END = (".tif", ".tiff", ".npz")
_NEW_FILE = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)


def as_path(path: str | Path) -> Path:
    """A path as callers give it.

    Raises:
        OptionError: this is no text and no path.
    """
    try:
        return Path(path)
    except TypeError:
        name = type(path).__name__
        raise OptionError(
            f"a file name expected, not {name}", hint="give a str or a Path"
        ) from None


def read_bytes(path: str | Path) -> bytes:
    """The bytes of a regular file.

    Raises:
        ReadError: it is missing, not a regular file, unreadable or absurdly large.
    """
    file = as_path(path)
    try:
        if file.is_dir():
            raise ReadError("this is a folder, not a file", path=path, hint=_NAME_A_FILE)
        if not file.is_file() and file.exists():
            raise ReadError("this is a pipe or a device, not a file", path=path, hint=_NAME_A_FILE)
        if file.exists() and file.stat().st_size > _MOST_BYTES:
            raise ReadError("the file is larger than 2 GiB", path=path, hint=_NAME_A_FILE)
        return file.read_bytes()
    except FileNotFoundError:
        raise ReadError(
            "there is no such file", path=path, hint="check the name and the folder"
        ) from None
    except PermissionError:
        raise ReadError(
            "reading this file is not permitted", path=path, hint="change its permissions"
        ) from None
    except (OSError, ValueError) as error:
        raise ReadError(
            f"the file cannot be read: {_reason(error)}", path=path, hint=_NAME_A_FILE
        ) from None


def refuse_to_clobber(
    target: Path,
    inputs: Sequence[str],
    *,
    overwrite: bool,
    is_ours: Callable[[Path], bool] | None = None,
) -> None:
    """Refuse to write over an input, or over a file that plumbline did not make.

    Args:
        target: The file to be written.
        inputs: Files that are read.
        overwrite: Replace a file that plumbline did not write.
        is_ours: Whether plumbline wrote a file; by the marks of its text files by default.

    Raises:
        WriteError: as said, or the target is not a regular file.
    """
    try:
        exists = target.exists()
        is_input = exists and any(is_same(target, path) for path in inputs)
        is_file = target.is_file()
    except OSError as error:
        raise _unwritable(target, error) from None
    if is_input:
        raise WriteError(
            "this file is an input, and inputs are never overwritten",
            path=target,
            hint="choose another name with -o",
        )
    if exists and not is_file:
        raise WriteError("this is not a regular file", path=target, hint="name a file with -o")
    if exists and not overwrite and _is_edited(read_bytes(target)):
        raise WriteError(
            "this file was edited since plumbline wrote it, and the edits would be lost",
            path=target,
            hint="choose another name with -o, or replace it with --overwrite",
        )
    if exists and not overwrite and not (is_ours or _is_ours)(target):
        raise WriteError(
            "this file exists and was not written by plumbline",
            path=target,
            hint="choose another name with -o, or replace it with --overwrite",
        )


def refuse_unknown_suffix(target: Path, known: Sequence[str], what: str) -> None:
    """Refuse a file name whose suffix stands for no format.

    Args:
        target: The file.
        known: The suffixes that do, in lower case.
        what: What is to be written, in the plural.

    Raises:
        WriteError: as said.
    """
    suffix = target.suffix.lower()
    if suffix not in known:
        raise WriteError(
            f"{what} are not written as {suffix or 'files without a suffix'}",
            path=target,
            hint=f"use one of {', '.join(known)}",
        )


def is_same(target: Path, path: str) -> bool:
    """Whether two names are of one existing file."""
    try:
        return target.samefile(path)
    except (OSError, ValueError):
        return False


def sealed(content: bytes) -> bytes:
    """A marked text file with its checksum beside the mark.

    Whoever edits the file afterwards, to add vignetting to a profile for instance, breaks the
    seal, and the edited file is not replaced.
    """
    start = content.find(MARK.encode())
    end = start + len(MARK) + 1
    while start >= 0 and end < len(content) and content[end : end + 1] not in b" \t\r\n":
        end += 1
    if start < 0:
        return content
    digest = hashlib.sha256(content).hexdigest()[:16].encode()
    return content[:end] + b" [" + digest + b"]" + content[end:]


def _is_edited(content: bytes) -> bool:
    """Whether a sealed file was changed since."""
    found = _SEAL.search(content[:_MOST_OF_HEADER])
    if found is None:
        return False
    whole = content[: found.end(1)] + content[found.end() :]
    return hashlib.sha256(whole).hexdigest()[:16].encode() != found[2]


def _is_ours(target: Path) -> bool:
    """Whether plumbline wrote the file and no other program saved it since."""
    try:
        with target.open("rb") as file:
            head = file.read(_MOST_LOOKED_AT)
            file.seek(max(file.seek(0, os.SEEK_END) - _MOST_OF_HEADER, 0))
            tail = file.read()
    except OSError:
        return False
    if target.suffix.lower() in _MARKED_AT_THE_END:
        return MARK.encode() in tail
    if target.suffix.lower() == ".json":
        marks = [f'"{name}"'.encode() for name in (RESULT, POINTS, ZOOM, RECTIFICATION)]
        start = head[:_MOST_OF_HEADER]
        return start.lstrip().startswith(b"{") and any(mark in start for mark in marks)
    marked = MARK.encode() in head[:_MOST_OF_HEADER]
    return marked or FITTED_VALUE.search(head) is not None


def write_atomically(contents: Mapping[Path, bytes]) -> None:
    """Write files under temporary names, and move them into place once all are complete.

    Args:
        contents: What each file holds.

    Raises:
        WriteError: a folder is missing or cannot be written, or a file is in use. No file has
            changed then, unless moving into place failed for a later one of several.
    """
    temporary: dict[Path, Path] = {}
    target = Path()
    try:
        for target, content in contents.items():
            path = target.parent / f".plumbline-{secrets.token_hex(8)}"
            handle = os.open(path, _NEW_FILE, 0o666)  # less the umask, as for any new file
            temporary[target] = path
            with os.fdopen(handle, "wb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            if target.exists():
                path.chmod(target.stat().st_mode & 0o777)
        for target in contents:
            temporary[target].replace(target)
            del temporary[target]
    except OSError as error:
        raise _unwritable(target, error) from None
    finally:
        for path in temporary.values():
            with contextlib.suppress(OSError):
                path.unlink()


def _unwritable(target: Path, error: OSError) -> WriteError:
    if isinstance(error, FileNotFoundError) and not target.parent.is_dir():
        return WriteError(
            "the folder does not exist", path=target, hint="make it first, or choose another"
        )
    if isinstance(error, FileNotFoundError):
        return WriteError(
            "the folder takes no new files", path=target, hint="choose another place with -o"
        )
    return WriteError(
        f"the file cannot be written: {_reason(error)}",
        path=target,
        hint="choose another place with -o",
    )


def _reason(error: Exception) -> str:
    return (error.strerror if isinstance(error, OSError) else None) or str(error)

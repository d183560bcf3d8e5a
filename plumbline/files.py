"""Files on disk: read whole, written atomically, never lost."""

from __future__ import annotations

import contextlib
import os
import re
import tempfile
from collections.abc import Sequence
from pathlib import Path

from plumbline.errors import ReadError, WriteError

MARK = "made by plumbline"
"""Stands in the head of every file that plumbline makes from nothing."""

FITTED_DECIMALS = 18
FITTED_VALUE = re.compile(rb"^i [^\n]* [abc]-?\d+\.\d{18}[ \r\n]", re.MULTILINE)
"""A lens value as plumbline writes it into a project that it otherwise leaves byte for byte.

Hugin writes at most 15 digits, so a project with a longer one was not saved by it since.
"""

_MOST_BYTES = 2**31
_MOST_LOOKED_AT = 2**20


def read_bytes(path: str | Path) -> bytes:
    """The bytes of a regular file.

    Raises:
        ReadError: it is missing, no regular file, unreadable or absurdly large.
    """
    file = Path(path)
    try:
        if file.is_dir():
            raise ReadError("this is a folder, not a file", path=path)
        if file.exists() and file.stat().st_size > _MOST_BYTES:
            raise ReadError("the file is larger than 2 GiB", path=path)
        return file.read_bytes()
    except FileNotFoundError:
        raise ReadError("there is no such file", path=path) from None
    except PermissionError:
        raise ReadError("reading this file is not permitted", path=path) from None
    except (OSError, ValueError) as error:
        raise ReadError(f"the file cannot be read: {error}", path=path) from None


def refuse_to_clobber(target: Path, inputs: Sequence[str], *, overwrite: bool) -> None:
    """Refuse to write over an input, or over a file that plumbline did not make.

    Raises:
        WriteError: as said, or the target is no regular file.
    """
    with contextlib.suppress(OSError):
        for path in inputs:
            if target.exists() and Path(path).exists() and target.samefile(path):
                raise WriteError(
                    "this is the file the points come from, and is never overwritten",
                    path=target,
                    hint="choose another name with -o",
                )
    if target.is_dir():
        raise WriteError("this is a folder", path=target, hint="name a file with -o")
    if target.exists() and not overwrite and not _is_ours(target):
        raise WriteError(
            "this file exists and was not written by plumbline",
            path=target,
            hint="choose another name with -o, or replace it with --overwrite",
        )


def _is_ours(target: Path) -> bool:
    """Whether plumbline wrote the file and no other program saved it since."""
    try:
        with target.open("rb") as file:
            head = file.read(_MOST_LOOKED_AT)
    except OSError:
        return False
    return MARK.encode() in head or FITTED_VALUE.search(head) is not None


def write_atomically(target: Path, content: bytes) -> None:
    """Write a file under a temporary name and move it into place.

    Raises:
        WriteError: the folder is missing or cannot be written.
    """
    temporary: str | None = None
    try:
        mode = target.stat().st_mode & 0o777 if target.exists() else 0o666 & ~_umask()
        handle, temporary = tempfile.mkstemp(prefix=f".{target.name}.", dir=target.parent)
        with os.fdopen(handle, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        Path(temporary).chmod(mode)
        Path(temporary).replace(target)
        temporary = None
    except FileNotFoundError:
        raise WriteError(
            "the folder does not exist", path=target, hint="make it first, or choose another"
        ) from None
    except OSError as error:
        reason = error.strerror or str(error)
        raise WriteError(
            f"the file cannot be written: {reason}",
            path=target,
            hint="choose another place with -o",
        ) from None
    finally:
        if temporary is not None:
            with contextlib.suppress(OSError):
                Path(temporary).unlink()


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask

"""Keep a document on disk: every action at once and atomically, one program at a time."""

from __future__ import annotations

import hashlib
import os
import tempfile
from pathlib import Path
from typing import IO

import msgspec

from plumbline.errors import ReadError, WriteError
from plumbline.files import read_bytes, write_atomically
from plumbline.pick.document import FORMAT, Document

SUFFIX = ".plumbline.json"
_MOST_LOOKED_AT = 200
"""Bytes in which the format's name stands: it is the first entry."""


def picks_beside(photo: str | Path) -> Path:
    """Where the picks of a photo are kept: `facade.plumbline.json` beside `facade.jpg`."""
    path = Path(photo)
    return path.with_name(path.stem + SUFFIX)


class Keeper:
    """Reads and writes one file of picks, and holds its lock.

    Args:
        path: The file.

    Raises:
        WriteError: another program holds the lock.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._stamp: tuple[int, int, int] | None = None
        self._lock = _locked(path)

    def close(self) -> None:
        """Give the lock back."""
        self._lock.close()

    def read(self) -> Document | None:
        """The document on disk; None if there is none yet.

        Raises:
            ReadError: the file is another one, or damaged.
        """
        if not self.path.exists():
            return None
        content = read_bytes(self.path)
        self._stamp = self._stamp_now()
        hint = "move it away to begin anew"
        if FORMAT.encode() not in content[:_MOST_LOOKED_AT]:
            raise ReadError("this is not a file of picks", path=self.path, hint=hint)
        try:
            document = msgspec.json.decode(content, type=Document)
        except (msgspec.MsgspecError, RecursionError, UnicodeDecodeError) as error:
            raise ReadError(
                f"the file of picks is damaged: {error}", path=self.path, hint=hint
            ) from None
        if wrong := document.problem():
            raise ReadError(f"the file of picks is damaged: {wrong}", path=self.path, hint=hint)
        return document

    def write(self, document: Document) -> None:
        """Save a document.

        Raises:
            WriteError: the file cannot be written, or another program changed it meanwhile.
        """
        now = self._stamp_now()
        if now is not None and now != self._stamp:
            raise WriteError(
                "another program changed this file",
                path=self.path,
                hint="move that file away; the picks on this page are then saved again",
            )
        content = msgspec.json.encode(document)
        try:
            write_atomically({self.path: content})
        except WriteError as error:
            error.hint = "make room or make the folder writable; the picks are kept on this page"
            raise
        self._stamp = self._stamp_now()

    def _stamp_now(self) -> tuple[int, int, int] | None:
        try:
            status = self.path.stat()
        except FileNotFoundError:
            return None
        except OSError as error:
            raise WriteError(
                f"the file cannot be reached: {error.strerror}", path=self.path
            ) from None
        return status.st_ino, status.st_size, status.st_mtime_ns


def _locked(path: Path) -> IO[bytes]:
    """An open file whose lock the system gives back when the process ends, however it ends.

    It lies in the folder of temporary files, named by the place of the picks, so that nothing is
    left beside the photo.
    """
    place = hashlib.sha256(os.fsencode(path.resolve())).hexdigest()[:32]
    user = str(os.getuid()) if hasattr(os, "getuid") else "user"
    file = (Path(tempfile.gettempdir()) / f"plumbline-{user}-{place}.lock").open("ab")
    if not _lock(file):
        file.close()
        raise WriteError(
            "these picks are open in another plumbline pick",
            path=path,
            hint="go on in its page, or stop it with Ctrl-C first",
        )
    return file


def _lock(file: IO[bytes]) -> bool:
    """Lock an open file for this process; whether that was possible."""
    try:
        if os.name == "nt":
            import msvcrt

            file.seek(0)
            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined]
        else:
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True

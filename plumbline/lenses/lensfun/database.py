"""LensFun's database and library: cameras and lenses by EXIF, coefficients by focal length.

LensFun's own library matches names and interpolates over focal length. Its rule for other
sensors is in `plumbline.lenses.profile`, because its own single-precision evaluation is only
good to 0.1 px. Of the distribution's database, the one that comes with lensfunpy, and updates the
newest is loaded, for lenses change their names; the user's own files go before it.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from plumbline.errors import OptionError, ReadError
from plumbline.files import read_bytes
from plumbline.formats.base import Source
from plumbline.formats.lens_files.lensfun_reading import LensfunEntry, LensfunFile, read_lensfun

_SHARED = (Path("/usr/share/lensfun"), Path("/usr/local/share/lensfun"))
_UPDATES = Path("/var/lib/lensfun-updates")
_MOST_FILES = 2000
"""Chosen; LensFun itself has 60."""

_EMBEDDED = 1_672_531_200
"""1 January 2023: lensfunpy's database, of LensFun 0.3.4 and that year, bears no date."""

_Stamp = tuple[int, int]


@dataclass(frozen=True)
class Database:
    """A loaded LensFun database.

    Attributes:
        library: LensFun's own object.
        files: The XML files it was loaded from, the later ones replacing the earlier.
        name: What to call it in a sentence.
        notes: Files that were left aside, in plain sentences.
    """

    library: Any
    files: tuple[str, ...]
    name: str
    notes: tuple[str, ...] = ()

    def entry(self, lens: Any) -> LensfunEntry | None:
        """The XML entry of one of the library's lenses."""
        wanted = _key(lens)
        word = max(lens.model.split(), key=len, default="").encode()
        for file in reversed(self.files):
            if word in _content(file).replace(b"&amp;", b"&"):
                for each in _parsed(file).lenses:
                    if _key(each) == wanted:
                        return each
        return None


@cache
def common_database() -> Database:
    """The newest of the released databases, and the user's own files, as one.

    A file of the user's that is damaged is left aside with a note.
    """
    import lensfunpy

    embedded = Path(lensfunpy.__file__).parent / "db_files"
    home = _user_folder()
    released = [folder / "version_1" for folder in (*_SHARED, _UPDATES, home / "updates")]
    newest = max([*released, embedded], key=lambda folder: _date(folder, folder == embedded))
    files, notes = list[str](), list[str]()
    for folder in (newest, home):
        for file in _xml_files(folder):
            if folder != home:
                files.append(file)
            elif reason := _why_unreadable(file):
                notes.append(f"left aside: {reason}")
            else:
                files.append(file)
    return Database(_library(files), tuple(files), "LensFun's database", tuple(notes))


def _date(folder: Path, embedded: bool) -> int:
    """When a database was released, in seconds; 0 where there is none."""
    if not _xml_files(folder):
        return 0
    try:
        return int((folder / "timestamp.txt").read_text("ascii").strip())
    except (OSError, ValueError):
        return _EMBEDDED if embedded else 1


def database_of(path: str) -> Database:
    """The database of one XML file or of the XML files of a folder.

    Damaged files of a folder are left aside with a note.

    Raises:
        ReadError: there is none that can be read.
    """
    place = Path(path)
    files = _xml_files(place) if place.is_dir() else [path]
    if not files:
        raise ReadError(
            "this folder holds no LensFun XML files", path=path, hint="name another folder"
        )
    return _database_at(path, tuple((file, _stamp(file)) for file in files))


@cache
def _database_at(path: str, stamped: tuple[tuple[str, _Stamp], ...]) -> Database:
    files = [file for file, _ in stamped]
    try:
        return Database(_load(files), tuple(files), path)
    except ReadError:
        reasons = {file: _why_unreadable(file) for file in files}
        good = [file for file in files if not reasons[file]]
        if not good:
            raise
    notes = tuple(f"left aside: {reason}" for reason in reasons.values() if reason)
    return Database(_library(good), tuple(good), path, notes)


def beyond_library(path: str) -> bool:
    """Whether a file is a LensFun database that the released library refuses.

    It is where it says that it is of version 2, or holds the model `acm` of that version.

    Raises:
        ReadError: it is damaged, or no LensFun database.
    """
    found = _parsed(path)
    models = {each.model for lens in found.lenses for each in lens.distortions}
    return found.version == 2 or "acm" in models


def entries_of(path: str) -> Sequence[LensfunEntry]:
    """The lenses of one XML file.

    Raises:
        ReadError: it is damaged, or no LensFun database.
    """
    return _parsed(path).lenses


def _user_folder() -> Path:
    from platformdirs import user_data_path

    # LensFun takes the desktop's data folder, on Windows and macOS the same as GLib.
    return user_data_path("lensfun", appauthor=False, roaming=sys.platform == "win32")


def _xml_files(folder: Path) -> list[str]:
    try:
        found = sorted(str(file) for file in folder.glob("*.xml") if file.is_file())
    except OSError:
        return []
    if len(found) > _MOST_FILES:
        raise ReadError(f"the folder holds {len(found):,} XML files", path=folder)
    return found


def _key(lens: Any) -> tuple[object, ...]:
    """What tells lenses apart: the library's and those of the XML give the same."""
    words = [text.casefold().split() for text in (lens.maker, lens.model, *sorted(lens.mounts))]
    return (*words, round(lens.crop_factor, 3))


def _stamp(file: str) -> _Stamp:
    """What changes when a file is saved again: what was read before then no longer counts."""
    try:
        found = Path(file).stat()
    except OSError:
        return 0, 0  # reading it says what is wrong
    return found.st_mtime_ns, found.st_size


def _content(file: str) -> bytes:
    return _content_at(file, _stamp(file))


@cache
def _content_at(file: str, _at: _Stamp) -> bytes:
    return read_bytes(file)


def _parsed(file: str) -> LensfunFile:
    return _parsed_at(file, _stamp(file))


@cache
def _parsed_at(file: str, _at: _Stamp) -> LensfunFile:
    return read_lensfun(Source(file, read_bytes(file)))


def _load(files: Sequence[str]) -> Any:
    for file in files:
        if beyond_library(file):
            raise ReadError(
                "this is a LensFun database of version 2 (or with its model acm), which LensFun "
                "0.3 does not read",
                path=file,
                hint="name the file itself with --lens",
            )
    return _library(files)


def _why_unreadable(file: str) -> str:
    """What is wrong with a file, in a sentence; empty if nothing is."""
    try:
        _load([file])
    except ReadError as error:
        return error.message
    return ""


def _library(files: Sequence[str]) -> Any:
    from lensfunpy import (
        Database as Library,  # pyright: ignore[reportAttributeAccessIssue]
        LensfunError,  # pyright: ignore[reportAttributeAccessIssue]
    )

    try:
        return Library(paths=list(files), load_common=False, load_bundled=False)
    except (LensfunError, OSError) as error:
        if len(files) > 1:
            for file in files:
                _library([file])
        raise ReadError(
            "LensFun does not read this file: "
            + (str(error) or "it holds an element or a value that LensFun does not know"),
            path=files[0] if files else "",
            hint="correct the file; LensFun fails on elements and attributes it does not know",
        ) from None
    except UnicodeError:
        raise OptionError("a file name of the LensFun database is not text") from None

"""Names of lenses asked of exiftool, where it is installed: one process for any number of photos.

Most cameras write a number for the lens into their maker notes; exiftool has the tables.
"""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from plumbline.photos.exif import RANGE_ALONE, PhotoFacts

_SECONDS_TO_START, _SECONDS_A_PHOTO = 30.0, 2.0
"""Chosen: exiftool takes 0.3 s to start and 0.02 s a photo on a slow disk."""

EXIFTOOL = "exiftool"
"""Who tells the name, in sentences."""

_TAGS = ("LensID", "LensModel", "Lens", "LensType", "LensType2")
_UNKNOWN = ("unknown", "n/a", "none", "manual lens", "no lens", "----")


def with_lens_name(photo: PhotoFacts, path: str | Path) -> PhotoFacts:
    """The photo with the name of its lens by exiftool, where it tells a camera but no lens."""
    if not lacks_name(photo):
        return photo
    name = lens_names([path]).get(Path(path), "")
    return photo.naming(name, EXIFTOOL) if name else photo


def lacks_name(photo: PhotoFacts) -> bool:
    """Whether a photo tells its camera but not its lens."""
    return bool(photo.model) and not photo.facts.model


def installed() -> bool:
    """Whether exiftool is on the path."""
    return shutil.which("exiftool") is not None


def lens_names(paths: Sequence[str | Path]) -> dict[Path, str]:
    """The names of the lenses of photographs, as exiftool tells them.

    Args:
        paths: The files.

    Returns:
        A name for each file whose lens exiftool knows; several lenses that share a number are
        joined with " or ". Nothing where it is not installed or fails.
    """
    program = shutil.which("exiftool")
    plain = {str(Path(path).absolute()): Path(path) for path in paths}
    wanted = [name for name in plain if "\n" not in name and "\r" not in name]
    if program is None or not wanted:
        return {}
    arguments = ["-j", "-q", "-q", "-fast", "-charset", "filename=utf8"]
    arguments += [f"-{tag}" for tag in _TAGS]
    try:
        done = subprocess.run(  # noqa: S603 - found on the path, its arguments by standard input
            [program, "-@", "-"],
            input="\n".join([*arguments, *wanted]).encode(),
            capture_output=True,
            timeout=_SECONDS_TO_START + _SECONDS_A_PHOTO * len(wanted),
            check=False,
        )
        rows: Any = json.loads(done.stdout or b"[]")
    except (OSError, subprocess.TimeoutExpired, ValueError):
        return {}
    found: dict[Path, str] = {}
    for row in rows if isinstance(rows, list) else []:
        name = _name_in(row) if isinstance(row, dict) else ""
        path = plain.get(str(Path(str(row.get("SourceFile", ""))))) if name else None
        if path is not None:
            found[path] = name
    return found


def _name_in(row: Mapping[str, Any]) -> str:
    """The first value that names a lens: one with its focal length."""
    for tag in _TAGS:
        text = " ".join(str(row.get(tag, "")).split())[:300]
        known = not text.casefold().startswith(_UNKNOWN) and text.isprintable()
        known = known and not RANGE_ALONE.fullmatch(text)
        if known and any(c.isdigit() for c in text) and any(c.isalpha() for c in text):
            return text
    return ""

"""The formats of picked points: one row each in `FORMATS`."""

from __future__ import annotations

from plumbline.errors import OptionError
from plumbline.files import RESULT
from plumbline.formats.base import Format, Source
from plumbline.formats.panotools import ptgui, pto
from plumbline.formats.points import (
    csv,
    cvat,
    imagej,
    labelme,
    via,
    webplotdigitizer,
    winmorph,
)

FORMATS: dict[str, Format] = {
    module.FORMAT.name: module.FORMAT
    for module in (ptgui, pto, cvat, labelme, via, imagej, webplotdigitizer, winmorph, csv)
}
"""From the most to the least specific: the first that recognises a file reads it."""


def format_of(source: Source, name: str | None = None) -> Format:
    """The format of a file, recognised by suffix and content or given by name.

    Raises:
        OptionError: there is no format of that name.
        ReadError: no format recognises the file.
    """
    if name is not None:
        if name not in FORMATS:
            raise OptionError(
                f"there is no format {name!r}", hint=f"choose one of {', '.join(FORMATS)}"
            )
        return FORMATS[name]
    for each in FORMATS.values():
        if each.recognises(source):
            return each
    source.text()  # empty and binary files have sentences of their own
    if RESULT in source.head:
        raise source.error(
            "this is a result of plumbline, not a file of points",
            hint="fit the points it came from; its lens corrects photos with correct --lens",
        )
    raise source.error(
        "the format of this file is not recognised",
        hint=f"name it with --format, one of {', '.join(FORMATS)}",
    )

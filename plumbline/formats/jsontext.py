"""JSON that may be hostile: parsed within bounds, and its values checked one by one."""

from __future__ import annotations

import json
import math
import re
from typing import cast

from plumbline.formats.base import Source, shown

MAX_LENGTH = 64 * 2**20
"""Characters; chosen, a million picks take 50 MB as text."""
MAX_VALUES = 5_000_000
"""Chosen: far above any file of points, so that a hostile one ends in bounded memory."""
_AGAIN = "export the file again"
# labelme stores the photo itself, base64 in one string.
_IMAGE_DATA = re.compile(r'"imageData"\s*:\s*"[^"\\]*"')

Object = dict[str, object]


def parsed(source: Source, text: str, line: int | None = None) -> object:
    """The value that a text in JSON holds.

    Args:
        source: The file, for messages.
        text: The JSON.
        line: The line of the file where it stands, if it is only a part of it.

    Raises:
        ReadError: the text is not JSON, or nests too deep, or is too large.
    """
    if '"imageData"' in text:
        text = _IMAGE_DATA.sub('"imageData": null', text)
    values = text.count(",") + text.count("[") + text.count("{")
    if len(text) > MAX_LENGTH or values > MAX_VALUES:
        raise source.error(
            f"the JSON has {len(text):,} characters and {values:,} values, more than is read",
            line,
            "give the picks of one photo or a few at a time",
        )
    try:
        return cast(object, json.loads(text))
    except json.JSONDecodeError as error:
        where = error.lineno if line is None else line
        raise source.error(f"the JSON is broken: {error.msg}", where, _AGAIN) from None
    except (ValueError, RecursionError):
        raise source.error(
            "the JSON holds an absurdly long number or nests too deep", line, _AGAIN
        ) from None


def as_object(source: Source, value: object, what: str, line: int | None = None) -> Object:
    """The value as an object with names.

    Raises:
        ReadError: it is something else.
    """
    if isinstance(value, dict):
        return cast(Object, value)
    raise source.error(f"{what} is {_kind(value)} where an object {{…}} belongs", line, _AGAIN)


def as_list(source: Source, value: object, what: str, line: int | None = None) -> list[object]:
    """The value as a list.

    Raises:
        ReadError: it is something else.
    """
    if isinstance(value, list):
        return cast("list[object]", value)
    raise source.error(f"{what} is {_kind(value)} where a list […] belongs", line, _AGAIN)


def as_text(value: object) -> str:
    """The value if it is text or a number; else empty."""
    if isinstance(value, str):
        return value
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return ""
    return "" if isinstance(value, int) and abs(value) >= 10**15 else str(value)


def as_number(source: Source, value: object, what: str, line: int | None = None) -> float:
    """The value as a finite number.

    Raises:
        ReadError: it is something else.
    """
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if math.isfinite(number):
            return number
    raise source.error(
        f"{what} is {_kind(value)} where a number belongs", line, "correct or remove it"
    )


def _kind(value: object) -> str:
    if value is None:
        return "missing"
    if isinstance(value, bool):
        return "true or false"
    if isinstance(value, str):
        return shown(value)
    if isinstance(value, dict):
        return "an object"
    return "a list" if isinstance(value, list) else "not a finite number"


def pairs(source: Source, value: object, what: str) -> list[tuple[float, float]]:
    """A flat list x, y, x, y, … as points.

    Raises:
        ReadError: it is something else.
    """
    numbers = [as_number(source, number, what) for number in as_list(source, value, what)]
    if len(numbers) % 2:
        raise source.error(f"{what} hold an x without a y", hint=_AGAIN)
    return list(zip(numbers[::2], numbers[1::2], strict=True))


def listed_names(source: Source, value: object) -> dict[str, str]:
    """The `name` of each object of a list, by its place there as text."""
    if value is None:
        return {}
    objects = [as_object(source, each, "a label") for each in as_list(source, value, "the labels")]
    return {str(place): as_text(each.get("name")) for place, each in enumerate(objects)}

"""JSON text of a record, and records of JSON text, with errors that say where in the file."""

from __future__ import annotations

import json
import re
from typing import Any, TypeVar, cast

import msgspec

from plumbline.errors import ReadError

R = TypeVar("R")

_KINDS = {
    "float": "a number",
    "int": "a whole number",
    "str": "a text",
    "array": "a list",
    "object": "a group of names and values",
    "bool": "true or false",
    "null": "null",
}
_EXPECTED = re.compile(r"Expected `(?P<want>[^`]+)`(?P<bound> of length .*| [<>]=? \S+)?")
_GOT = re.compile(r", got `(?P<got>\w+)`")
_MISSING = re.compile(r"missing required field `(?P<name>[^`]+)`")
_PLACE = re.compile(r" - at `\$\.?(?P<place>[^`]*)`")


class DamageError(Exception):
    """What is wrong with a file, in words for the user."""


def record_text(record: msgspec.Struct, depth: int = 3) -> str:
    """JSON text of a record; floats read back exactly.

    Args:
        record: The record.
        depth: How many levels have a row for each name or member; deeper ones, such as a picked
            line, are one row, which keeps a hundred thousand lines readable and quick to write.
    """
    text = _laid_out(msgspec.to_builtins(record), depth, "") + "\n"
    # A file name that is not valid text is written in JSON's own escapes and reads back as it was.
    return text.encode("utf-8", "backslashreplace").decode()


def _laid_out(value: Any, depth: int, margin: str) -> str:
    inner = f"{margin}  "
    if depth and value and isinstance(value, dict):
        members = cast(dict[str, Any], value).items()
        rows = [f"{_one_row(key)}: {_laid_out(each, depth - 1, inner)}" for key, each in members]
        return _block("{", rows, "}", margin)
    if depth and isinstance(value, (list, tuple)) and any(isinstance(each, dict) for each in value):
        return _block("[", [_laid_out(each, depth - 1, inner) for each in value], "]", margin)
    return _one_row(value)


def _block(start: str, rows: list[str], end: str, margin: str) -> str:
    return f"{start}\n{margin}  " + f",\n{margin}  ".join(rows) + f"\n{margin}{end}"


def _one_row(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False, allow_nan=False)


def parsed(text: str, path: str, hint: str) -> Any:
    """The values of a JSON text.

    Args:
        text: The text.
        path: Its file's.
        hint: What to do about a file that is damaged.

    Raises:
        ReadError: the text is not JSON.
    """
    try:
        return json.loads(text, parse_constant=_not_finite)
    except RecursionError:
        raise ReadError("the JSON is nested too deeply", path=path, hint=hint) from None
    except json.JSONDecodeError as error:
        raise ReadError(
            "the file is damaged: its text is not JSON from here on",
            path=path,
            line=error.lineno,
            hint=hint,
        ) from None
    except (DamageError, ValueError) as error:  # ValueError: a number of too many digits
        raise ReadError(f"the file is damaged: {error}", path=path, hint=hint) from None


def converted(values: Any, kind: type[R]) -> R:
    """A record of parsed values.

    Raises:
        DamageError: they do not follow the schema; the sentence names the place in the file.
    """
    try:
        return msgspec.convert(values, kind)
    except msgspec.ValidationError as error:
        raise DamageError(_in_words(str(error))) from None
    except (OverflowError, RecursionError):
        raise DamageError("a number is too large") from None


def _not_finite(name: str) -> float:
    raise DamageError(f"{name} is not a finite number")


def _in_words(message: str) -> str:
    """A message of msgspec's in words for the user."""
    found = _PLACE.search(message)
    place = found["place"] if found else ""
    if missing := _MISSING.search(message):
        return f"{missing['name']!r} is missing" + (f" from {place}" if place else "")
    where = place or "the whole"
    if expected := _EXPECTED.search(message):
        bound = (expected["bound"] or "").strip()
        wanted = " or ".join(_KINDS.get(kind, kind) for kind in expected["want"].split(" | "))
        if got := _GOT.search(message):
            return f"{where} should be {wanted}, not {_KINDS.get(got['got'], got['got'])}"
        return f"{where} should be {wanted} {bound}".rstrip().replace(", got", ", not")
    if "out of range" in message:
        return f"{where} is a number out of range"
    return f"{where} holds a value that is not known here"

"""Names of lenses compared: their numbers, which must agree, and their words, which need not."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass

_FOCAL = re.compile(r"(\d+(?:\.\d+)?)(?:\s*-\s*(\d+(?:\.\d+)?))?\s*(?:mm\b|(?=\s*/\s*f?\d))", re.I)
_APERTURE = re.compile(r"(?:\bf\s*/?\s*|\b1:|/)(\d+(?:\.\d+)?)(?:\s*-\s*(\d+(?:\.\d+)?))?", re.I)
_WORD = re.compile(r"\d+(?:\.\d+)?|[a-z]+|\+")
_NO_WORDS = frozenset(
    (
        "mm",
        "f",
        "lens",
        "canon",
        "nikon",
        "sony",
        "pentax",
        "smc",
        "hd",
        "olympus",
        "panasonic",
        "fujifilm",
    )
)

_SAME_FOCAL = 0.02
"""Chosen because names round focal lengths to whole millimetres, from about 50 mm on by 1 %."""

_SAME_APERTURE = 0.06
"""Chosen because names round f-numbers to one decimal: 1.75 is written 1.7 and 1.8."""


@dataclass(frozen=True)
class Numbers:
    """What the numbers in a lens's name say.

    Attributes:
        range_mm: Shortest and longest focal length; None where the name does not say.
        apertures: Largest aperture at both ends; None where the name does not say.
    """

    range_mm: tuple[float, float] | None
    apertures: tuple[float, float] | None


def numbers_of(name: str) -> Numbers:
    """The numbers in a name such as "EF-S18-55mm f/3.5-5.6 IS" or "18-55/3.5-5.6"."""
    focal, rest = _FOCAL.search(name), name
    if focal is not None:
        rest = name[focal.end() :]
    return Numbers(_pair(focal), _pair(_APERTURE.search(rest)))


def _pair(found: re.Match[str] | None) -> tuple[float, float] | None:
    if found is None:
        return None
    low = float(found.group(1))
    high = float(found.group(2) or low)
    return (low, high) if 0 < low <= high else None


def agree(one: Numbers, other: Numbers) -> bool:
    """Whether two names may be of one lens: what both tell agrees."""
    return same_range(one.range_mm, other.range_mm) and _near(
        one.apertures, other.apertures, _SAME_APERTURE
    )


def same_range(one: tuple[float, float] | None, other: tuple[float, float] | None) -> bool:
    """Whether two ranges of focal lengths are one, as far as both are known."""
    return _near(one, other, _SAME_FOCAL)


def _near(
    one: tuple[float, float] | None, other: tuple[float, float] | None, tolerance: float
) -> bool:
    if one is None or other is None:
        return True
    return all(abs(a / b - 1) <= tolerance for a, b in zip(one, other, strict=True))


def likeness(one: str, other: str) -> float:
    """Shared words and numbers over all of them, 0 to 1; makers' names do not count."""
    first, second = _words(one), _words(other)
    return sum((first & second).values()) / max(sum((first | second).values()), 1)


def _words(name: str) -> Counter[str]:
    return Counter(word for word in _WORD.findall(name.casefold()) if word not in _NO_WORDS)

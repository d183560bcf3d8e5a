"""Numbers and lists in sentences."""

from __future__ import annotations

from collections.abc import Sequence


def count(number: int, noun: str) -> str:
    """A number with its noun: "1 line", "2 lines"."""
    return f"{number:,} {noun}" + ("" if number == 1 else "s")


def listed(items: Sequence[str], most: int = 8) -> str:
    """The first items separated by commas, and how many more there are."""
    more = f" and {len(items) - most} more" if len(items) > most else ""
    return ", ".join(items[:most]) + more


def joined(items: Sequence[str], word: str = "and") -> str:
    """Items as a sentence lists them: "top", "top and left", "top, left and right"."""
    return f" {word} ".join(filter(None, (", ".join(items[:-1]), *items[-1:])))


def px(length: float) -> str:
    """A length with two significant digits: "0.58 px", "1.0 px", "12 px", "1,230 px".

    From 10 px on all whole pixels are shown, since rounding those away would look like an error.
    """
    if abs(length) >= 10:
        return f"{length:,.0f} px"
    return f"{length:#.2g} px"

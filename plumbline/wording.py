"""Numbers and lists in sentences."""

from __future__ import annotations

from collections.abc import Sequence


def count(number: int, noun: str, plural: str = "") -> str:
    """A number with its noun: "1 line", "2 lines", "3 matches"."""
    return f"{number:,} " + (noun if number == 1 else plural or f"{noun}s")


def listed(items: Sequence[str], most: int = 8) -> str:
    """The first items separated by commas, and how many more there are."""
    more = f" and {len(items) - most} more" if len(items) > most else ""
    return ", ".join(items[:most]) + more


def joined(items: Sequence[str], word: str = "and") -> str:
    """Items as a sentence lists them: "top", "top and left", "top, left and right"."""
    return f" {word} ".join(filter(None, (", ".join(items[:-1]), *items[-1:])))


def power_of(base: str, exponent: int) -> str:
    """A power as it is printed: "r²", "r¹⁰", and "r" itself."""
    digits = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
    return base if exponent == 1 else base + str(exponent).translate(digits)


def number(value: float, form: str) -> str:
    """A number in the form of a format specification, its minus a true one: "−0.3"."""
    return format(value, form).replace("-", "−")


def px(length: float) -> str:
    """A length with two significant digits: "0.58 px", "1.0 px", "12 px", "1,230 px".

    From 10 px on all whole pixels are shown, since rounding those away would look like an error.
    """
    if abs(length) >= 10:
        return f"{length:,.0f} px"
    return f"{length:#.2g} px"


_SPELT = {
    "✓": "OK",
    "✗": "BAD",
    "σ": "sigma",
    "Δ": "delta ",
    "μ": "mu",
    "τ": "tau",
    "θ": "theta",
    "→": "->",
    "←": "<-",
    "•": "*",
    "…": "...",
    "–": "-",
    "—": "-",
    "−": "-",
    "×": "x",
    "÷": "/",
    "±": "+/-",
    "≤": "<=",
    "≥": ">=",
    "≈": "~",
    "√": "sqrt ",
    "·": "*",
    "°": " deg",
    "²": "^2",
    "³": "^3",
    "⁴": "^4",
    "⁵": "^5",
    "⁶": "^6",
    "⁷": "^7",
    "⁸": "^8",
    "⁹": "^9",
    "¹": "^1",
    "⁻": "^-",
    "⁰": "^0",
    "₁": "1",
    "₂": "2",
    "₃": "3",
    "₄": "4",
    "₅": "5",
    "ᵀ": "^T",
    "\N{COMBINING CIRCUMFLEX ACCENT}": "",
    "“": '"',
    "”": '"',
    "„": '"',
    "‘": "'",
    "’": "'",
    "\N{NO-BREAK SPACE}": " ",
    "«": "<<",
    "»": ">>",
    "\N{REPLACEMENT CHARACTER}": "(?)",
}
"""What stands for a sign in an encoding that lacks it, so that no two signs become one."""


def spelt(error: UnicodeError) -> tuple[str, int]:
    """An error handler for `codecs`: signs that an encoding lacks are spelt in ASCII.

    What has no spelling, such as letters of another script, is written as Python escapes it.
    """
    if not isinstance(error, UnicodeEncodeError):
        raise error
    signs = error.object[error.start : error.end]
    words = "".join(_sign(sign) for sign in signs)
    return words, error.end


def in_ascii(text: str) -> str:
    """Text with its signs spelt, and a "?" for every other letter that ASCII lacks."""
    return "".join(c if c.isascii() else _SPELT.get(c, "?") for c in text)


def _sign(sign: str) -> str:
    if sign in _SPELT:
        return _SPELT[sign]
    if "\N{BOX DRAWINGS LIGHT HORIZONTAL}" <= sign <= "\N{BLACK SQUARE}":
        return "-"
    return sign.encode("ascii", "backslashreplace").decode()

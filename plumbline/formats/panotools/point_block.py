"""Control points in the form that Hugin and plumbline write, many at a time.

    c n0 N0 x175.00064 y87.999336 X1533.999936 Y62.666712 t3

A decimal of up to 15 digits is m / 10^k, its digits without the dot over a power of ten. Both
are exact as doubles, and their quotient is rounded once, so that it is what `float` makes of the
text (Clinger 1990, "How to read floating point numbers accurately"). Any other number is given
to `float` itself.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array

N_FIELDS = 7
"""n, N, x, y, X, Y and t of a record."""

_SHAPE = b"c n N x y X Y t\n"
_LETTERS = np.frombuffer(b"nNxyXYt", dtype=np.uint8)
_WHOLE = [0, 1, 6]
"""Fields that are integers: n, N and t."""
_MOST_WHOLE_DIGITS = 9
"""Ten digits no longer fit 32 bits."""
_MOST_EXACT_DIGITS = 15
"""Integers of so many digits, and the powers of ten that divide them, are exact as doubles."""
_POWERS = np.array([float(10**k) for k in range(_MOST_EXACT_DIGITS + 1)])

_END, _DOT = 1, 2
_MARKS = bytes.maketrans(
    b"0123456789cnNxyXYt \n.+-eE", bytes([0] * 18 + [_END] * 2 + [_DOT, *[3] * 4])
)
_DIGITS_ALONE = bytes.maketrans(b"cnNxyXYt+-eE", b" " * 8 + b"0" * 4)


@dataclass(frozen=True, eq=False)
class _Fields:
    """Where the numbers of a block stand; each array has the shape (records, 7).

    Attributes:
        starts: The first byte of each number.
        stops: One past its last byte.
        n_marks: How many of its bytes are not digits.
        decimals: How many of them follow its dot; -1 for what is not a mere decimal.
    """

    starts: NDArray[np.int64]
    stops: NDArray[np.int64]
    n_marks: NDArray[np.int64]
    decimals: NDArray[np.int64]

    @property
    def n_digits(self) -> NDArray[np.int64]:
        """How many digits each number has."""
        return self.stops - self.starts - self.n_marks


def table_of(block: bytes) -> Array | None:
    """The numbers n, N, x, y, X, Y, t of control points, shape (n, 7).

    Args:
        block: The records, each beginning with a `c` and a blank and with the end of its line.

    Returns:
        The numbers; None where a record departs from the usual form or from real numbers in any
        way, which is left to a reader of single records.
    """
    if b"\r" in block:
        block = block.replace(b"\r\n", b"\n")
    shape = block.translate(None, b"0123456789.+-eE")
    if shape != _SHAPE * (len(shape) // len(_SHAPE)):
        return None
    fields = _fields(block)
    n_digits, whole = fields.n_digits, fields.n_marks[:, _WHOLE] == 0
    letters = np.frombuffer(block, dtype=np.uint8)[fields.starts - 1]
    if np.any(letters != _LETTERS) or np.any(n_digits < 1) or not np.all(whole):
        return None
    if np.any(n_digits[:, _WHOLE] > _MOST_WHOLE_DIGITS):
        return None
    # Each field has digits: were there any elsewhere, there would be more numbers than fields.
    digits = np.fromstring(block.translate(_DIGITS_ALONE, b"."), dtype=np.int64, sep=" ")
    if len(digits) != n_digits.size:
        return None
    exact = (fields.decimals >= 0) & (n_digits <= _MOST_EXACT_DIGITS)
    table = digits.reshape(-1, N_FIELDS) / _POWERS[np.where(exact, fields.decimals, 0)]
    if not np.all(exact):
        spans = zip(fields.starts[~exact].tolist(), fields.stops[~exact].tolist(), strict=True)
        try:
            table[~exact] = [float(block[start:stop]) for start, stop in spans]
        except ValueError:
            return None
    return table if np.all(np.isfinite(table)) else None


def _fields(block: bytes) -> _Fields:
    """Find the numbers of a block of which every record has the usual letters and blanks."""
    codes = np.frombuffer(block.translate(_MARKS), dtype=np.uint8)
    marks = np.flatnonzero(codes != 0)
    kinds = codes[marks]
    ends = np.flatnonzero(kinds == _END).reshape(-1, N_FIELDS + 1)
    stops, last = marks[ends[:, 1:]], ends[:, 1:] - 1
    n_marks = np.diff(ends) - 1
    decimals = np.where(kinds[last] == _DOT, stops - marks[last] - 1, -1)
    decimals[n_marks == 0] = 0
    decimals[n_marks > 1] = -1
    return _Fields(marks[ends[:, :-1]] + 2, stops, n_marks, decimals)

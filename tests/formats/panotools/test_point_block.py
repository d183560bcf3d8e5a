"""Control points read a block at a time are those read number by number."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, strategies as st

from plumbline.formats.base import Source
from plumbline.formats.panotools import point_records
from plumbline.formats.panotools.point_block import table_of

USUAL = b"c n0 N0 x175.00064 y87.999336 X1533.999936 Y62.666712 t3\n"


def usual(*numbers: str, n: int = 0, t: int = 3) -> bytes:
    return "c n{} N{} x{} y{} X{} Y{} t{}\n".format(n, n, *numbers, t).encode()


def exactly(*numbers: str, n: int = 0, t: int = 3) -> list[str]:
    """As hexadecimals, which tell every bit, and -0 from 0."""
    return [value.hex() for value in (n, n, *map(float, numbers), t) for value in [float(value)]]


def never(_: bytes) -> None:
    """Leaves every block to the careful way."""


decimals = st.from_regex(
    r"(\d{1,20}\.?\d{0,20}|\.\d{1,20})", fullmatch=True, alphabet="0123456789."
)
doubles = st.floats(allow_nan=False, allow_infinity=False).map(repr)
signed = st.builds("".join, st.tuples(st.sampled_from("+-"), decimals))
powers = st.builds("{}e{}".format, decimals, st.integers(-40, 40))
coordinates = st.tuples(*[decimals | doubles | signed | powers | st.just("-0")] * 4)


@given(
    rows=st.lists(
        st.tuples(coordinates, st.integers(0, 999_999_999), st.integers(0, 999_999_999)),
        min_size=1,
        max_size=5,
    ),
    end=st.sampled_from([b"\n", b"\r\n"]),
)
def test_every_number_is_what_float_makes_of_it(
    rows: list[tuple[tuple[str, ...], int, int]], end: bytes
) -> None:
    block = b"".join(usual(*numbers, n=n, t=t) for numbers, n, t in rows).replace(b"\n", end)
    table = table_of(block)
    assert table is not None
    assert [[value.hex() for value in row] for row in table.tolist()] == [
        exactly(*numbers, n=n, t=t) for numbers, n, t in rows
    ]


@pytest.mark.parametrize("n_digits", [9, 14, 15, 16, 17])
def test_decimals_of_any_length_are_rounded_to_the_nearest_double(n_digits: int) -> None:
    rng = np.random.default_rng(n_digits)
    digits = rng.integers(10 ** (n_digits - 1), 10**n_digits, (2000, 4)).astype(str).tolist()
    dots = rng.integers(0, n_digits + 1, (2000, 4)).tolist()
    rows = [
        [f"{text[:dot]}.{text[dot:]}" for text, dot in zip(texts, its_dots, strict=True)]
        for texts, its_dots in zip(digits, dots, strict=True)
    ]
    table = table_of(b"".join(usual(*row) for row in rows))
    assert table is not None
    assert table[:, 2:6].tolist() == [list(map(float, row)) for row in rows]


@pytest.mark.parametrize(
    "odd",
    [
        "c n0 N0 x y1-2 X3 Y4 t3",
        "c n0 N0 x1.2.3 y5 X6 Y t3",
        "c n0 N0 x1.2.3 y5 X6 Y7 t3",
        "c n0 N0 x1y2 X3 Y4 t3",
        "c n0 N0 x1 y2 X3 Y4",
        "c N0 n0 x1 y2 X3 Y4 t3",
        "c n0.5 N0 x1 y2 X3 Y4 t3",
        "c n0. N0 x1 y2 X3 Y4 t3",
        "c n0 N0 x1 y2 X3 Y4 t3.0",
        "c n0 N0 x1 y2 X3 Y4 t3-",
        "c n0 N0 x1 y2 X3 Y4 t+3",
        "c n0 N0 x1 y2 X3 Y4 t3e0",
        "c n-1 N0 x1 y2 X3 Y4 t3",
        "c n0000000000 N0 x1 y2 X3 Y4 t3",
        "c n0 N0 x1e999 y2 X3 Y4 t3",
        "c n0 N0 xe5 y2 X3 Y4 t3",
        "c n0 N0 x. y2 X3 Y4 t3",
        "c n0 N0 x+ y2 X3 Y4 t3",
        "c n0 N0 x1- y2 X3 Y4 t3",
        "c n0 N0 x1 2 y X3 Y4 t3",
        "c n0 N0 x. 5y2 X3 Y4 t3",
        "c n0 N0 5x y2 X3 Y4 t3",
        "5c n0 N0 x1 y2 X3 Y4 t3",
        "c5 n0 N0 x1 y2 X3 Y4 t3",
        "c5 n N0 x1 y2 X3 Y4 t3",
        "5c n0 N0 x1 y2 X3 Y t3",
        "c n0 N0 x1  y2 X3 Y4 t3",
        "c n0 N0 x1 y2 X3 Y4 t3 ",
        "c\tn0 N0 x1 y2 X3 Y4 t3",
        "c n0 N0 x1 y2 X3 Y4 t3\r\r",
        "c n0 N0 x1\ry2 X3 Y4 t3",
        "c n0 N0 x1_0 y2 X3 Y4 t3",
        "c n0 N0 x1,5 y2 X3 Y4 t3",
        "c n0 N0 xnan y2 X3 Y4 t3",
        "c n0 N0 x\u0663 y2 X3 Y4 t3",
        "",
    ],
)
@pytest.mark.parametrize("first", [False, True], ids=["after", "before"])
def test_what_is_not_usual_is_left_to_the_careful_way(odd: str, first: bool) -> None:
    record = odd.encode() + b"\n"
    assert table_of(record + USUAL if first else USUAL + record) is None


@given(
    text=st.lists(
        st.sampled_from([*"cnNxyXYt0159.+-eE \t\r", "nan", "1e3", " x", " t"]), max_size=9
    )
    .map("".join)
    .flatmap(
        lambda junk: st.integers(0, len(USUAL) - 1).map(
            lambda i: USUAL[:i] + junk.encode() + USUAL[i:]
        )
    )
)
def test_odd_records_are_left_or_read_the_same(text: bytes) -> None:
    assume(text.startswith((b"c ", b"c\t")))
    table = table_of(USUAL + text)
    if table is None:
        return
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(point_records, "table_of", never)
        points, rest = point_records.take_points(Source("x.pto", USUAL + text))
    assert rest == [(3, "")]
    assert table[:, :2].tolist() == points.images.tolist()
    assert table[:, 2:6].tolist() == points.ends.tolist()
    assert table[:, 6].tolist() == points.kinds.tolist()

"""Values of a result's JSON, checked one by one: what a file says is hostile until then."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np

from plumbline.frame import Array

T = TypeVar("T")

_MOST = 1e100
"""Chosen: what is larger is no measurement, and its square still a number."""


class DamageError(Exception):
    """What is wrong with the file, in words for the user."""


def truth(value: Any) -> bool:
    """True or false."""
    if not isinstance(value, bool):
        raise DamageError(f"{value!r} is neither true nor false")
    return value


def whole_number(value: Any, *, least: int) -> int:
    """A whole number from `least` on."""
    if not isinstance(value, int) or isinstance(value, bool) or not least <= value <= _MOST:
        raise DamageError(f"{value!r} is no whole number from {least} on")
    return value


def size(value: Any) -> float:
    """A number that is not negative."""
    number = finite(value)
    if number < 0:
        raise DamageError(f"{number:g} is negative")
    return number


def pair_of(values: Any, of: Callable[[Any], T]) -> tuple[T, T]:
    """Two values, each by the same check."""
    first, second = values
    return of(first), of(second)


def array_of(values: Any, dimensions: int) -> Array:
    """Numbers in an array of so many dimensions."""
    array = np.array(values, dtype=np.float64)
    if array.ndim != dimensions or not np.all(np.abs(array) <= _MOST):
        raise DamageError("an array has the wrong shape or holds an absurd number")
    return array


def finite(value: Any) -> float:
    """A number that is no absurd one."""
    number = float(value)
    if not abs(number) <= _MOST:
        raise DamageError(f"{number:g} is an absurd number")
    return number

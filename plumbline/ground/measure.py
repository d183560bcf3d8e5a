"""Places, distances, angles and areas on the plane, with 95 % bars and ellipses.

All places that one quantity needs share the camera and are correlated through it; the covariance
of all of them together is carried through by the quantity's own derivatives.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, get_args

import numpy as np

from plumbline.errors import OptionError
from plumbline.frame import Array
from plumbline.ground.ellipses import Z_95, ellipse

Kind = Literal["place", "distance", "angle", "area"]

KINDS: tuple[Kind, ...] = get_args(Kind)

_NEEDED = {"place": (1, 1), "distance": (2, 2), "angle": (3, 3), "area": (3, 1_000)}
_UNITS = {"place": "m", "distance": "m", "angle": "°", "area": "m²"}


@dataclass(frozen=True)
class Measurement:
    """One measured quantity.

    Attributes:
        kind: "place", "distance", "angle" or "area".
        names: The points that it is between; of an angle the second is the corner.
        values: X and Y of a place in metres; else one value, in metres, degrees or m².
        errors: Their standard errors.
        ellipse: Of a place the half axes of the 95 % ellipse, long and short, metres, and the
            angle of the long one from X in degrees.
    """

    kind: Kind
    names: tuple[str, ...]
    values: tuple[float, ...]
    errors: tuple[float, ...]
    ellipse: tuple[float, float, float] | None = None

    @property
    def unit(self) -> str:
        """The unit of the values."""
        return _UNITS[self.kind]

    @property
    def intervals(self) -> tuple[tuple[float, float], ...]:
        """The 95 % interval of each value."""
        return tuple(
            (value - Z_95 * error, value + Z_95 * error)
            for value, error in zip(self.values, self.errors, strict=True)
        )


def refuse_number(kind: Kind, names: Sequence[str]) -> None:
    """Refuse too few or too many points, or one twice.

    Raises:
        OptionError: as said.
    """
    least, most = _NEEDED[kind]
    if not least <= len(names) <= most or len(set(names)) < len(names):
        wanted = f"{least}" if least == most else f"at least {least}"
        raise OptionError(
            f"{_article(kind)} needs {wanted} different points, and {','.join(names)} was given",
            hint="name them as A,B,C",
        )


def measured(kind: Kind, names: Sequence[str], places: Array, covariance: Array) -> Measurement:
    """One quantity from places and the covariance of all of them together.

    Args:
        kind: "place", "distance", "angle" (at the second of three) or "area" (of a polygon).
        names: The points.
        places: Shape (m, 2), metres.
        covariance: Of x₁, y₁, x₂, …, shape (2 m, 2 m).

    Raises:
        OptionError: the polygon crosses itself.
    """
    if kind == "place":
        errors = np.sqrt(np.diag(covariance))
        x, y = map(float, places[0])
        sure = float(errors[0]), float(errors[1])
        return Measurement(kind, tuple(names), (x, y), sure, ellipse(covariance))
    if kind == "area" and _crosses_itself(places):
        raise OptionError(
            f"the sides of {','.join(names)} cross", hint="name the corners in their order"
        )
    value, slope = {"distance": _distance, "angle": _angle, "area": _area}[kind](places)
    error = float(np.sqrt(max(slope @ covariance @ slope, 0.0)))
    return Measurement(kind, tuple(names), (value,), (error,))


def _article(kind: Kind) -> str:
    return f"an {kind}" if kind[0] == "a" else f"a {kind}"


def _distance(places: Array) -> tuple[float, Array]:
    apart = places[1] - places[0]
    length = float(np.hypot(*apart))
    along = apart / max(length, 1e-12)
    return length, np.concatenate((-along, along))


def _angle(places: Array) -> tuple[float, Array]:
    """At the second point, 0 to 180 degrees."""
    p, q = places[0] - places[1], places[2] - places[1]
    turn = float(np.arctan2(p[0] * q[1] - p[1] * q[0], p @ q))
    by_p = np.array([p[1], -p[0]]) / (p @ p)
    by_q = np.array([-q[1], q[0]]) / (q @ q)
    slope = np.degrees(np.concatenate((by_p, -by_p - by_q, by_q))) * (np.sign(turn) or 1.0)
    return float(np.degrees(abs(turn))), slope


def _area(places: Array) -> tuple[float, Array]:
    """Of a polygon, by the shoelace formula."""
    x, y = places.T
    after, before = np.roll(np.arange(len(x)), -1), np.roll(np.arange(len(x)), 1)
    signed = float(np.sum(x * y[after] - x[after] * y)) / 2
    slope = np.stack((y[after] - y[before], x[before] - x[after]), axis=1).ravel() / 2
    return abs(signed), slope * np.sign(signed)


def _crosses_itself(places: Array) -> bool:
    sides = list(pairwise([*places, places[0]]))
    for first, (a, b) in enumerate(sides):
        for second in range(first + 2, len(sides)):
            if first == 0 and second == len(sides) - 1:
                continue
            c, d = sides[second]
            if _side(a, b, c) * _side(a, b, d) < 0 and _side(c, d, a) * _side(c, d, b) < 0:
                return True
    return False


def _side(a: Array, b: Array, c: Array) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))

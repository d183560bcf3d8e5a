"""LensFun's third-order polynomial.

    r_obs = r (1 − k1 + k1 r²),   r the ideal radius

Direction: ideal → observed. Normalisation: r = 1 at half the shorter side, where the scale
is 1. It is `ptlens` with b = k1 and a = c = 0. Source: LensFun, `<distortion model="poly3">`.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from plumbline.models.base import Model


@dataclass(frozen=True)
class Poly3(Model):
    """r_obs = r (1 − k1 + k1 r²)."""

    name = "poly3"
    direction = "ideal to observed"
    gauge = 1
    formula = "r_obs = r (1 − k1 + k1 r²)"
    use = "LensFun"
    source = "LensFun, model poly3"

    of_ptlens = MappingProxyType({"k1": "b"})

    @property
    def coefficients(self) -> tuple[str, ...]:
        """k1."""
        return ("k1",)

    @property
    def powers(self) -> tuple[int, ...]:
        """2."""
        return (2,)

    @property
    def next_powers(self) -> tuple[int, ...]:
        """1, 3."""
        return 1, 3

    def in_other_words(self, free: tuple[str, ...]) -> tuple[str, ...]:
        """Panorama Tools' b alone."""
        return ("ptlens b",) if free == ("k1",) else ()

    def factor(self, r: Any, c: Any) -> Any:
        """1 − k1 + k1 r²."""
        return c[0] * r * r + (1.0 - c[0])

    def slope(self, r: Any, c: Any) -> Any:
        """1 − k1 + 3 k1 r²."""
        return 3 * c[0] * r * r + (1.0 - c[0])

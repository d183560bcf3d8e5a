"""LensFun's fifth-order polynomial.

    r_obs = r (1 + k1 r² + k2 r⁴),   r the ideal radius

Direction: ideal → observed. Normalisation: r = 1 at half the shorter side; the scale is 1 at
the centre. Source: LensFun, `<distortion model="poly5">`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from plumbline.models.base import Model
from plumbline.models.polynomials import even, even_slope


@dataclass(frozen=True)
class Poly5(Model):
    """r_obs = r (1 + k1 r² + k2 r⁴)."""

    name = "poly5"
    direction = "ideal to observed"
    gauge = 0
    formula = "r_obs = r (1 + k1 r² + k2 r⁴)"
    use = "LensFun"
    source = "LensFun, model poly5"

    @property
    def coefficients(self) -> tuple[str, ...]:
        """k1, k2."""
        return "k1", "k2"

    def in_other_words(self, free: tuple[str, ...]) -> tuple[str, ...]:
        """OpenCV's first two coefficients, in units of the focal length."""
        return (f"opencv {', '.join(free)}",) if {*free} <= {*self.coefficients} else ()

    def factor(self, r: Any, c: Any) -> Any:
        """1 + k1 r² + k2 r⁴."""
        return even(r, c[0], c[1])

    def slope(self, r: Any, c: Any) -> Any:
        """1 + 3 k1 r² + 5 k2 r⁴."""
        return even_slope(r, c[0], c[1])

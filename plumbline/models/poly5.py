"""LensFun's fifth-order polynomial.

    r_obs = r (1 + k1 r² + k2 r⁴),   r the ideal radius

Direction: ideal → observed. Normalisation: r = 1 at half the shorter side; the scale is 1 at
the centre. Source: LensFun, `<distortion model="poly5">`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from plumbline.models.base import Model


@dataclass(frozen=True)
class Poly5(Model):
    """r_obs = r (1 + k1 r² + k2 r⁴)."""

    name = "poly5"
    direction = "ideal to observed"
    gauge = 0
    formula = "r_obs = r (1 + k1 r² + k2 r⁴)"
    use = "LensFun"

    @property
    def coefficients(self) -> tuple[str, ...]:
        """k1, k2."""
        return "k1", "k2"

    def factor(self, r: Any, c: Any) -> Any:
        """1 + k1 r² + k2 r⁴."""
        r2 = r * r
        return 1.0 + (c[0] + c[1] * r2) * r2

    def slope(self, r: Any, c: Any) -> Any:
        """1 + 3 k1 r² + 5 k2 r⁴."""
        r2 = r * r
        return 1.0 + (3 * c[0] + 5 * c[1] * r2) * r2

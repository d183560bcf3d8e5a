"""The Adobe camera model, as LensFun 0.4 writes it.

    p_obs = p (1 + k1 r² + k2 r⁴ + k3 r⁶) + tangential(k4, k5),   p the ideal point

Direction: ideal → observed. Normalisation: r = 1 at one focal length from the centre; the
scale is 1 at the centre. It is OpenCV's model with k4 = p1, k5 = p2 and another order.
Source: Adobe, "Lens Profile Creator" technical report, 2010; LensFun, `model="acm"`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from plumbline.models.base import Model
from plumbline.models.polynomials import even, even_slope


@dataclass(frozen=True)
class ACM(Model):
    """p_obs = p (1 + k1 r² + k2 r⁴ + k3 r⁶) + tangential(k4, k5), r in focal lengths."""

    name = "acm"
    direction = "ideal to observed"
    gauge = 0
    formula = "p_obs = p (1 + k1 r² + k2 r⁴ + k3 r⁶) + tangential(k4, k5)"
    use = "LensFun 0.4, Adobe"
    source = "Adobe, Lens Profile Creator, technical report, 2010; LensFun, model acm"
    unit = "focal length"
    tangential = ("k4", "k5")

    @property
    def coefficients(self) -> tuple[str, ...]:
        """k1, k2, k3, k4, k5."""
        return "k1", "k2", "k3", "k4", "k5"

    def factor(self, r: Any, c: Any) -> Any:
        """1 + k1 r² + k2 r⁴ + k3 r⁶."""
        return even(r, c[0], c[1], c[2])

    def slope(self, r: Any, c: Any) -> Any:
        """1 + 3 k1 r² + 5 k2 r⁴ + 7 k3 r⁶."""
        return even_slope(r, c[0], c[1], c[2])

"""OpenCV's five-coefficient model.

    p_obs = p (1 + k1 r² + k2 r⁴ + k3 r⁶) + tangential(p1, p2),   p the ideal point

Direction: ideal → observed. Normalisation: r = 1 at one focal length from the centre; the
scale is 1 at the centre. Order of the coefficients: OpenCV's k1, k2, p1, p2, k3. Source:
OpenCV, `calib3d` (J. Heikkilä and O. Silvén, 1997, after Brown).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from plumbline.models.base import Model
from plumbline.models.polynomials import even, even_slope


@dataclass(frozen=True)
class OpenCV(Model):
    """p_obs = p (1 + k1 r² + k2 r⁴ + k3 r⁶) + tangential(p1, p2), r in focal lengths."""

    name = "opencv"
    direction = "ideal to observed"
    gauge = 0
    formula = "p_obs = p (1 + k1 r² + k2 r⁴ + k3 r⁶) + tangential(p1, p2)"
    use = "OpenCV"
    source = "OpenCV, calib3d; J. Heikkilä and O. Silvén, 1997, after D. C. Brown"
    unit = "focal length"
    tangential = ("p1", "p2")

    @property
    def coefficients(self) -> tuple[str, ...]:
        """k1, k2, p1, p2, k3."""
        return "k1", "k2", "p1", "p2", "k3"

    def factor(self, r: Any, c: Any) -> Any:
        """1 + k1 r² + k2 r⁴ + k3 r⁶."""
        return even(r, c[0], c[1], c[4])

    def slope(self, r: Any, c: Any) -> Any:
        """1 + 3 k1 r² + 5 k2 r⁴ + 7 k3 r⁶."""
        return even_slope(r, c[0], c[1], c[4])

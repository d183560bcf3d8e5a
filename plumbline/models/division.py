"""The division model of computer vision.

    p_ideal = p / (1 + l1 r² + l2 r⁴),   p the observed point

Direction: observed → ideal. Normalisation: r = 1 at half the shorter side; the scale is 1 at
the centre. l1 < 0 is barrel distortion. Source: A. W. Fitzgibbon, "Simultaneous linear
estimation of multiple view geometry and lens distortion", 2001, with a second term.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from plumbline.models.base import Model
from plumbline.models.polynomials import even


@dataclass(frozen=True)
class Division(Model):
    """p_ideal = p / (1 + l1 r² + l2 r⁴)."""

    name = "division"
    direction = "observed to ideal"
    gauge = 0
    formula = "p_ideal = p / (1 + l1 r² + l2 r⁴)"
    use = "computer vision"
    source = (
        "A. W. Fitzgibbon, Simultaneous linear estimation of multiple view geometry and "
        "lens distortion, 2001"
    )

    @property
    def coefficients(self) -> tuple[str, ...]:
        """l1, l2."""
        return "l1", "l2"

    def curve_miss(self, observed: Any, ideal: Any, c: Any) -> Any:
        """Multiplied by the denominator, which makes it linear."""
        return ideal * even(observed, c[0], c[1]) - observed

    def factor(self, r: Any, c: Any) -> Any:
        """1 / (1 + l1 r² + l2 r⁴)."""
        return 1.0 / even(r, c[0], c[1])

    def slope(self, r: Any, c: Any) -> Any:
        """(1 − l1 r² − 3 l2 r⁴) / (1 + l1 r² + l2 r⁴)², negative beyond the pole."""
        below = even(r, c[0], c[1])
        return even(r, -c[0], -3 * c[1]) / (below * abs(below))

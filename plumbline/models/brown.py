"""The Brown–Conrady model of photogrammetry.

    p_ideal = p (1 + k1 r² + k2 r⁴ + k3 r⁶) + tangential(p1, p2),   p the observed point

    tangential = (2 p1 x y + p2 (r² + 2x²), p1 (r² + 2y²) + 2 p2 x y)

Direction: observed → ideal. Normalisation: r = 1 at half the shorter side; the scale is 1 at
the centre. Source: D. C. Brown, "Decentering distortion of lenses", 1966, and "Close-range
camera calibration", 1971; the order of p1 and p2 is OpenCV's.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from plumbline.models.base import Model
from plumbline.models.polynomials import even, even_slope


@dataclass(frozen=True)
class Brown(Model):
    """p_ideal = p (1 + k1 r² + k2 r⁴ + k3 r⁶) + tangential(p1, p2)."""

    name = "brown"
    direction = "observed to ideal"
    gauge = 0
    formula = "p_ideal = p (1 + k1 r² + k2 r⁴ + k3 r⁶) + tangential(p1, p2)"
    use = "Brown–Conrady, PC-Rect, photogrammetry"
    source = (
        "D. C. Brown, Decentering distortion of lenses, 1966, and Close-range camera "
        "calibration, 1971"
    )
    tangential = ("p1", "p2")

    @property
    def coefficients(self) -> tuple[str, ...]:
        """k1, k2, k3, p1, p2."""
        return "k1", "k2", "k3", "p1", "p2"

    def in_other_words(self, free: tuple[str, ...]) -> tuple[str, ...]:
        """The polynomial in even powers, where nothing else is free."""
        even_powers = dict(zip(self.radial, self.powers, strict=True))
        if not {*free} <= {*even_powers}:
            return ()
        return ("radial:" + ",".join(str(even_powers[name]) for name in free),)

    def factor(self, r: Any, c: Any) -> Any:
        """1 + k1 r² + k2 r⁴ + k3 r⁶."""
        return even(r, c[0], c[1], c[2])

    def slope(self, r: Any, c: Any) -> Any:
        """1 + 3 k1 r² + 5 k2 r⁴ + 7 k3 r⁶."""
        return even_slope(r, c[0], c[1], c[2])

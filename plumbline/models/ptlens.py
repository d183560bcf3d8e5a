"""The a, b, c polynomial of Panorama Tools.

    r_obs = r (a r³ + b r² + c r + 1 − a − b − c),   r the ideal radius

Direction: ideal → observed. Normalisation: r = 1 at half the shorter side, where the scale
is 1 whatever the coefficients. b < 0 is barrel distortion. Source: H. Dersch, Panorama Tools
(1998), `radial()` in libpano13; the same in ImageMagick's Barrel and LensFun's `ptlens`.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from plumbline.models.base import Model


@dataclass(frozen=True)
class PTLens(Model):
    """r_obs = r (a r³ + b r² + c r + 1 − a − b − c)."""

    name = "ptlens"
    direction = "ideal to observed"
    gauge = 1
    formula = "r_obs = r (a r³ + b r² + c r + 1 − a − b − c)"
    use = "Panorama Tools, Hugin, PTGui, PTLens, LensFun, ImageMagick Barrel"
    source = "H. Dersch, Panorama Tools, 1998; ImageMagick, Barrel; LensFun, model ptlens"

    of_ptlens = MappingProxyType({"a": "a", "b": "b", "c": "c"})

    @property
    def coefficients(self) -> tuple[str, ...]:
        """a, b, c."""
        return "a", "b", "c"

    @property
    def powers(self) -> tuple[int, ...]:
        """3, 2, 1."""
        return 3, 2, 1

    @property
    def next_powers(self) -> tuple[int, ...]:
        """4."""
        return (4,)

    def in_other_words(self, free: tuple[str, ...]) -> tuple[str, ...]:
        """With b alone it is LensFun's poly3."""
        return ("poly3",) if free == ("b",) else ()

    def factor(self, r: Any, c: Any) -> Any:
        """Value of a r³ + b r² + c r + 1 − a − b − c."""
        return ((c[0] * r + c[1]) * r + c[2]) * r + (1.0 - c[0] - c[1] - c[2])

    def slope(self, r: Any, c: Any) -> Any:
        """Value of 4a r³ + 3b r² + 2c r + 1 − a − b − c."""
        return ((4 * c[0] * r + 3 * c[1]) * r + 2 * c[2]) * r + (1.0 - c[0] - c[1] - c[2])

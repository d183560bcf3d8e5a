"""The general radial polynomial, with the powers of the user's choice.

    r_ideal = r (1 + Σ aₙ rⁿ),   r the observed radius

Direction: observed → ideal. Normalisation: r = 1 at half the shorter side; the scale is 1 at
the centre. `radial:2,4,6` is the even-power polynomial of optics, i.e. Brown–Conrady without
tangential terms (D. C. Brown, "Close-range camera calibration", 1971).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from plumbline.models.base import Model


@dataclass(frozen=True)
class Radial(Model):
    """r_ideal = r (1 + Σ aₙ rⁿ).

    Attributes:
        exponents: The powers n, rising; the coefficient of rⁿ is called `a<n>`.
    """

    exponents: tuple[int, ...] = (2, 4, 6)

    name = "radial"
    direction = "observed to ideal"
    gauge = 0
    formula = "r_ideal = r (1 + Σ aₙ rⁿ)"
    use = "the general polynomial; with even powers the one of optics"
    source = (
        "the general polynomial in r, see e.g. D. C. Brown, Close-range camera calibration, 1971"
    )

    @property
    def coefficients(self) -> tuple[str, ...]:
        """`a<n>` for every power n."""
        return tuple(f"a{power}" for power in self.exponents)

    @property
    def label(self) -> str:
        """`radial:` and the powers."""
        return "radial:" + ",".join(str(power) for power in self.exponents)

    @property
    def powers(self) -> tuple[int, ...]:
        """The powers of the user's choice."""
        return self.exponents

    @property
    def next_powers(self) -> tuple[int, ...]:
        """The next even power after even ones alone, else the next."""
        even = all(power % 2 == 0 for power in self.exponents)
        return (self.exponents[-1] + (2 if even else 1),)

    def factor(self, r: Any, c: Any) -> Any:
        """1 + Σ aₙ rⁿ."""
        return 1.0 + sum(c[i] * r**power for i, power in enumerate(self.exponents))

    def slope(self, r: Any, c: Any) -> Any:
        """1 + Σ (n + 1) aₙ rⁿ."""
        return 1.0 + sum((power + 1) * c[i] * r**power for i, power in enumerate(self.exponents))

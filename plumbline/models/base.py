"""What a distortion model is, and the mathematics that all of them share.

A model maps a point p, normalised and measured from the distortion centre, to

    m(p) = p · f(|p|) + tangential(p1, p2)                                          (1)

in its own direction, ideal → observed or observed → ideal. The opposite direction is solved
by Newton steps on (1). Everything here needs only the array's own operations and its
namespace, so it runs on NumPy and JAX arrays alike, and nothing here imports JAX.

To add a model: write one file with a frozen subclass of `Model` that gives `factor` and
`slope`; name its coefficients, direction, gauge and unit, and its powers of r where they are not
2, 4, …; add its row to `MODELS` in
`plumbline/models/__init__.py`. The property tests find it there.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

Direction = Literal["ideal to observed", "observed to ideal"]
Unit = Literal["half the shorter side", "focal length"]


@dataclass(frozen=True)
class Model(ABC):
    """A distortion model; immutable and hashable, so that compiled programs can key on it.

    Attributes:
        name: Name in `MODELS` and on the command line.
        coefficients: Names of the coefficients, the distortion centre `d`, `e` left out.
        direction: Which way the polynomial runs.
        gauge: The normalised radius where the scale is 1: f(0) = 1 or f(1) = 1.
        unit: What a normalised radius of 1 stands for.
        tangential: Names of the two decentring coefficients, or empty.
        formula: The equation, for people.
        use: Who uses it, for people.
        source: Where it is described.
    """

    name: ClassVar[str]
    direction: ClassVar[Direction]
    gauge: ClassVar[Literal[0, 1]]
    formula: ClassVar[str]
    use: ClassVar[str]
    source: ClassVar[str]
    unit: ClassVar[Unit] = "half the shorter side"
    tangential: ClassVar[tuple[str, ...]] = ()

    @property
    def powers(self) -> tuple[int, ...]:
        """Power of r for each radial coefficient, in their order; even ones for most models."""
        return tuple(2 * (i + 1) for i in range(len(self.radial)))

    @property
    def next_powers(self) -> tuple[int, ...]:
        """Powers of r that the next richer model has besides."""
        return (max(self.powers) + 2,)

    @property
    def radial(self) -> tuple[str, ...]:
        """Names of the coefficients that are not decentring ones."""
        return tuple(name for name in self.coefficients if name not in self.tangential)

    def richer(self, free: tuple[str, ...]) -> tuple[int, ...]:
        """Powers of r that a fit of `free` lacks: the held ones, else the next richer model's."""
        held = [p for n, p in zip(self.radial, self.powers, strict=True) if n not in free]
        return tuple(held) or self.next_powers

    @property
    @abstractmethod
    def coefficients(self) -> tuple[str, ...]:
        """Names of the coefficients in the order that the methods below take them."""

    @property
    def label(self) -> str:
        """The name that selects this model."""
        return self.name

    @abstractmethod
    def factor(self, r: Any, c: Any) -> Any:
        """f(r) of equation (1) for radii `r` and coefficients `c` (indexable, in order)."""

    @abstractmethod
    def slope(self, r: Any, c: Any) -> Any:
        """Derivative of r·f(r) by r; the distortion folds where it is not positive."""

    def decentring(self, c: Any) -> tuple[Any, Any] | None:
        """(p1, p2) of the tangential terms, or None where the model has none."""
        if not self.tangential:
            return None
        first, second = (self.coefficients.index(name) for name in self.tangential)
        return c[first], c[second]

    def apply(self, x: Any, y: Any, c: Any) -> tuple[Any, Any]:
        """Equation (1): map a point in the model's own direction."""
        f = self.factor(radius(x, y), c)
        shift = self.decentring(c)
        if shift is None:
            return x * f, y * f
        (p1, p2), r2 = shift, x * x + y * y
        dx = 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
        dy = p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
        return x * f + dx, y * f + dy

    def jacobian(self, x: Any, y: Any, c: Any) -> tuple[Any, Any, Any, Any]:
        """Derivative of `apply` by the point: (∂x'/∂x, ∂x'/∂y, ∂y'/∂x, ∂y'/∂y)."""
        r = radius(x, y)
        f = self.factor(r, c)
        xp = r.__array_namespace__()
        bend = (self.slope(r, c) - f) / xp.where(r > 0, r * r, 1.0)
        xx, xy, yy = f + bend * x * x, bend * x * y, f + bend * y * y
        shift = self.decentring(c)
        if shift is None:
            return xx, xy, xy, yy
        p1, p2 = shift
        cross = 2 * (p1 * x + p2 * y)
        return xx + 2 * p1 * y + 6 * p2 * x, xy + cross, xy + cross, yy + 6 * p1 * y + 2 * p2 * x


def radius(x: Any, y: Any) -> Any:
    """√(x² + y²) with a derivative of 0 rather than NaN at the origin."""
    xp = x.__array_namespace__()
    r2 = x * x + y * y
    return xp.where(r2 > 0, xp.sqrt(xp.where(r2 > 0, r2, 1.0)), 0.0)


def even(r: Any, *k: Any) -> Any:
    """1 + k₁ r² + k₂ r⁴ + …, the factor that most models share."""
    r2 = r * r
    total = k[-1] * r2
    for coefficient in reversed(k[:-1]):
        total = (coefficient + total) * r2
    return 1.0 + total


def even_slope(r: Any, *k: Any) -> Any:
    """Derivative of r · `even`: 1 + 3 k₁ r² + 5 k₂ r⁴ + …."""
    return even(r, *((2 * i + 3) * coefficient for i, coefficient in enumerate(k)))

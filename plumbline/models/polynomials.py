"""What the models' equations share: the radius and the polynomial in even powers of it."""

from __future__ import annotations

from typing import Any


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

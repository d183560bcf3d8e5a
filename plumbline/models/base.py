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
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType
from typing import Any, ClassVar, Literal, final

import numpy as np

from plumbline.frame import Array
from plumbline.models.inverse import first_fold, invert
from plumbline.models.polynomials import radius

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
        of_ptlens: Which of its coefficients are which of Panorama Tools' a, b, c, where the model
            is that one or a special case of it; else empty.
    """

    name: ClassVar[str]
    direction: ClassVar[Direction]
    gauge: ClassVar[Literal[0, 1]]
    formula: ClassVar[str]
    use: ClassVar[str]
    source: ClassVar[str]
    unit: ClassVar[Unit] = "half the shorter side"
    tangential: ClassVar[tuple[str, ...]] = ()
    of_ptlens: ClassVar[Mapping[str, str]] = MappingProxyType({})

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

    @property
    @final
    def takes_observed(self) -> bool:
        """Whether the polynomial takes the observed point and yields the ideal one."""
        return self.direction == "observed to ideal"

    @final
    def distort(self, ideal: Array, c: Any, reach: float) -> Array:
        """Map ideal points to observed ones.

        Args:
            ideal: Normalised, from the distortion centre, shape (..., 2).
            c: The coefficients, in order.
            reach: The largest radius that is looked at, see `invert`.

        Returns:
            Observed points, same shape; NaN beyond the fold of the model.
        """
        if self.takes_observed:
            return invert(self, c, ideal, reach)
        return self._within_fold(ideal, c, reach)

    @final
    def undistort(self, observed: Array, c: Any, reach: float) -> Array:
        """Map observed points to ideal ones; arguments and result as for `distort`."""
        if self.takes_observed:
            return self._within_fold(observed, c, reach)
        return invert(self, c, observed, reach)

    @final
    def argument(self, observed: Any, ideal: Any) -> Any:
        """Whichever of the two the polynomial takes."""
        return observed if self.takes_observed else ideal

    @final
    def as_ideal_motion(self, moved: Array, stretch: Array) -> Array:
        """How ideal points of given observed ones move where the polynomial's value moves.

        Args:
            moved: Motion of the polynomial's value, shape (n, 2).
            stretch: Derivative of the ideal points by the observed ones, shape (n, 2, 2).
        """
        return moved if self.takes_observed else -np.einsum("nij,nj->ni", stretch, moved)

    @final
    def stretch(self, observed: Array, ideal: Array, c: Any) -> Array:
        """Derivative of ideal points by observed ones, normalised and from the centre.

        Args:
            observed: Shape (n, 2).
            ideal: The same undistorted, shape (n, 2).
            c: The coefficients, each a number or of shape (n,).

        Returns:
            Shape (n, 2, 2), rows for the ideal point.
        """
        x, y = self.argument(observed, ideal).T
        xx, xy, yx, yy = self.jacobian(x, y, c)
        if not self.takes_observed:
            determinant = xx * yy - xy * yx
            with np.errstate(divide="ignore", invalid="ignore"):
                xx, xy, yx, yy = (v / determinant for v in (yy, -xy, -yx, xx))
        return np.stack((xx, xy, yx, yy), axis=-1).reshape(-1, 2, 2)

    @final
    def observed_fold(self, c: Any, reach: float) -> float | None:
        """The observed radius at which the model folds, normalised; None if beyond `reach`."""
        fold = first_fold(self, c, reach)
        if fold is None or self.takes_observed:
            return fold
        return fold * float(self.factor(np.float64(fold), c))

    @final
    def central_scale(self, c: Any) -> float:
        """Observed over ideal radius at the centre."""
        scale = float(self.factor(np.float64(0.0), c))
        return 1 / scale if self.takes_observed else scale

    def curve_miss(self, observed: Any, ideal: Any, c: Any) -> Any:
        """By how much radii miss the model's curve, in a form that is linear in coefficients."""
        r = self.argument(observed, ideal)
        return r * self.factor(r, c) - self.argument(ideal, observed)

    def in_other_words(self, free: tuple[str, ...]) -> tuple[str, ...]:  # noqa: ARG002
        """Fits of other models that are the same as this one with `free` fitted, the rest 0."""
        return ()

    @final
    def decentred(self, free: tuple[str, ...]) -> bool:
        """Whether tangential terms are among the coefficients."""
        return not set(self.tangential).isdisjoint(free)

    @final
    def ptlens_values(self, coefficients: Mapping[str, float]) -> dict[str, float] | None:
        """a, b and c of Panorama Tools, or None where the model has no such form."""
        if not self.of_ptlens:
            return None
        own = {theirs: mine for mine, theirs in self.of_ptlens.items()}
        return {name: coefficients[own[name]] if name in own else 0.0 for name in ("a", "b", "c")}

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

    def _within_fold(self, points: Array, c: Any, reach: float) -> Array:
        """`apply`, NaN beyond the fold, which is looked for as far out as there are points."""
        x, y = points[..., 0], points[..., 1]
        r = np.hypot(x, y)
        farthest = float(np.max(r, initial=0.0, where=np.isfinite(r)))
        mapped = np.stack(self.apply(x, y, c), axis=-1)
        fold = _known_fold(self, tuple(np.asarray(c).tolist()), max(reach, farthest))
        if fold is not None:
            mapped[r > fold] = np.nan
        return mapped


@lru_cache(maxsize=64)
def _known_fold(model: Model, coefficients: tuple[float, ...], reach: float) -> float | None:
    """`first_fold`, kept: a picture is mapped tile by tile with one lens."""
    return first_fold(model, np.array(coefficients), reach)

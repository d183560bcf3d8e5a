"""Simulated photos of straight edges: a true lens, true lines, and as many noisy picks as wanted.

The forward model is `tests.truth`, written from the equations alone; plumbline's is never used.
Everything is drawn from seeds that hang on the group's name alone, so that a group stays the same
whatever is added beside it, and trial k is the same however many trials are drawn.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tests.truth import Array, TrueLens

_SAMPLES = 1500
_CLEAR = 5.5
"""Standard deviations that a true point keeps from the photo's edge: no pick may leave it."""


@dataclass(frozen=True)
class Layout:
    """How the lines lie and how many picks they get.

    Attributes:
        name: For people.
        n_lines: Number of lines.
        fewest: Least picks on one line.
        most: Most picks on one line.
        reach: Part of the photo's width, from the left, that has lines.
        slanted: Whether lines run in all directions, rather than along the photo's sides.
        paired: Whether two lines at a time lie close together, as both edges of a frame do.
        gap: How far these are apart, as a share of the photo's side.
    """

    name: str
    n_lines: int
    fewest: int
    most: int
    reach: float = 1.0
    slanted: bool = False
    paired: bool = False
    gap: float = 0.03


class TrueLine(NamedTuple):
    """A straight line of the ideal plane and the places on it where picks belong.

    Attributes:
        origin_px: A point on it, ideal, pixels.
        along: Its direction, a unit vector.
        places_px: Distance of every pick from the origin, ideal pixels, in order.
    """

    origin_px: Array
    along: Array
    places_px: Array

    @property
    def ideal_px(self) -> Array:
        """The ideal points, shape (n, 2)."""
        return self.origin_px + self.places_px[:, None] * self.along


@dataclass(frozen=True)
class Group:
    """Trials that differ by their noise alone.

    Attributes:
        lens_name: For people.
        lens: The truth.
        layout: Of the lines.
        noise_px: Standard deviation of the picks, in x and in y.
        model: The model that is fitted.
        free: The coefficients that are fitted; None for all of the model's.
    """

    lens_name: str
    lens: TrueLens
    layout: Layout
    noise_px: float
    model: str = "ptlens"
    free: tuple[str, ...] | None = None

    @property
    def name(self) -> str:
        """Lens, layout, noise and, where it is not ptlens' a, b, c, what is fitted."""
        fitted = "" if self.model == "ptlens" else f", {self.model}"
        freed = f" {','.join(self.free)}" if self.free else ""
        return f"{self.lens_name}, {self.layout.name}, {self.noise_px:g} px{fitted}{freed}"

    @property
    def true_family(self) -> bool:
        """Whether the fitted model is the one of the truth."""
        return self.model == self.lens.name

    @cached_property
    def lines(self) -> tuple[TrueLine, ...]:
        """The true lines."""
        rng = np.random.default_rng(self._seed("lines"))
        return tuple(_line(self, index, rng) for index in range(self.layout.n_lines))

    @cached_property
    def true_px(self) -> Array:
        """The true observed points of all lines, one after another, shape (n, 2)."""
        return self.lens.distort(np.concatenate([line.ideal_px for line in self.lines]))

    @cached_property
    def ends(self) -> NDArray[np.int64]:
        """Where every line but the last ends among the points."""
        return np.cumsum([len(line.places_px) for line in self.lines])[:-1]

    @cached_property
    def line_of(self) -> NDArray[np.int64]:
        """The number of each point's line, shape (n,)."""
        sizes = [len(line.places_px) for line in self.lines]
        return np.repeat(np.arange(len(sizes)), sizes)

    @cached_property
    def across(self) -> Array:
        """Unit vectors across the observed curves at the true points, shape (n, 2)."""
        step = 0.05
        ends = [
            self.lens.distort(
                np.concatenate([line.ideal_px + sign * step * line.along for line in self.lines])
            )
            for sign in (1.0, -1.0)
        ]
        tangent = ends[0] - ends[1]
        return tangent[:, ::-1] * np.array([-1.0, 1.0]) / np.hypot(*tangent.T)[:, None]

    @property
    def n_points(self) -> int:
        """Number of points on all lines."""
        return len(self.line_of)

    def picks_px(self, trials: int, purpose: str = "noise") -> Array:
        """Noisy picks, shape (trials, n, 2); another purpose gives other noise."""
        rng = np.random.default_rng(self._seed(purpose))
        return self.true_px + self.noise_px * rng.standard_normal((trials, self.n_points, 2))

    def by_line(self, points_px: Array) -> list[Array]:
        """Points, shape (n, 2), line after line."""
        return np.split(points_px, self.ends)

    def rng(self, purpose: str, trial: int) -> np.random.Generator:
        """A generator for what else is random in one trial."""
        return np.random.default_rng((*self._seed(purpose), trial))

    def _seed(self, purpose: str) -> tuple[int, int]:
        return zlib.crc32(self.name.encode()), zlib.crc32(purpose.encode())


def _line(group: Group, index: int, rng: np.random.Generator) -> TrueLine:
    """One straight line through the ideal images of two observed points."""
    lens, layout = group.lens, group.layout
    first, last = lens.undistort(_ends(layout, index, rng) * (np.array(lens.size) - 1.0))
    length = float(np.hypot(*(last - first)))
    along = (last - first) / length
    places = np.linspace(0.0, length, _SAMPLES)
    seen = lens.distort(first + places[:, None] * along)
    clear = _CLEAR * group.noise_px
    shown = np.all((seen >= clear) & (seen <= np.array(lens.size) - 1.0 - clear), axis=-1)
    places = places[shown]
    wanted = int(rng.integers(layout.fewest, layout.most + 1))
    shares = (np.arange(wanted) + rng.uniform(-0.3, 0.3, wanted)).clip(0, wanted - 1)
    chosen = np.interp(shares / (wanted - 1), np.linspace(0, 1, len(places)), places)
    return TrueLine(first, along, chosen)


def _ends(layout: Layout, index: int, rng: np.random.Generator) -> Array:
    """Observed ends of a line as shares of the photo's width and height, shape (2, 2)."""
    upright = index % 2 == 1
    of_its_kind = index // 2
    share = (of_its_kind + 0.5) / ((layout.n_lines + (0 if upright else 1)) // 2)
    if layout.paired:
        share = (of_its_kind // 2 + 0.5) / (layout.n_lines // 4) + layout.gap * (of_its_kind % 2)
    loose = 0.002 if layout.paired else 0.02
    at = 0.025 + 0.95 * share + rng.uniform(-loose, loose)
    most = 0.3 if layout.slanted else 0.002 if layout.paired else 0.03
    tilt = rng.uniform(-most, most)
    start, stop = rng.uniform(0.02, 0.12), rng.uniform(0.88, 0.98)
    ends = np.array([[start, at - tilt], [stop, at + tilt]]).clip(0.015, 0.985)
    ends = ends[:, ::-1] if upright else ends
    return ends * np.array([layout.reach, 1.0])

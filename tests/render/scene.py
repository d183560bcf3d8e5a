"""A modern façade: what is painted on the wall, and the straight edges that are really there."""

from dataclasses import dataclass, field
from itertools import pairwise
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.uint8]
Colour = tuple[int, int, int]
Axis = Literal["h", "v"]
Span = tuple[float, float]

TEXELS = 100  # a metre
MARGIN = 14.0  # metres of neighbouring house painted on either side
SKY_MARGIN = 1.0
PLINTH = 0.6


@dataclass(frozen=True)
class Edge:
    """A straight edge of the façade: its level in metres, and where along it the eye can see it."""

    name: str
    axis: Axis
    level: float
    spans: tuple[Span, ...]

    def points(self, along: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the wall points (right, up) at these positions along the edge."""
        level = np.full_like(along, self.level)
        return np.stack([along, level] if self.axis == "h" else [level, along], axis=-1)


@dataclass(frozen=True)
class Facade:
    """The measures (metres) and colours of one façade; its left foot is the origin."""

    bays: int = 12
    storeys: int = 6
    bay: float = 3.0
    storey: float = 3.2
    ground: float = 4.2
    window: tuple[float, float] = (1.9, 1.9)
    sill: float = 0.7
    pier_every: int = 3
    pier: float = 0.4
    band: float = 0.24
    cornice: float = 0.7
    wall: Colour = (196, 188, 176)
    trim: Colour = (226, 222, 214)
    frame: Colour = (52, 54, 58)
    neighbours: tuple[Colour, Colour] = ((158, 112, 92), (172, 166, 150))
    neighbour_heights: tuple[float, float] = (13.0, 20.0)
    seed: int = 1

    @property
    def width(self) -> float:
        return self.bays * self.bay

    @property
    def height(self) -> float:
        return self.ground + self.storeys * self.storey + self.cornice

    def window_corner(self, row: int, column: int) -> tuple[float, float]:
        """Return the top-left corner of a window; row 0 is the uppermost."""
        left = column * self.bay + (self.bay - self.window[0]) / 2
        floor = self.ground + (self.storeys - 1 - row) * self.storey
        return left, floor + self.sill + self.window[1]

    def piers(self) -> list[Span]:
        """Return the left and right side of every pier."""
        at = [column * self.bay for column in range(0, self.bays + 1, self.pier_every)]
        return [(x - self.pier / 2, x + self.pier / 2) for x in at]

    def has_door(self, column: int) -> bool:
        """Tell whether the ground floor has a door there, which interrupts the plinth."""
        return column % 5 == 2

    def plinth(self) -> tuple[Span, ...]:
        """Return the stretches of the plinth between doors and piers."""
        plain = [column for column in range(self.bays) if not self.has_door(column)]
        return tuple((x * self.bay + 0.55, (x + 1) * self.bay - 0.3) for x in plain)

    def edges(self) -> list[Edge]:
        """Return every edge that a careful person would pick points along."""
        piers = self.piers()
        between = tuple((a[1] + 0.25, b[0]) for a, b in pairwise(piers))
        high = self.height - self.cornice
        found = [
            Edge("cornice foot", "h", high, between),
            Edge("cornice top", "h", self.height, ((0.0, self.width),)),
            Edge("plinth top", "h", PLINTH, self.plinth()),
        ]
        for storey in range(self.storeys):
            level = self.ground + storey * self.storey + self.band
            found.append(Edge(f"string course {storey}", "h", level, between))
        columns, rows = range(self.bays), range(self.storeys)
        for row in rows:
            top = self.window_corner(row, 0)[1]
            lefts = [self.window_corner(row, column)[0] for column in columns]
            spans = tuple((x, x + self.window[0]) for x in lefts)
            found.append(Edge(f"window heads {row}", "h", top, spans))
            found.append(Edge(f"window sills {row}", "h", top - self.window[1], spans))
        for column in columns:
            left = self.window_corner(0, column)[0]
            tops = [self.window_corner(row, column)[1] for row in reversed(rows)]
            spans = tuple((y - self.window[1], y) for y in tops)
            found.append(Edge(f"window left {column}", "v", left, spans))
            found.append(Edge(f"window right {column}", "v", left + self.window[0], spans))
        for number, (left, right) in enumerate(piers):
            found.append(Edge(f"pier left {number}", "v", left, ((PLINTH, high),)))
            found.append(Edge(f"pier right {number}", "v", right, ((PLINTH, high),)))
        return found


@dataclass
class Canvas:
    """A painted wall: metres in, texels out; texel edges fall on whole centimetres."""

    facade: Facade
    rgb: Picture = field(init=False)
    solid: Picture = field(init=False)

    def __post_init__(self) -> None:
        top = max(self.facade.height, *self.facade.neighbour_heights) + SKY_MARGIN
        self.top = top
        shape = round(top * TEXELS), round((self.facade.width + 2 * MARGIN) * TEXELS)
        self.rgb = np.zeros((*shape, 3), np.uint8)
        self.solid = np.zeros(shape, np.uint8)

    def to_texels(
        self, x: NDArray[np.float64], y: NDArray[np.float64]
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Map wall metres to texel-centre coordinates."""
        u = (x + MARGIN) * TEXELS - 0.5
        v = (self.top - y) * TEXELS - 0.5
        return u.astype(np.float32), v.astype(np.float32)

    def box(self, x: float, y: float, w: float, h: float) -> tuple[slice, slice]:
        """Return the texels of a rectangle whose lower left corner is (x, y)."""
        u0, u1 = round((x + MARGIN) * TEXELS), round((x + w + MARGIN) * TEXELS)
        v0, v1 = round((self.top - y - h) * TEXELS), round((self.top - y) * TEXELS)
        rows, columns = self.solid.shape
        return slice(max(v0, 0), min(v1, rows)), slice(max(u0, 0), min(u1, columns))

    def fill(self, x: float, y: float, w: float, h: float, colour: Colour) -> None:
        self.rgb[self.box(x, y, w, h)] = colour
        self.solid[self.box(x, y, w, h)] = 255

    def shade(self, x: float, y: float, w: float, h: float, light: float) -> None:
        """Multiply what is there by a constant: a shadow below 1."""
        part = self.rgb[self.box(x, y, w, h)]
        part[...] = np.clip(part * light, 0, 255).astype(np.uint8)


def clouds(
    shape: tuple[int, int], rng: np.random.Generator, cells: int = 4, octaves: int = 5
) -> NDArray[np.float64]:
    """Return fractal noise of mean 0 and about unit size."""
    total = np.zeros(shape)
    for octave in range(octaves):
        rows = cells * 2**octave
        columns = max(2, rows * shape[1] // shape[0])
        coarse = rng.standard_normal((rows + 1, columns + 1))
        total += cv2.resize(coarse, shape[::-1], interpolation=cv2.INTER_CUBIC) / 2**octave
    return total / total.std()

"""Paints a façade: cladding, windows that mirror the sky, string courses, piers and neighbours."""

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from .scene import MARGIN, PLINTH, Canvas, Colour, Facade, clouds

Mirror = NDArray[np.float32]

PANE = (112.0, 140.0, 166.0)


def shaded(colour: Colour, light: float) -> Colour:
    """Return the colour made lighter or darker."""
    red, green, blue = (int(np.clip(part * light, 0, 255)) for part in colour)
    return red, green, blue


@lru_cache(maxsize=1)
def paint(facade: Facade) -> Canvas:
    """Return the painted wall, neighbours included."""
    rng = np.random.default_rng(facade.seed)
    canvas = Canvas(facade)
    mirror = _mirror(canvas, rng)
    _neighbours(canvas, rng, mirror)
    _cladding(canvas, rng)
    for row in range(facade.storeys):
        for column in range(facade.bays):
            left, top = facade.window_corner(row, column)
            _window(canvas, rng, mirror, left, top)
    _ground_floor(canvas, rng, mirror)
    _trim(canvas)
    grime = 1 + 0.02 * _spread(canvas, clouds((120, 240), rng, cells=3))
    for channel in range(3):
        plane = canvas.rgb[..., channel]
        plane[...] = np.clip(plane * grime, 0, 255).astype(np.uint8)
    return canvas


def _spread(canvas: Canvas, picture: NDArray[np.float64]) -> NDArray[np.float32]:
    rows, columns = canvas.solid.shape
    small = picture.astype(np.float32)
    return np.asarray(cv2.resize(small, (columns, rows), interpolation=cv2.INTER_CUBIC), np.float32)


def _glaze(
    canvas: Canvas, x: float, y: float, w: float, h: float, mirror: Mirror, light: float
) -> None:
    """Fill a pane with its part of the mirrored sky."""
    where = canvas.box(x, y, w, h)
    pane = light * mirror[where][..., None] * np.array(PANE, np.float32)
    canvas.rgb[where] = np.clip(pane, 0, 255).astype(np.uint8)


def _mirror(canvas: Canvas, rng: np.random.Generator) -> Mirror:
    """The sky and the opposite roofs, as they stand in the window panes."""
    rows, columns = canvas.solid.shape
    height = np.linspace(1, 0, rows, dtype=np.float32)[:, None]
    cloud = _spread(canvas, clouds((rows // 8, columns // 8), rng, cells=3))
    light = 0.45 + 0.5 * height + 0.11 * cloud
    roofs = np.repeat(rng.uniform(0.16, 0.34, columns // 700 + 1), 700)[:columns]
    return np.where(height < roofs[None, :], 0.32 + 0.03 * cloud, light)


def _cladding(canvas: Canvas, rng: np.random.Generator) -> None:
    facade = canvas.facade
    canvas.fill(0, 0, facade.width, facade.height, facade.wall)
    for storey in range(facade.storeys):
        floor = facade.ground + storey * facade.storey
        for half in range(2 * facade.bays):
            x, w = half * facade.bay / 2, facade.bay / 2
            for y, h in (
                (floor, facade.storey / 2),
                (floor + facade.storey / 2, facade.storey / 2),
            ):
                canvas.shade(x, y, w, h, rng.uniform(0.955, 1.02))
                canvas.shade(x, y, 0.02, h, 0.72)
                canvas.shade(x, y, w, 0.02, 0.72)


def _window(
    canvas: Canvas, rng: np.random.Generator, mirror: Mirror, left: float, top: float
) -> None:
    facade = canvas.facade
    wide, high = facade.window
    foot = top - high
    canvas.fill(left, foot, wide, high, facade.frame)
    panes = ((left + 0.08, wide * 0.34 - 0.1), (left + wide * 0.34 + 0.04, wide * 0.66 - 0.12))
    for number, (x, w) in enumerate(panes):
        _glaze(canvas, x, foot + 0.08, w, high - 0.16, mirror, rng.uniform(0.86, 1.08))
        if rng.random() < (0.22, 0.34)[number]:
            drop = float(rng.choice([0.3, 0.5, 0.7, 0.95])) * (high - 0.16)
            canvas.fill(x, top - 0.08 - drop, w, drop, (196, 194, 186))
            for slat in np.arange(0.0, drop, 0.1):
                canvas.shade(x, top - 0.08 - drop + float(slat), w, 0.03, 0.86)
    canvas.shade(left, top - 0.16, wide, 0.16, 0.5)
    canvas.shade(left, foot, 0.08, high, 0.6)
    canvas.fill(left - 0.06, foot - 0.08, wide + 0.12, 0.08, shaded(facade.trim, 1.04))
    canvas.shade(left - 0.06, foot - 0.14, wide + 0.12, 0.06, 0.62)


def _ground_floor(canvas: Canvas, rng: np.random.Generator, mirror: Mirror) -> None:
    facade = canvas.facade
    canvas.fill(0, 0, facade.width, facade.ground, shaded(facade.wall, 0.72))
    for column in range(facade.bays):
        x = column * facade.bay + 0.35
        w = facade.bay - 0.7
        door = facade.has_door(column)
        foot = 0.1 if door else PLINTH
        canvas.fill(x, foot, w, 3.1 - foot, facade.frame)
        for part in range(2):
            pane = x + 0.07 + part * w / 2
            light = 0.7 * rng.uniform(0.8, 1.1)
            _glaze(canvas, pane, foot + 0.08, w / 2 - 0.14, 3.1 - foot - 0.16, mirror, light)
        if not door and rng.random() < 0.6:
            awning = ((150, 60, 48), (60, 92, 110), (88, 104, 70))[int(rng.integers(3))]
            canvas.fill(x, 2.62, w, 0.48, awning)
        canvas.shade(x, 2.95, w, 0.15, 0.6)
    canvas.fill(0, 3.3, facade.width, 0.5, shaded(facade.wall, 0.5))
    canvas.fill(0, 0, facade.width, 0.1, (84, 82, 80))
    for column in range(facade.bays):
        if not facade.has_door(column):
            canvas.fill(column * facade.bay, 0.1, facade.bay, PLINTH - 0.1, (112, 108, 104))


def _trim(canvas: Canvas) -> None:
    facade = canvas.facade
    high = facade.height - facade.cornice
    for storey in range(facade.storeys):
        level = facade.ground + storey * facade.storey
        canvas.fill(0, level, facade.width, facade.band, facade.trim)
        canvas.shade(0, level - 0.12, facade.width, 0.12, 0.6)
    for step in range(5):
        canvas.shade(0, high - 0.1 * (step + 1), facade.width, 0.1, 0.5 + 0.1 * step)
    for left, right in facade.piers():
        canvas.fill(left, 0, right - left, high, shaded(facade.trim, 0.94))
        for step in range(3):
            canvas.shade(right + 0.08 * step, 0.0, 0.08, high, 0.58 + 0.13 * step)
        canvas.shade(left, high - 0.3, right - left, 0.3, 0.72)
    canvas.fill(-0.3, high, facade.width + 0.6, facade.cornice, facade.trim)
    canvas.shade(-0.3, high, facade.width + 0.6, facade.cornice * 0.3, 0.88)
    canvas.shade(-0.3, facade.height - 0.08, facade.width + 0.6, 0.08, 0.7)


def _neighbours(canvas: Canvas, rng: np.random.Generator, mirror: Mirror) -> None:
    """Plain houses to the left and right, so that the street does not end."""
    facade = canvas.facade
    for side, (colour, tall) in enumerate(
        zip(facade.neighbours, facade.neighbour_heights, strict=True)
    ):
        start = -MARGIN if side == 0 else facade.width
        canvas.fill(start, 0, MARGIN, tall, colour)
        for row in range(int((tall - 1.5) // 3)):
            for column in range(int(MARGIN // 2.6)):
                x, y = start + 0.8 + 2.6 * column, 1.0 + 3.0 * row
                canvas.fill(x, y, 1.1, 1.7, (206, 200, 190))
                _glaze(canvas, x + 0.1, y + 0.1, 0.9, 1.5, mirror, rng.uniform(0.7, 1.0))
                canvas.shade(x, y + 1.58, 1.1, 0.12, 0.6)
        canvas.shade(start, tall - 0.3, MARGIN, 0.3, 0.7)

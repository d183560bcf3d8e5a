"""Photographs of a flat wall whose edges are known to a thousandth of a pixel.

A wall is painted as rectangles in metres. Each is blurred by the optics in closed form, in linear
light, where the lens shows it: its coverage is a difference of normal distributions of the
distance from its sides in pixels. So edges stand where the formula says, whatever the blur.
"""

from dataclasses import dataclass, field, replace

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from .optics import Array, View
from .scene import Edge, Picture

Layer = NDArray[np.float32]

REACH = 5.0  # standard deviations beyond which a blurred side is black or white


@dataclass(frozen=True)
class Patch:
    """A rectangle of the wall: its sides in metres, right and up, and its linear light, 0 to 1."""

    left: float
    right: float
    foot: float
    top: float
    light: tuple[float, float, float]


@dataclass(frozen=True)
class Wall:
    """What is painted, back to front, and the straight edges that are there."""

    patches: tuple[Patch, ...]
    edges: tuple[Edge, ...]
    behind: tuple[float, float, float] = (0.35, 0.45, 0.6)


@dataclass(frozen=True)
class Camera:
    """How a wall is photographed.

    Attributes:
        view: Lens, pose and size.
        blur_px: Standard deviation of the blur at the centre and in the corner, the pixel's own
            width included.
        noise: Standard deviation of the noise, grey levels of 255.
        sharpening: Amount of unsharp masking; 0 for none.
        quality: Of the JPEG; 0 for none.
        sampling_420: Whether the JPEG halves its colours.
        exposure: Factor on all light.
        falloff: Share of the light that is lost in the corner.
        red_shift: Radial magnification of red less that of green.
        blue_shift: The same of blue.
    """

    view: View
    blur_px: tuple[float, float] = (0.7, 0.7)
    noise: float = 1.0
    sharpening: float = 0.0
    quality: int = 0
    sampling_420: bool = False
    exposure: float = 1.0
    falloff: float = 0.0
    red_shift: float = 0.0
    blue_shift: float = 0.0
    seed: int = 0


@dataclass
class _Canvas:
    """Where every pixel meets the wall, and how fast that changes from pixel to pixel."""

    view: View
    scale: float
    x: Layer = field(init=False)
    y: Layer = field(init=False)
    per_px_x: Layer = field(init=False)
    per_px_y: Layer = field(init=False)

    def __post_init__(self) -> None:
        view, pose = self.view, self.view.pose
        at = np.stack(np.meshgrid(np.arange(view.width), np.arange(view.height)), axis=-1)
        rays = view.rays(view.centre + (at - view.centre) / self.scale)
        ahead = np.where(rays[..., 2] > 1e-6, rays[..., 2], np.nan)
        x = pose.x + pose.distance * rays[..., 0] / ahead
        y = pose.eye - pose.distance * rays[..., 1] / ahead
        self.x, self.y = x.astype(np.float32), y.astype(np.float32)
        self.per_px_x, self.per_px_y = _steepness(x), _steepness(y)

    def box(self, patch: Patch, blur_px: float) -> tuple[slice, slice]:
        """Return the pixels that a patch may reach."""
        along = np.linspace(0, 1, 60)
        wide = patch.left + (patch.right - patch.left) * along
        high = patch.foot + (patch.top - patch.foot) * along
        sides = [np.stack([wide, np.full(60, y)], -1) for y in (patch.foot, patch.top)]
        sides += [np.stack([np.full(60, x), high], -1) for x in (patch.left, patch.right)]
        seen = self.view.project(np.concatenate(sides))
        seen = self.view.centre + (seen - self.view.centre) * self.scale
        if np.isnan(seen).any():
            return slice(0, self.view.height), slice(0, self.view.width)
        reach = REACH * blur_px + 2
        (x0, y0), (x1, y1) = seen.min(0) - reach, seen.max(0) + reach
        rows = slice(max(0, int(y0)), max(0, min(self.view.height, int(y1) + 1)))
        return rows, slice(max(0, int(x0)), max(0, min(self.view.width, int(x1) + 1)))


def _steepness(values: Array) -> Layer:
    """Return the length of the gradient."""
    down, across = np.gradient(values)
    return np.hypot(down, across).astype(np.float32)


def _between(at: Layer, low: float, high: float, width: Layer) -> Layer:
    return np.asarray(ndtr((at - low) / width) - ndtr((at - high) / width), np.float32)


def _painted(camera: Camera, wall: Wall, channels: tuple[int, ...], scale: float) -> Layer:
    canvas = _Canvas(camera.view, scale)
    shape = canvas.x.shape
    light = np.empty((*shape, len(channels)), np.float32)
    light[...] = [wall.behind[c] for c in channels]
    far = _far(camera.view).astype(np.float32)
    centre, corner = camera.blur_px
    blur = centre + (corner - centre) * far**2
    for patch in wall.patches:
        where = canvas.box(patch, max(camera.blur_px))
        if canvas.x[where].size == 0:
            continue
        sigma = blur[where]
        cover = _between(canvas.x[where], patch.left, patch.right, sigma * canvas.per_px_x[where])
        cover *= _between(canvas.y[where], patch.foot, patch.top, sigma * canvas.per_px_y[where])
        colour = np.array([patch.light[c] for c in channels], np.float32)
        light[where] += np.nan_to_num(cover)[..., None] * (colour - light[where])
    return light


def _far(view: View) -> Array:
    """Return the distance from the centre of every pixel, 1 in the corner."""
    y, x = np.mgrid[: view.height, : view.width]
    return np.hypot(x - view.centre[0], y - view.centre[1]) / np.hypot(*view.centre)


def linear_light(camera: Camera, wall: Wall) -> Layer:
    """Return what falls on the sensor without noise: red, green, blue, linear, shape (h, w, 3)."""
    if camera.red_shift == 0 == camera.blue_shift:
        light = _painted(camera, wall, (0, 1, 2), 1.0)
    else:
        scales = (1 + camera.red_shift, 1.0, 1 + camera.blue_shift)
        layers = [_painted(camera, wall, (c,), scale) for c, scale in enumerate(scales)]
        light = np.concatenate(layers, axis=-1)
    shade = 1 - camera.falloff * _far(camera.view) ** 2
    return camera.exposure * light * shade[..., None].astype(np.float32)


def encoded(light: Layer) -> Layer:
    """Return sRGB values 0 to 255 of linear light (IEC 61966-2-1)."""
    light = np.clip(light, 0, 1)
    bent = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    return (255 * bent).astype(np.float32)


def take(camera: Camera, wall: Wall) -> Picture:
    """Return the photograph as sRGB, red, green, blue, shape (height, width, 3)."""
    rng = np.random.default_rng(camera.seed)
    values = encoded(linear_light(camera, wall))
    values += camera.noise * rng.standard_normal(values.shape, dtype=np.float32)
    if camera.sharpening:
        soft = cv2.GaussianBlur(values, (0, 0), 1.2)
        values = values + camera.sharpening * (values - soft)
    picture = np.clip(np.rint(values), 0, 255).astype(np.uint8)
    return through_jpeg(picture, camera) if camera.quality else picture


def through_jpeg(picture: Picture, camera: Camera) -> Picture:
    """Return what a JPEG leaves of a picture."""
    factor = cv2.IMWRITE_JPEG_SAMPLING_FACTOR_420 if camera.sampling_420 else 0x111111
    flags = [cv2.IMWRITE_JPEG_QUALITY, camera.quality, cv2.IMWRITE_JPEG_SAMPLING_FACTOR, factor]
    done, data = cv2.imencode(".jpg", picture[..., ::-1], flags)
    if not done:
        raise ValueError("the JPEG was not written")
    seen = np.asarray(cv2.imdecode(data, cv2.IMREAD_COLOR), np.uint8)
    return np.ascontiguousarray(seen[..., ::-1])


def facade(rng: np.random.Generator, width: float = 40.0, height: float = 24.0) -> Wall:
    """Return a clad façade: courses, joints, piers, windows, shadows and bevels of all kinds."""
    wall = _grey(rng, 0.25, 0.55)
    # Where two patches ended at one place, what is behind would shine through: none does.
    patches = [Patch(0, width, 0, height, wall)]
    edges = [
        Edge("roof", "h", height, ((0.0, width),)),
        Edge("left end", "v", 0.0, ((0.0, height),)),
        Edge("right end", "v", width, ((0.0, height),)),
    ]
    storey, bay = 3.2, 3.6
    columns = [bay * k for k in range(1, int(width // bay) + 1) if bay * k < width - 1.0]
    storeys = [storey * k for k in range(1, int(height // storey) + 1) if storey * k < height - 0.8]
    for y in storeys:
        for x in [0.0, *columns]:
            patches += _window(rng, x + 0.9, y - 2.5, 1.8, 1.9)
    for number, y in enumerate(storeys):
        patches += _course(rng, number, wall, -0.3, width + 0.3, y)
        edges.append(Edge(f"course top {number}", "h", y + 0.3, ((0.0, width),)))
        edges.append(Edge(f"course foot {number}", "h", y, ((0.0, width),)))
        patches.append(Patch(0.1, width - 0.1, y - 0.40, y - 0.36, _times(wall, 0.35)))
        edges.append(Edge(f"joint {number}", "h", y - 0.38, ((0.1, width - 0.1),)))
    for number, x in enumerate(columns):
        colour = _grey(rng, 0.6, 0.85) if number % 2 else _grey(rng, 0.06, 0.15)
        if number % 3 == 2:
            patches.append(Patch(x, x + 0.45, 0.2, height - 0.4, _times(wall, 0.5)))
        patches.append(Patch(x - 0.2, x + 0.2, -1.0, height - 0.3, colour))
        edges.append(Edge(f"pier left {number}", "v", x - 0.2, ((0.0, height - 0.3),)))
        edges.append(Edge(f"pier right {number}", "v", x + 0.2, ((0.0, height - 0.3),)))
    return Wall(tuple(patches), tuple(edges))


def _grey(rng: np.random.Generator, low: float, high: float) -> tuple[float, float, float]:
    light = rng.uniform(low, high)
    red, green, blue = (float(np.clip(light * rng.uniform(0.92, 1.08), 0, 1)) for _ in range(3))
    return red, green, blue


def _times(light: tuple[float, float, float], factor: float) -> tuple[float, float, float]:
    return light[0] * factor, light[1] * factor, light[2] * factor


def _course(
    rng: np.random.Generator,
    number: int,
    wall: tuple[float, float, float],
    left: float,
    right: float,
    y: float,
) -> list[Patch]:
    """A string course: plain, with a shadow under it, or with a bevel on it."""
    colour = _grey(rng, 0.7, 0.9)
    if number % 3 == 1:
        shadow = Patch(0.1, right - 0.4, y - 0.15, y + 0.1, _times(wall, 0.45))
        return [shadow, Patch(left, right, y, y + 0.3, colour)]
    if number % 3 == 2:
        bevel = Patch(left + 0.1, right - 0.1, y + 0.1, y + 0.3, _times(colour, 0.8))
        return [bevel, Patch(left, right, y, y + 0.24, colour)]
    return [Patch(left, right, y, y + 0.3, colour)]


def _window(rng: np.random.Generator, x: float, y: float, wide: float, high: float) -> list[Patch]:
    frame = Patch(x, x + wide, y, y + high, _grey(rng, 0.6, 0.8))
    pane = _grey(rng, 0.03, 0.3)
    inner = Patch(x + 0.1, x + wide - 0.1, y + 0.1, y + high - 0.1, pane)
    return [frame, inner]


def interrupted(wall: Wall, rng: np.random.Generator, number: int) -> Wall:
    """Return the wall with things before it, such as trees and posts that break up its edges."""
    right = max(patch.right for patch in wall.patches)
    top = max(patch.top for patch in wall.patches)
    before: list[Patch] = []
    for _ in range(number):
        x, y = rng.uniform(0, right), rng.uniform(0, top)
        wide, high = rng.uniform(0.4, 2.0), rng.uniform(1.0, 5.0)
        before += [
            Patch(x + dx, x + dx + wide / 3, y + dy, y + dy + high / 3, _grey(rng, 0.02, 0.15))
            for dx, dy in rng.uniform(-0.5, 0.5, (7, 2)) * [wide, high]
        ]
    return replace(wall, patches=(*wall.patches, *before))

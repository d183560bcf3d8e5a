"""The grid of a rectified picture: where its pixels lie on the ground, and how many there are."""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np

from plumbline.errors import OptionError
from plumbline.frame import Array
from plumbline.ground.camera import Camera
from plumbline.ground.world_file import World

RESOLUTION_M = 0.01
"""Chosen: a centimetre, as ground points are surveyed."""
COARSEST_M = 0.25
"""Largest side of a photo's pixel on the ground that is still shown; chosen: some 30 m ahead of a
camera at eye height."""

_MARGIN = 0.25
"""What is shown around the points, over the longer side of their extent; chosen."""

_SHARE_OF_MEMORY = 0.5
"""Share of the free memory that a picture may need: half, since it is held twice when encoded."""

_FALLBACK_BYTES = 4 * 2**30
"""Where the free memory is not known; chosen, small machines have 8 GiB."""
_MOST_SIDE = 60_000
"""Longest side of a picture: JPEG ends at 65,535."""

_LOOKED_AT = 129
"""Points along a side of the photo's outline; chosen, distortion is smooth."""

Extent = tuple[float, float, float, float]
"""X and Y of the lower left and of the upper right corner, metres."""


@dataclass(frozen=True)
class Grid:
    """Pixels on the ground.

    Attributes:
        world: Where they lie.
        size: Width and height in pixels.
    """

    world: World
    size: tuple[int, int]

    @property
    def corners_m(self) -> Array:
        """The outer corners of the picture, shape (4, 2)."""
        right, bottom = self.size[0] - 0.5, self.size[1] - 0.5
        return self.world.places(
            np.array([[-0.5, -0.5], [right, -0.5], [right, bottom], [-0.5, bottom]])
        )


def grid_over(extent: Extent, resolution_m: float, bytes_each: int) -> Grid:
    """The grid of an extent, north up, its corners on whole pixels.

    Args:
        extent: What to show.
        resolution_m: Side of a pixel.
        bytes_each: Bytes of a pixel.

    Raises:
        OptionError: the extent is empty, or the picture too large; the sentence says which
            resolution fits.
    """
    left, bottom, right, top = extent
    if not (right > left and top > bottom and np.isfinite(extent).all()):
        raise OptionError(
            f"the extent {left:g},{bottom:g},{right:g},{top:g} has no area",
            hint="give X and Y of the lower left, then of the upper right corner",
        )
    columns, rows = _span(left, right, resolution_m), _span(bottom, top, resolution_m)
    _refuse_too_large(columns, rows, resolution_m, bytes_each)
    first = np.floor(left / resolution_m + 1e-9) * resolution_m + resolution_m / 2
    last = np.ceil(top / resolution_m - 1e-9) * resolution_m - resolution_m / 2
    return Grid(World.north_up(float(first), float(last), resolution_m), (columns, rows))


def _span(low: float, high: float, step: float) -> int:
    return max(int(np.ceil(high / step - 1e-9) - np.floor(low / step + 1e-9)), 1)


def _refuse_too_large(columns: int, rows: int, resolution_m: float, bytes_each: int) -> None:
    allowed = _SHARE_OF_MEMORY * free_bytes() / bytes_each
    over = max(float(np.sqrt(columns * rows / allowed)), columns / _MOST_SIDE, rows / _MOST_SIDE)
    if over > 1:
        size = columns * rows * bytes_each / 2**30
        raise OptionError(
            f"the picture would have {columns:,} x {rows:,} pixels, {size:,.1f} GiB: too many",
            hint=f"give a coarser --resolution, as {_rounded_up(over * resolution_m):g}, or a "
            "smaller --extent",
        )


def _rounded_up(value: float) -> float:
    """The next number with two significant digits."""
    step = 10.0 ** (np.floor(np.log10(value)) - 1)
    return float(np.ceil(value / step) * step)


def free_bytes() -> int:
    """Memory that is free, as the system tells; 4 GiB where it does not."""
    try:
        return os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, OSError, ValueError):
        return _FALLBACK_BYTES


def extent_of_points(places_m: Array) -> Extent:
    """The extent of points with a margin."""
    low, high = places_m.min(axis=0), places_m.max(axis=0)
    margin = _MARGIN * float(np.max(high - low))
    (left, bottom), (right, top) = low - margin, high + margin
    return float(left), float(bottom), float(right), float(top)


def extent_of_photo(camera: Camera, coarsest_m: float) -> Extent:
    """The extent of all ground that the photo shows finely enough.

    Raises:
        OptionError: it shows none.
    """
    frame = camera.optics.lens.frame
    columns, rows = (np.linspace(-0.5, side - 0.5, _LOOKED_AT) for side in frame.size)
    points = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
    ground = camera.ground(points)
    good = np.isfinite(ground.sum(axis=1))
    depths = (ground - camera.place[:2]) @ camera.rotation[2, :2]
    depths -= camera.rotation[2, 2] * camera.height_m
    good &= depths <= farthest_depth(camera, coarsest_m)
    if not good.any():
        raise OptionError(
            f"no part of the photo shows the ground at {coarsest_m:g} m a pixel or finer",
            hint="give a larger --coarsest",
        )
    (left, bottom), (right, top) = ground[good].min(axis=0), ground[good].max(axis=0)
    return float(left), float(bottom), float(right), float(top)


def farthest_depth(camera: Camera, coarsest_m: float) -> float:
    """The depth along the optical axis up to which a photo's pixel is no longer than this.

    A pixel is depth/f wide across the ray; along it the plane slants by depth/height. The lens's
    own stretch is left out.
    """
    across = coarsest_m * camera.focal_px
    return min(across, float(np.sqrt(across * camera.height_m)))

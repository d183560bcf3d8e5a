"""Write the rectified picture of a photo, with all that lays it over a map."""

from __future__ import annotations

import struct
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np

from plumbline.errors import OptionError
from plumbline.files import read_bytes
from plumbline.ground.rectification import Rectification
from plumbline.photos.exif import read_photo
from plumbline.photos.files.encode import encode, format_of
from plumbline.photos.files.exif import of_another_size
from plumbline.photos.files.metadata import Metadata, note_of
from plumbline.photos.files.picture import Picture, Pixels, decode
from plumbline.photos.turning import turned_upright
from plumbline.rectified.georeference import epsg_code, geotiff, sidecars
from plumbline.rectified.grid import (
    COARSEST_M,
    RESOLUTION_M,
    Extent,
    Grid,
    extent_of_photo,
    extent_of_points,
    grid_over,
)
from plumbline.rectified.ground_map import GroundMap
from plumbline.rectified.render import Rendered, Renderer

Shown = Literal["points", "photo"]

_MOST_COARSE = 0.001
"""Share of the pixels that may be cut without a word; chosen."""


@dataclass(frozen=True)
class PictureRequest:
    """What picture the user wants.

    Attributes:
        resolution_m: Side of a pixel on the ground.
        extent: "points", "photo", or X and Y of two corners.
        coarsest_m: Largest side of a photo's pixel on the ground that is shown.
        border: What stands where nothing is shown: "black", "white" or "transparent"; None for
            transparent where the format can, else black.
        quality: 1 to 100, for JPEG and WebP.
        crs: EPSG code of the plane's coordinate system.
        grid: The grid of another picture, in place of extent and resolution.
    """

    resolution_m: float = RESOLUTION_M
    extent: Shown | Extent = "points"
    coarsest_m: float = COARSEST_M
    border: Literal["black", "white", "transparent"] | None = None
    quality: int = 95
    crs: str | None = None
    grid: Grid | None = None


@dataclass(frozen=True)
class RectifiedPicture:
    """A rectified picture in memory.

    Attributes:
        picture: Its pixels, with alpha where nothing is shown if so wanted.
        rendered: The bare pixels and what they show.
        grid: Where they lie.
        notes: What was cut, in plain sentences.
    """

    picture: Picture
    rendered: Rendered
    grid: Grid
    notes: tuple[str, ...]


def rectify_picture(
    found: Rectification, photo: Path, target: Path, request: PictureRequest
) -> RectifiedPicture:
    """The rectified picture of a photo.

    Raises:
        PlumblineError: the photo cannot be read or has another size, the picture does not fit
            into memory, or shows nothing.
    """
    size = found.camera.optics.lens.frame.size
    facts = read_photo(photo)
    if facts.size != size:
        raise OptionError(
            f"{photo} has {facts.size[0]}x{facts.size[1]} pixels, and the rectification is of a "
            f"photo of {size[0]}x{size[1]}",
            hint="give the photo that it was made from",
        )
    source = decode(read_bytes(photo), photo)
    border = _border(request, source, target)
    grid = request.grid or _grid(found, source.pixels, request)
    ground = GroundMap(found.camera, grid, request.coarsest_m)
    renderer = Renderer(turned_upright(source.pixels, facts.orientation), ground, source.alpha)
    rendered = renderer.render(_outside(source, border))
    if not rendered.shown.any():
        raise OptionError(
            "the photo shows nothing of this extent", hint="give another --extent or --coarsest"
        )
    pixels = rendered.pixels
    if border == "transparent" and not source.alpha:
        pixels = _with_alpha(pixels, rendered)
    metadata, notes = _metadata(source, grid)
    picture = replace(source, pixels=pixels, metadata=metadata)
    return RectifiedPicture(picture, rendered, grid, (*_cut_notes(rendered, request), *notes))


def _metadata(source: Picture, grid: Grid) -> tuple[Metadata, tuple[str, ...]]:
    """EXIF and the colour profile of the photo, and a note where EXIF cannot be kept."""
    icc = source.metadata.icc
    try:
        return Metadata(of_another_size(source.metadata.exif, grid.size), icc), ()
    except (ValueError, struct.error):
        return Metadata(icc=icc), ("EXIF is damaged and was not kept",)


def picture_files(
    rectified: RectifiedPicture, target: Path, request: PictureRequest, description: str
) -> tuple[dict[Path, bytes], list[str]]:
    """The bytes of a picture's file and of those beside it, and what could not be kept."""
    epsg = None if request.crs is None else epsg_code(request.crs)
    data, lost = encode(rectified.picture, target, request.quality, note_of(description))
    if format_of(target) == "TIFF":
        data = geotiff(data, rectified.grid.world, epsg)
    return {target: data, **sidecars(target, rectified.grid, epsg)}, lost


def _grid(found: Rectification, pixels: Pixels, request: PictureRequest) -> Grid:
    if request.extent == "points":
        extent = extent_of_points(found.places_m)
    elif request.extent == "photo":
        extent = extent_of_photo(found.camera, request.coarsest_m)
    else:
        extent = request.extent
    channels = 1 if pixels.ndim == 2 else pixels.shape[2]
    return grid_over(extent, request.resolution_m, (channels + 1) * pixels.dtype.itemsize + 1)


def _border(request: PictureRequest, source: Picture, target: Path) -> str:
    can = format_of(target) in ("PNG", "TIFF", "WEBP") and not source.inks
    if request.border == "transparent" and not can:
        raise OptionError(
            f"{target.suffix} cannot be transparent, or the photo is CMYK",
            hint="name a .png or .tif with -o, or another --border",
        )
    return request.border or ("transparent" if can else "black")


def _outside(source: Picture, border: str) -> tuple[float, ...]:
    channels = 1 if source.pixels.ndim == 2 else source.pixels.shape[2]
    full = float(np.iinfo(source.pixels.dtype).max)
    if source.inks:
        return 0.0, 0.0, 0.0, full if border == "black" else 0.0
    colour = full if border == "white" else 0.0
    if source.alpha:
        return (colour,) * (channels - 1) + (0.0 if border == "transparent" else full,)
    return (colour,) * channels


def _with_alpha(pixels: Pixels, rendered: Rendered) -> Pixels:
    """Pixels with an alpha channel that hides where nothing is shown."""
    full = np.iinfo(pixels.dtype).max
    alpha = np.where(rendered.shown, full, 0).astype(pixels.dtype)
    if pixels.ndim == 2 and pixels.dtype == np.uint8:
        return np.stack((pixels, alpha), axis=-1)
    colours = (pixels,) * 3 if pixels.ndim == 2 else tuple(np.moveaxis(pixels, -1, 0))
    return np.stack((*colours, alpha), axis=-1)


def _cut_notes(rendered: Rendered, request: PictureRequest) -> tuple[str, ...]:
    notes: list[str] = []
    if rendered.coarse > _MOST_COARSE:
        notes.append(
            f"{100 * rendered.coarse:.1f} % of the picture is cut: it lies beyond the horizon, or "
            f"a pixel of the photo covers more than {request.coarsest_m:g} m there"
        )
    empty = 1 - float(np.mean(rendered.shown)) - rendered.coarse
    if empty > _MOST_COARSE:
        notes.append(f"{100 * empty:.1f} % of the picture lies outside of what the photo shows")
    return tuple(notes)

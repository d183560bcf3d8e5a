"""What tells other programs where a rectified picture lies.

A world file beside it, GeoTIFF's fields in it (OGC GeoTIFF 1.1: model pixel scale, tie point, key
directory), and where a coordinate system is named, `.aux.xml` for formats that hold none (GDAL's
persistent auxiliary metadata); for WebP always, whose world files GDAL does not read.
"""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np

from plumbline.errors import OptionError
from plumbline.ground.world_file import SUFFIXES, World
from plumbline.photos.files.ifd import Field
from plumbline.rectified.grid import Grid

_SHORT, _DOUBLE = 3, 12
_SCALE, _TIE_POINT, _TRANSFORMATION, _KEYS = 33550, 33922, 34264, 34735
_MODEL_TYPE, _RASTER_TYPE, _PROJECTED = 1024, 1025, 3072
_IS_PROJECTED, _IS_AREA = 1, 1
_CODES = range(1024, 32767)
"""The EPSG codes that a GeoTIFF key can hold."""
_DEGREES = range(4000, 5000)
"""EPSG codes of systems in degrees."""


def epsg_code(text: str) -> int:
    """The number of a coordinate system, as EPSG:25832 or 25832.

    Raises:
        OptionError: it is none, or one whose coordinates are degrees.
    """
    number = text.upper().removeprefix("EPSG:").strip()
    if not number.isdecimal() or int(number) not in _CODES:
        raise OptionError(
            f"{text} is not an EPSG code", hint="give a projected system, as --crs EPSG:25832"
        )
    if int(number) in _DEGREES:
        raise OptionError(
            f"EPSG:{number} is in degrees, and places are metres here",
            hint="give a projected system, as --crs EPSG:25832",
        )
    return int(number)


def world_file_name(picture: Path) -> Path:
    """The name of a picture's world file."""
    return picture.with_suffix(SUFFIXES.get(picture.suffix.lower(), ".wld"))


def sidecars(picture: Path, grid: Grid, epsg: int | None) -> dict[Path, bytes]:
    """The files beside a picture: its world file, and what names the coordinate system."""
    files = {world_file_name(picture): grid.world.text().encode()}
    suffix = picture.suffix.lower()
    if suffix == ".webp" or (epsg is not None and suffix not in (".tif", ".tiff")):
        text = _auxiliary(grid.world, epsg)
        files[picture.with_name(f"{picture.name}.aux.xml")] = text.encode()
    return files


def _auxiliary(world: World, epsg: int | None) -> str:
    """GDAL's metadata: the coordinate system, and where the picture's corner lies."""
    (a, b), (d, e) = world.matrix
    x, y = world.places(np.array([-0.5, -0.5]))
    system = f"  <SRS>EPSG:{epsg}</SRS>\n" if epsg is not None else ""
    numbers = ", ".join(f"{value:.15g}" for value in (x, a, b, y, d, e))
    place = f"  <GeoTransform>{numbers}</GeoTransform>\n"
    return f"<PAMDataset>\n{system}{place}</PAMDataset>\n"


def geotiff(data: bytes, world: World, epsg: int | None) -> bytes:
    """A TIFF file with the fields of GeoTIFF added."""
    (a, b), (d, e) = world.matrix
    corner = world.places(np.array([-0.5, -0.5]))
    fields: list[Field]
    if b == 0 and d == 0 and a > 0 and e < 0:
        fields = [
            Field(_SCALE, _DOUBLE, struct.pack("<3d", a, -e, 0.0)),
            Field(_TIE_POINT, _DOUBLE, struct.pack("<6d", 0.0, 0.0, 0.0, *corner, 0.0)),
        ]
    else:
        rows = (a, b, 0.0, corner[0], d, e, 0.0, corner[1], *(0.0,) * 4, 0.0, 0.0, 0.0, 1.0)
        fields = [Field(_TRANSFORMATION, _DOUBLE, struct.pack("<16d", *rows))]
    if epsg is not None:
        keys = (
            (_MODEL_TYPE, 0, 1, _IS_PROJECTED),
            (_RASTER_TYPE, 0, 1, _IS_AREA),
            (_PROJECTED, 0, 1, epsg),
        )
        directory = struct.pack("<16H", 1, 1, 0, len(keys), *(n for key in keys for n in key))
        fields.append(Field(_KEYS, _SHORT, directory))
    from plumbline.photos.files.tiff_writing import with_fields

    return with_fields(data, fields)

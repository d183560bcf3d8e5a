"""Hugin lens files (`.ini`), read and written.

    [Lens]
    image_width=2048
    image_height=1536
    type=0
    hfov=46.4
    crop=3.9
    a=0.0320
    b=-0.0978
    ...
    [EXIF]
    CameraMake=OLYMPUS
    CameraModel=C2500L
    FocalLength=9.2

Hugin writes them with "Save lens". `d`, `e` are pixels of a picture of that size. Shear (`g`,
`t`), vignetting and links are not kept. Source: Hugin 2022, `Lens::writeToFile`.
"""

from __future__ import annotations

import configparser
from collections.abc import Mapping
from dataclasses import dataclass, field

from plumbline.errors import printable
from plumbline.formats.base import Source
from plumbline.formats.panotools.script import PROJECTIONS, decimal

_HINT = "save the lens again in Hugin"


@dataclass(frozen=True)
class HuginLens:
    """What a Hugin lens file holds.

    Attributes:
        size: Width and height of the picture in pixels, or None.
        values: a, b, c, d, e.
        projection: "rectilinear", or what the lens is instead.
        hfov_deg: Horizontal field of view.
        crop_factor: Of the camera.
        camera_maker: As EXIF has it.
        camera_model: As EXIF has it.
        focal_mm: Focal length.
    """

    size: tuple[int, int] | None
    values: Mapping[str, float] = field(default_factory=dict[str, float])
    projection: str = "rectilinear"
    hfov_deg: float | None = None
    crop_factor: float | None = None
    camera_maker: str = ""
    camera_model: str = ""
    focal_mm: float | None = None


def read_hugin_ini(source: Source) -> HuginLens:
    """Read a Hugin lens file.

    Raises:
        ReadError: the file is damaged or holds no lens.
    """
    parser = configparser.ConfigParser(interpolation=None, strict=False)
    try:
        parser.read_string(source.text())
    except configparser.Error as error:
        row = getattr(error, "lineno", None)
        raise source.error("this is not a Hugin lens file", row, hint=_HINT) from None
    sections = {name.casefold(): parser[name] for name in parser.sections()}
    if "lens" not in sections:
        raise source.error("there is no [Lens] in this file", hint=_HINT)
    lens, exif = sections["lens"], sections.get("exif", {})

    def number(section: Mapping[str, str], name: str) -> float | None:
        text = section.get(name, "").strip().strip('"')
        return source.number(text, what=f"the value of {name}") if text else None

    values = {name: number(lens, name) or 0.0 for name in ("a", "b", "c", "d", "e")}
    width, height = number(lens, "image_width"), number(lens, "image_height")
    kind = int(number(lens, "type") or 0)
    if not any(name in lens for name in ("a", "b", "c")):
        raise source.error("the lens has no a, b, c", hint=_HINT)
    return HuginLens(
        size=(int(width), int(height)) if width and height and min(width, height) >= 1 else None,
        values=values,
        projection=PROJECTIONS.get(kind, f"lens type {kind}"),
        hfov_deg=_positive(number(lens, "hfov")),
        crop_factor=_positive(number(lens, "crop")),
        camera_maker=exif.get("cameramake", "").strip('"')[:120],
        camera_model=exif.get("cameramodel", "").strip('"')[:120],
        focal_mm=_positive(number(exif, "focallength")),
    )


def _positive(value: float | None) -> float | None:
    return value if value and value > 0 else None


def hugin_ini(lens: HuginLens, mark: str) -> bytes:
    """A Hugin lens file.

    Args:
        lens: What it holds.
        mark: A comment for its first line.
    """
    width, height = lens.size or (0, 0)
    rows = [f"; {mark}", "[Lens]", f"image_width={width}", f"image_height={height}"]
    numbers = {value: key for key, value in PROJECTIONS.items()}
    rows.append(f"type={numbers.get(lens.projection, 0)}")
    if lens.hfov_deg:
        rows += [f"hfov={decimal(lens.hfov_deg)}", "hfov_link=1"]
    if lens.crop_factor:
        rows.append(f"crop={decimal(lens.crop_factor)}")
    for name in ("a", "b", "c", "d", "e"):
        rows += [f"{name}={decimal(lens.values.get(name, 0.0))}", f"{name}_link=1"]
    rows += ["g=0", "g_link=1", "t=0", "t_link=1", "[EXIF]"]
    rows += [f"CameraMake={printable(lens.camera_maker)}"]
    rows += [f"CameraModel={printable(lens.camera_model)}"]
    if lens.focal_mm:
        rows.append(f"FocalLength={decimal(lens.focal_mm)}")
    return ("\n".join(rows) + "\n").encode()

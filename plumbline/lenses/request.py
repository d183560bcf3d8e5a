"""What the user says about the lens of a photo."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class LensRequest:
    """What the user says about the lens; everything may be left out.

    Attributes:
        source: A file or folder that holds the lens.
        ptlens: Coefficients `a`, `b`, `c` (and `d`, `e` in pixels of the photo as it is stored)
            given outright.
        camera: Maker and model of the camera, where EXIF is silent.
        lens_name: Name of the lens.
        like: A comparable camera whose lens is taken instead.
        focal_mm: Focal length in millimetres.
        crop_factor: Diagonal of the 35-mm frame over that of the sensor, of the photo as it is.
        full_size: Width and height of the camera's whole picture at the photo's scale, where
            the photo is a crop of it.
    """

    source: str | None = None
    ptlens: Mapping[str, float] | None = None
    camera: str | None = None
    lens_name: str | None = None
    like: str | None = None
    focal_mm: float | None = None
    crop_factor: float | None = None
    full_size: tuple[int, int] | None = None

    @property
    def looks_for_name(self) -> bool:
        """Whether the photo's own lens name matters: a database is asked, and no name is given."""
        if self.ptlens is not None or self.lens_name is not None:
            return False
        return self.source is None or not self.source.casefold().endswith((".json", ".pto", ".ini"))

"""What is known of a lens apart from the fit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from plumbline.frame import Frame

FULL_FRAME_MM = float(np.hypot(36, 24))
"""Diagonal of the 35-mm frame, 43.27 mm, which crop factors are relative to."""


@dataclass(frozen=True)
class LensFacts:
    """What is known of a lens before the fit, from a project, EXIF or the user.

    Unknown stays None or empty: measured values are never invented.

    Attributes:
        maker: Maker of the lens, or of the camera if the lens names none.
        model: Name of the lens.
        camera: Maker and model of the camera.
        mount: Name of the mount.
        focal_mm: Real focal length.
        crop_factor: Diagonal of the 35-mm frame over that of the sensor.
        crop_factor_error: Its relative uncertainty where it is known to be rounded.
        hfov_deg: Horizontal field of view.
        focal_px: Focal length in pixels.
        aspect_ratio: Longer side over shorter side, where the user rounds it.
        stored: Lens values found in the file (`a`…`e`, `g`, `t` for a Hugin project).
        requested: Coefficients the file asks to optimise; None if it does not say.
        projection: "rectilinear", or the name of what it is instead.
    """

    maker: str = ""
    model: str = ""
    camera: str = ""
    mount: str = ""
    focal_mm: float | None = None
    crop_factor: float | None = None
    crop_factor_error: float | None = None
    hfov_deg: float | None = None
    focal_px: float | None = None
    aspect_ratio: float | None = None
    stored: Mapping[str, float] = field(default_factory=dict[str, float])
    requested: tuple[str, ...] | None = None
    projection: str = "rectilinear"

    def focal_length_px(self, frame: Frame) -> float | None:
        """Focal length in square pixels of a photo, as far as it is known.

        From millimetres it needs the crop factor, which relates the sensor's diagonal to that
        of the 35-mm frame; from the field of view it holds for rectilinear lenses.
        """
        width, height = frame.square_size
        if self.focal_px:
            return self.focal_px
        if self.focal_mm and self.crop_factor:
            sensor_mm = FULL_FRAME_MM / self.crop_factor
            return float(self.focal_mm / sensor_mm * np.hypot(width, height))
        if self.hfov_deg:
            return float(width / 2 / np.tan(np.radians(self.hfov_deg) / 2))
        return None

    def focal_length_mm(self, frame: Frame) -> float | None:
        """Focal length in millimetres, from the field of view where it is not given itself."""
        if self.focal_mm or not (self.hfov_deg and self.crop_factor):
            return self.focal_mm
        focal_px = float(frame.square_size[0] / 2 / np.tan(np.radians(self.hfov_deg) / 2))
        return focal_px * FULL_FRAME_MM / self.crop_factor / float(np.hypot(*frame.square_size))

"""What is known of a lens apart from the fit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from plumbline.errors import OptionError
from plumbline.frame import Frame

FULL_FRAME_MM = float(np.hypot(36, 24))
"""Diagonal of the 35-mm frame, 43.27 mm, which crop factors are relative to."""

_SAME_FOCAL = 0.02
"""Relative; chosen, focal lengths in EXIF are rounded by as much."""
_SAME_CROP = 1e-3
"""Relative; above the rounding of a crop factor of three decimals."""
_SAME_SHAPE = 0.02
"""Relative; chosen, cameras cut a few pixels off 3:2 and 4:3."""


@dataclass(frozen=True)
class LensFacts:
    """What is known of a lens before the fit, from a project, EXIF or the user.

    Unknown stays None or empty: measured values are never invented.

    Attributes:
        maker: Maker of the lens, or of the camera if the lens names none.
        model: Name of the lens.
        camera: Maker and model of the camera, the maker once.
        exif_make: Maker of the camera as EXIF has it.
        exif_model: Model of the camera as EXIF has it, which may name the maker again.
        mount: Name of the mount.
        focal_mm: Real focal length.
        crop_factor: Diagonal of the 35-mm frame over that of the sensor.
        crop_factor_error: Its relative uncertainty where it is known to be rounded.
        hfov_deg: Horizontal field of view.
        hfov_width_px: Width of the photo that has this field of view; None where all have it.
        focal_px: Focal length in pixels.
        aspect_ratio: Longer side over shorter side, where the user rounds it.
        stored: Lens values found in the file (`a`…`e`, `g`, `t` for a Hugin project).
        requested: Coefficients the file asks to optimise; None if it does not say.
        projection: "rectilinear", or the name of what it is instead.
    """

    maker: str = ""
    model: str = ""
    camera: str = ""
    exif_make: str = ""
    exif_model: str = ""
    mount: str = ""
    focal_mm: float | None = None
    crop_factor: float | None = None
    crop_factor_error: float | None = None
    hfov_deg: float | None = None
    hfov_width_px: float | None = None
    focal_px: float | None = None
    aspect_ratio: float | None = None
    stored: Mapping[str, float] = field(default_factory=dict[str, float])
    requested: tuple[str, ...] | None = None
    projection: str = "rectilinear"

    def focal_length_px(self, frame: Frame) -> float | None:
        """Focal length in square pixels of a photo, as far as it is known.

        What is given in pixels counts first, then millimetres with the crop factor, which
        relates the sensor's diagonal to that of the 35-mm frame, then the field of view, which
        tells it for rectilinear lenses.
        """
        if self.focal_px:
            return self.focal_px
        if self.focal_mm and self.crop_factor:
            sensor_mm = FULL_FRAME_MM / self.crop_factor
            return float(self.focal_mm / sensor_mm * np.hypot(*frame.square_size))
        if self.hfov_deg:
            width = (self.hfov_width_px or frame.width) * frame.pixel_aspect
            return float(width / 2 / np.tan(np.radians(self.hfov_deg) / 2))
        return None

    def focal_length_mm(self, frame: Frame) -> float | None:
        """Focal length in millimetres, from that in pixels where it is not given itself."""
        focal_px = self.focal_length_px(frame)
        if self.focal_mm or not (focal_px and self.crop_factor):
            return self.focal_mm
        return focal_px * FULL_FRAME_MM / self.crop_factor / float(np.hypot(*frame.square_size))

    def refuse_contradiction(self, frame: Frame) -> None:
        """Refuse two focal lengths that do not belong together.

        Raises:
            OptionError: that in pixels differs by more than 2 % from that in millimetres.
        """
        if not self.focal_px:
            return
        in_mm = replace(self, focal_px=None, hfov_deg=None).focal_length_px(frame)
        if in_mm and abs(self.focal_px / in_mm - 1) > _SAME_FOCAL:
            raise OptionError(
                f"contradictory focal lengths: {self.focal_mm:g} mm at a crop factor of "
                f"{self.crop_factor:.4g} are {in_mm:.0f} px, not {self.focal_px:g}",
                hint="leave out --focal-px, or correct --focal or --crop-factor",
            )

    def completed(self, more: LensFacts) -> LensFacts:
        """These facts, with what they do not know taken from others about the same lens.

        Of two crop factors that agree the better known counts; what is asked to be optimised
        by either is asked for.
        """
        crop = best_crop_factor([self, more]) or (self if self.crop_factor else more)
        hfov = self if self.hfov_deg else more
        requested = {*(self.requested or ()), *(more.requested or ())}
        return replace(
            self,
            maker=self.maker or more.maker,
            model=self.model or more.model,
            camera=self.camera or more.camera,
            exif_make=self.exif_make if self.camera else more.exif_make,
            exif_model=self.exif_model if self.camera else more.exif_model,
            mount=self.mount or more.mount,
            focal_mm=self.focal_mm or more.focal_mm,
            crop_factor=crop.crop_factor,
            crop_factor_error=crop.crop_factor_error,
            hfov_deg=hfov.hfov_deg,
            hfov_width_px=hfov.hfov_width_px,
            focal_px=self.focal_px or more.focal_px,
            aspect_ratio=self.aspect_ratio or more.aspect_ratio,
            stored=self.stored or more.stored,
            requested=tuple(sorted(requested)) or None,
        )


def best_crop_factor(every: Sequence[LensFacts]) -> LensFacts | None:
    """The facts whose crop factor is known best.

    Returns:
        None if none is known, or two differ by more than their errors.
    """
    known = [(facts.crop_factor, facts.crop_factor_error or 0.0, facts) for facts in every]
    told = [(crop, error, facts) for crop, error, facts in known if crop]
    if not told:
        return None
    best, best_error, whose = min(told, key=lambda each: each[1])
    if any(abs(crop / best - 1) > error + best_error + _SAME_CROP for crop, error, _ in told):
        return None
    return whose


def checked_aspect_ratio(given: float, frame: Frame) -> float:
    """The user's aspect ratio, longer side over shorter, if it is the photo's but for rounding.

    Raises:
        OptionError: it is another one.
    """
    width, height = frame.square_size
    actual = max(width, height) / min(width, height)
    ratio = max(given, 1 / given) if given > 0 else given
    if abs(ratio / actual - 1) > _SAME_SHAPE:
        raise OptionError(
            f"the aspect ratio {given:.4g} contradicts the photo's {actual:.4g}, which the "
            "coefficients are measured in",
            hint="leave out --aspect-ratio, or pick the points in the whole photo",
        )
    return ratio

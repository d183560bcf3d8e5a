"""What the user says of a photographed plane."""

from __future__ import annotations

from dataclasses import dataclass

from plumbline.errors import OptionError
from plumbline.ground.adjusting.network import (
    FLATNESS_M,
    SIGMA_FOCAL,
    SIGMA_GROUND_M,
    SIGMA_PICK_PX,
    SIGMA_TAPE_M,
)


@dataclass(frozen=True)
class GroundRequest:
    """Files, standard errors and assumptions; lengths in metres, picks in pixels.

    Attributes:
        points: File of match points.
        tapes: File of tape distances.
        lines: File of straight lines in the photo.
        parallel: Sets of lines that are parallel on the plane, by their names.
        right_angles: Triples of points with a right angle at the second.
        horizon: Name of the line that is the horizon.
        aerial: Picture with a world file whose pixels the places are.
        sigma_pick_px: Standard error of a pick.
        sigma_ground_m: Of a coordinate on the ground, where the file gives none.
        sigma_tape_m: Of a tape, where the file gives none.
        flatness_m: Standard deviation of the plane's unevenness.
        focal_px: Focal length, where it is told.
        sigma_focal: Relative standard error of the focal length; 0 holds it.
        sigma_centre_px: Standard error of the lens's centre; by default the scatter of
            specimens.
        refine: Coefficients of the lens to adjust; `d`, `e` for its centre.
        square_on: Whether the camera was held square to the plane.

    Raises:
        OptionError: a standard error is not above 0.
    """

    points: str
    tapes: str | None = None
    lines: str | None = None
    parallel: tuple[tuple[str, ...], ...] = ()
    right_angles: tuple[tuple[str, str, str], ...] = ()
    horizon: str | None = None
    aerial: str | None = None
    sigma_pick_px: float = SIGMA_PICK_PX
    sigma_ground_m: float = SIGMA_GROUND_M
    sigma_tape_m: float = SIGMA_TAPE_M
    flatness_m: float = FLATNESS_M
    focal_px: float | None = None
    sigma_focal: float = SIGMA_FOCAL
    sigma_centre_px: float | None = None
    refine: tuple[str, ...] = ()
    square_on: bool = False

    def __post_init__(self) -> None:
        for name in ("sigma_pick_px", "sigma_ground_m", "sigma_tape_m", "flatness_m"):
            if not getattr(self, name) > 0:
                raise OptionError(
                    f"{name} must be above 0: nothing is known without error",
                    hint="give a small one, as 0.001",
                )
        if not self.sigma_focal >= 0:
            raise OptionError("sigma_focal must not be negative", hint="0 holds the focal length")

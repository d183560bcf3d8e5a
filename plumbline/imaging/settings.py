"""How to correct: what `correct`, `correct_array` and `correct_many` have in common."""

from __future__ import annotations

from dataclasses import dataclass

from plumbline.errors import OptionError
from plumbline.imaging.maps.view import SCALES, Scale
from plumbline.imaging.resample import BORDERS, INTERPOLATIONS, Border, Interpolation


@dataclass(frozen=True)
class Settings:
    """How to correct.

    Attributes:
        interpolation: "cubic", "lanczos", "linear" or "nearest".
        scale: "keep" the circle that the lens does not scale, "fit" all of the photo in, or
            "fill" the frame.
        border: What stands where the photo shows nothing: "black", "white", "transparent", or
            "edge", which repeats the outermost pixels.
        quality: 1 to 100, for JPEG and WebP.
        inverse: Distort a picture that is corrected already.
        difference: Write the picture of the differences too.

    Raises:
        OptionError: a value is not one of these.
    """

    interpolation: Interpolation = "cubic"
    scale: Scale = "keep"
    border: Border = "black"
    quality: int = 95
    inverse: bool = False
    difference: bool = False

    def __post_init__(self) -> None:
        for name, value, choices in (
            ("interpolation", self.interpolation, INTERPOLATIONS),
            ("scale", self.scale, SCALES),
            ("border", self.border, BORDERS),
        ):
            if value not in choices:
                raise OptionError(f"{name} is one of {', '.join(choices)}, not {value!r}")
        if not 1 <= self.quality <= 100:
            raise OptionError(f"the quality is between 1 and 100, not {self.quality}")

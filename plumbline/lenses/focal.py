"""The focal length that a lens is evaluated at, for a photo taken at another one."""

from __future__ import annotations

from plumbline.errors import OptionError

_FAR = 0.1
"""Relative: chosen, focal lengths in EXIF are rounded by up to 5 % and focusing moves them."""

_NEAR = 0.005
"""Relative: chosen, a difference that moves no point by a visible amount."""


def clamp_focal(
    focal_mm: float | None, range_mm: tuple[float, float], what: str
) -> tuple[float, str]:
    """The focal length to evaluate a lens at, and a note if it is not the photo's.

    Args:
        focal_mm: That of the photo, if known.
        range_mm: Shortest and longest calibrated focal length.
        what: The lens, for the sentences.

    Raises:
        OptionError: the photo's is not known and matters, or more than 10 % out of the range.
    """
    low, high = range_mm
    calibrated = f"{low:.4g} mm" if low == high else f"{low:.4g} to {high:.4g} mm"
    if focal_mm is None:
        if low == high:
            return low, f"the photo's focal length is not known: taken at {low:g} mm"
        raise OptionError(
            f"the photo does not give its focal length, and {what} is calibrated at {calibrated}",
            hint="give it with --focal",
        )
    nearest = min(max(focal_mm, low), high)
    taken = f"the photo was taken at {focal_mm:.4g} mm"
    if not low * (1 - _FAR) <= focal_mm <= high * (1 + _FAR):
        away = f"out of the calibrated range of {what}, {calibrated}"
        if low == high:
            away = f"away from the {calibrated} that {what} is calibrated at"
        raise OptionError(
            f"{taken}, more than 10 % {away}",
            hint="calibrate the lens at this focal length, or give the right one with --focal",
        )
    if abs(focal_mm / nearest - 1) <= _NEAR:
        return nearest, ""
    if low == high:
        return low, f"{taken}, the lens is calibrated at {calibrated}: corrected as there"
    return nearest, (
        f"{taken}, out of the calibrated range {calibrated}: corrected as at {nearest:g} mm"
    )

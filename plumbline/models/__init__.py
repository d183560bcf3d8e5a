"""The distortion models: one file each, one row each in `MODELS`."""

from __future__ import annotations

from plumbline.errors import UnsupportedModelError
from plumbline.models.acm import ACM
from plumbline.models.base import Model
from plumbline.models.brown import Brown
from plumbline.models.division import Division
from plumbline.models.opencv import OpenCV
from plumbline.models.poly3 import Poly3
from plumbline.models.poly5 import Poly5
from plumbline.models.ptlens import PTLens
from plumbline.models.radial import Radial

__all__ = ["CENTRE", "MODELS", "Model", "get_model"]

MODELS: dict[str, Model] = {
    model.name: model
    for model in (
        PTLens(),
        Poly3(),
        Poly5(),
        Radial(),
        Brown(),
        Division(),
        OpenCV(),
        ACM(),
    )
}

CENTRE = ("d", "e")
"""The distortion centre's offset from the image centre in pixels; every model may free it."""

MAX_POWER = 12
"""Chosen, because no lens needs more and higher powers are rounding alone."""


def get_model(name: str) -> Model:
    """The model of that name; `radial:1,2,3` chooses the powers.

    Raises:
        UnsupportedModelError: there is no such model, or the powers make no sense.

    Example:
        >>> get_model("radial:2,4").coefficients
        ('a2', 'a4')
    """
    base, colon, powers = str(name).partition(":")
    if base not in MODELS or (colon and base != "radial"):
        raise UnsupportedModelError(
            f"{name!r} is not a distortion model",
            hint=f"choose one of {', '.join(MODELS)}, or radial:POWERS such as radial:1,2,3",
        )
    if not colon:
        return MODELS[base]
    try:
        chosen = tuple(sorted(int(power) for power in powers.split(",")))
    except ValueError:
        chosen = ()
    if (
        not chosen
        or len(set(chosen)) < len(chosen)
        or not 1 <= chosen[0] <= chosen[-1] <= MAX_POWER
    ):
        raise UnsupportedModelError(
            f"{powers!r} are not powers for the radial model",
            hint=f"give distinct whole numbers from 1 to {MAX_POWER}, as in radial:2,4,6",
        )
    return Radial(chosen)

"""The distortion models, for `plumbline models`."""

from __future__ import annotations

from collections.abc import Iterable

from plumbline.models import Model

_TANGENTIAL = (
    "tangential(p1, p2) = (2 p1 x y + p2 (r² + 2 x²), p1 (r² + 2 y²) + 2 p2 x y)\n"
    "Every model may also free the distortion centre: --free …,d,e (pixels from the image centre)."
)


def models_text(models: Iterable[Model]) -> str:
    """A block a model: its name, equation, and what the radius is measured in."""
    return "\n\n".join([*(_block(model) for model in models), _TANGENTIAL])


def _block(model: Model) -> str:
    names = " ".join(model.coefficients)
    if model.name == "radial":
        names = f"one for each power, here {names}"
    return "\n".join(
        (
            f"{model.label}: {model.use}",
            f"    {model.formula}",
            f"    coefficients {names}",
            f"    {model.direction}; r in units of {model.unit}, scale 1 at r = {model.gauge}",
        )
    )

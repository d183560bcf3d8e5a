"""The sampling map that corrects a photograph, looked at for folds."""

from __future__ import annotations

from plumbline.errors import OptionError
from plumbline.imaging.maps.sampling_map import SamplingMap
from plumbline.imaging.maps.view import Scale, view_of
from plumbline.lenses.correction import Correction

_LEAST_SHOWN = 0.05
"""Share of the picture: chosen, below it a decimal point is more likely wrong than the lens."""


def sampling_of(
    correction: Correction, *, orientation: int = 1, scale: Scale = "keep", inverse: bool = False
) -> SamplingMap:
    """The map of a picture as it is stored; see `view_of`.

    Raises:
        OptionError: the lens folds so far inside that hardly anything of the photo remains.
    """
    view = view_of(correction, orientation=orientation, scale=scale, inverse=inverse)
    sampling = SamplingMap(view.stored_size, view.observed)
    if sampling.fold_px is None:
        return sampling
    at = f"the lens values fold {sampling.fold_px:.0f} px from the centre"
    if sampling.shown < _LEAST_SHOWN:
        raise OptionError(
            f"{at}, so that hardly anything of the photo remains",
            hint="check the decimal dots and signs of the lens values, or take another lens",
        )
    return sampling


def fold_notes(sampling: SamplingMap) -> tuple[str, ...]:
    """What to tell of a map that folds inside the picture."""
    if sampling.fold_px is None:
        return ()
    return (
        f"the lens values fold {sampling.fold_px:.0f} px from the centre: what lies farther out "
        "is left empty",
    )

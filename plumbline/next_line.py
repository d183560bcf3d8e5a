"""Which line to pick next: the one that would lower the largest error of the correction most."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from plumbline.displacement import displacement_errors, grid_px
from plumbline.linearised import linearise

if TYPE_CHECKING:
    from plumbline.calibration import Calibration
    from plumbline.frame import Array

_POINTS = 9
_INSET = 0.04
_THIRD = 1 / 3


@dataclass(frozen=True)
class NextLine:
    """A line worth picking.

    Attributes:
        place: Where, as in "near the top edge".
        from_px: The largest standard error of the correction now.
        to_px: What it would be with nine picks along that line.
    """

    place: str
    from_px: float
    to_px: float


def next_line(made: Calibration) -> NextLine | None:
    """The best of lines along the edges and a third of the way out.

    Returns:
        None where the model folds inside the photo.
    """
    now = made.displacement
    if now is None:
        return None
    linear = made.linearised
    seen = (linear.jacobian * linear.in_photo[:, None])[linear.kept]
    best: NextLine | None = None
    for place, points_px in candidates(made.lens.frame.size).items():
        more = linearise(
            made.lens, [points_px], made.free, np.ones(len(points_px), dtype=np.bool_), image=True
        )
        if not np.all(np.isfinite(more.jacobian)):
            continue
        covariance = np.asarray(np.linalg.pinv(seen.T @ seen + more.normal), dtype=np.float64)
        errors_px = displacement_errors(
            made.lens, made.free, made.sigma_px**2 * covariance, grid_px(made.lens)
        )
        if errors_px is None:
            continue
        found = NextLine(place, now.worst_px, float(np.max(errors_px)))
        if best is None or found.to_px < best.to_px:
            best = found
    return best


def candidates(size: tuple[int, int]) -> dict[str, Array]:
    """Lines that one could pick, nine points each, shape (9, 2)."""
    right, bottom = size[0] - 1.0, size[1] - 1.0
    share = np.linspace(_INSET, 1 - _INSET, _POINTS)
    out: dict[str, Array] = {}
    for name, at in (("top", _INSET), ("bottom", 1 - _INSET)):
        out[f"near the {name} edge"] = _line(share * right, at * bottom)
    for name, at in (("left", _INSET), ("right", 1 - _INSET)):
        out[f"near the {name} edge"] = _line(at * right, share * bottom)
    third = _THIRD / 2
    out["a third of the way from the centre to the top"] = _line(
        share * right, (0.5 - third) * bottom
    )
    out["a third of the way from the centre to the left"] = _line(
        (0.5 - third) * right, share * bottom
    )
    return out


def _line(x: Array | float, y: Array | float) -> Array:
    return np.stack(np.broadcast_arrays(np.asarray(x), np.asarray(y)), axis=1).astype(np.float64)

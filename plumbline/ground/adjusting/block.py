"""A block of observation equations, and what all kinds of them share."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plumbline.frame import Array, Indices
from plumbline.ground.adjusting.state import Layout
from plumbline.ground.camera import N_STEPS, Seen


@dataclass(frozen=True)
class Block:
    """Observations of one kind.

    Attributes:
        kind: What they are: "picks", "points", "flatness", "tapes", "angles", "lines",
            "horizon", "focal length", "centre", "lens", "square", "straight" or "datum".
        residuals: Observed minus computed over the standard error, shape (m,).
        derivative: Of the residuals by the steps, shape (m, unknowns).
        owners: Which point, tape, … each residual belongs to, shape (m,).
    """

    kind: str
    residuals: Array
    derivative: Array
    owners: Indices


def seen_by_steps(seen: Seen, layout: Layout) -> Array:
    """Derivative of what is seen by camera and refined coefficients, shape (n, 2, steps)."""
    rows = np.zeros((len(seen.px), 2, layout.size))
    rows[..., :N_STEPS] = seen.by_camera
    rows[..., layout.lens] = seen.by_lens[..., list(layout.refined)]
    return rows


def ones(columns: Indices, values: Array, size: int) -> Array:
    """Rows with one value each, at these columns."""
    rows = np.zeros((len(columns), size))
    rows[np.arange(len(columns)), columns] = values
    return rows

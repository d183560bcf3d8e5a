"""Edges that go on beyond what was seen of them, followed to the photo's border."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from plumbline.edges.guide import GuideError, through_nodes
from plumbline.edges.light import Light
from plumbline.edges.refine import Samples, refined
from plumbline.edges.search import Curve
from plumbline.edges.trace import Traced
from plumbline.errors import FoldedError
from plumbline.frame import Array
from plumbline.geometry.lens import Lens

_NODES = 400
_BEYOND = 1.5
"""How far an edge is followed at either end, in its own lengths: farther out its direction, known
to 0.05 px over its length, is off by more than the window."""

_RUN = 9
"""Samples in a row of which most must be of the edge for it to go on (chosen, because three
chance peaks in a row occurred in leaves, five did not)."""


def grown(light: Light, traced: Traced, lens: Lens) -> Traced:
    """The same edge as far as it can be seen, or as it is where it cannot be followed.

    Args:
        light: Linear light, shape (height, width).
        traced: An edge that was found.
        lens: The lens, which predicts where it goes on.
    """
    nodes = _extended(traced.points_px, lens)
    if nodes is None:
        return traced
    try:
        guide = through_nodes(nodes, (light.shape[1], light.shape[0]))
    except GuideError:
        return traced
    kind = traced.kind or "either"
    samples = refined(light, guide, Curve(0.0, 0.0, 0.0, kind, 1.0, 1.0))
    if samples is None:
        return traced
    keep = samples.good & _connected(samples, traced)
    if keep.sum() <= len(traced.points_px) // 2:
        return traced
    points = samples.guide.points(samples.along[keep], samples.offset[keep])
    return replace(traced, points_px=points, errors_px=samples.error_px[keep])


def _extended(points: Array, lens: Lens) -> Array | None:
    """Points along the edge and beyond both ends, as far as they lie in the photo."""
    ideal = lens.undistort_or_nan(points)
    if np.isnan(ideal).any():
        return None
    centre = ideal.mean(axis=0)
    direction = np.linalg.svd(ideal - centre, full_matrices=False)[2][0]
    along = (ideal - centre) @ direction
    beyond = _BEYOND * float(np.ptp(along))
    reach = np.linspace(along.min() - beyond, along.max() + beyond, _NODES)
    try:
        nodes = lens.distort(centre + reach[:, None] * direction)
    except FoldedError:
        return None
    inside = lens.frame.contains(nodes)
    first, last = _run_about(inside, int(np.argmin(np.abs(reach))))
    return nodes[first:last] if last - first >= 3 else None


def _run_about(flags: NDArray[np.bool_], middle: int) -> tuple[int, int]:
    """First and last + 1 of the run of true flags about a place; empty where it is false."""
    if not flags[middle]:
        return middle, middle
    gaps = np.flatnonzero(~flags)
    before, after = gaps[gaps < middle], gaps[gaps > middle]
    return int(before[-1]) + 1 if len(before) else 0, int(after[0]) if len(after) else len(flags)


def _connected(samples: Samples, traced: Traced) -> NDArray[np.bool_]:
    """Which samples are of the part that was traced, or reached from it without a long gap."""
    axis = 1 if samples.guide.steep else 0
    low, high = traced.points_px[:, axis].min(), traced.points_px[:, axis].max()
    core = (samples.along >= low) & (samples.along <= high)
    share = np.convolve(samples.good.astype(float), np.ones(_RUN) / _RUN, mode="same")
    goes_on = (share > 0.5) | core
    middle = int(np.argmin(np.abs(samples.along - (low + high) / 2)))
    first, last = _run_about(goes_on, middle)
    keep = np.zeros(len(core), dtype=np.bool_)
    keep[first:last] = True
    return keep

"""Picks points along true edges, as somebody with a viewer and a steady hand would."""

from dataclasses import dataclass

import numpy as np

from .optics import Array, View
from .scene import Edge, Facade

NOISE_PX = 0.4
MARGIN_PX = 10.0
STEP = 0.02  # metres between the samples of an edge
INSET = 0.12  # metres kept from the end of a visible stretch
OFFSETS = (-0.9, -0.7, -0.34, 0.34, 0.5, 0.7, 0.9)  # of the way from the centre to the frame


@dataclass(frozen=True)
class Line:
    """The picks of one edge, observed pixels, sorted along it. Shape (n, 2)."""

    edge: Edge
    points: Array


def inside(view: View, points: Array, margin: float = MARGIN_PX) -> np.ndarray:
    """Tell which observed points lie in the photo, a margin away from its border."""
    x, y = points[..., 0], points[..., 1]
    last = np.array([view.width - 1, view.height - 1])
    return (x >= margin) & (y >= margin) & (x <= last[0] - margin) & (y <= last[1] - margin)


def trace(view: View, edge: Edge) -> tuple[Array, Array]:
    """Return the positions along an edge that the photo shows, and where it shows them."""
    parts = [np.arange(lo + INSET, hi - INSET, STEP) for lo, hi in edge.spans]
    along = np.concatenate(parts)
    seen = view.project(edge.points(along))
    shown = inside(view, seen)
    return along[shown], seen[shown]


def choose(view: View, facade: Facade, offsets: tuple[float, ...] = OFFSETS) -> list[Edge]:
    """Choose edges in both directions: near the frame, a third of the way out, and between."""
    chosen: list[Edge] = []
    for axis, across, extent in (("h", 1, view.width), ("v", 0, view.height)):
        half = (view.width, view.height)[across] / 2
        candidates: list[tuple[float, Edge]] = []
        for edge in facade.edges():
            _, seen = trace(view, edge)
            if edge.axis != axis or len(seen) < 12:
                continue
            if np.ptp(seen[:, 1 - across]) < 0.55 * extent:
                continue
            candidates.append((float(seen[:, across].mean() - view.centre[across]) / half, edge))
        for offset in offsets:
            near = min(candidates, key=lambda each: abs(each[0] - offset))
            candidates.remove(near)
            chosen.append(near[1])
    return chosen


def pick(view: View, edges: list[Edge], count: int, seed: int) -> list[Line]:
    """Pick `count` points along each edge, evenly in the photo, with picking noise."""
    rng = np.random.default_rng(seed)
    lines: list[Line] = []
    for edge in edges:
        _, seen = trace(view, edge)
        axis = 0 if edge.axis == "h" else 1
        wanted = np.linspace(seen[0, axis], seen[-1, axis], count)
        wanted[1:-1] += rng.uniform(-0.15, 0.15, count - 2) * (wanted[1] - wanted[0])
        nearest = sorted({int(np.abs(seen[:, axis] - at).argmin()) for at in wanted})
        points = seen[nearest] + rng.normal(0, NOISE_PX, (len(nearest), 2))
        lines.append(Line(edge, _clip(view, points)))
    return lines


def pick_grid(view: View, facade: Facade, rows: range, columns: range, seed: int) -> Array:
    """Pick the top-left corners of a block of windows. Shape (rows, columns, 2)."""
    corners = [[facade.window_corner(row, column) for column in columns] for row in rows]
    seen = view.project(np.array(corners))
    if not inside(view, seen).all():
        raise ValueError("a corner of the grid lies outside the photo")
    noise = np.random.default_rng(seed).normal(0, NOISE_PX, seen.shape)
    return _clip(view, seen + noise)


def _clip(view: View, points: Array) -> Array:
    return np.clip(points, 0, [view.width - 1, view.height - 1])

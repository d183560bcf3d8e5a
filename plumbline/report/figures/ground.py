"""The figures of a rectification: its photo, the plan of the ground, and the map of errors."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from plumbline.errors import printable
from plumbline.frame import Array
from plumbline.ground.ellipses import ellipse, standard_errors
from plumbline.ground.rectification import Rectification
from plumbline.report.figures import style
from plumbline.report.figures.style import BLUE, FULL, MUTED, ORANGE

_NODES = 121
"""A side of the map; chosen, finer ones look the same."""
_ROUND = (1, 2, 5)
"""Numbers that a scale is rounded to."""
_LEVELS_M = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0)
"""Contours; chosen, each about twice the one before."""
_SHOWN = 0.12
"""Share of the plan's width that the longest ellipse gets; chosen."""

_BEYOND = 1.6
"""How far ahead the plan reaches, over the distance of the farthest point; chosen."""


def photo_figure(found: Rectification, pixels: NDArray[np.uint8] | None) -> Any:
    """The photo with the points, the quadrilateral around them, and magnified residuals."""
    width, height = found.camera.optics.lens.frame.size
    figure = style.sheet(FULL, FULL * height / width)
    axes = figure.subplots()
    if pixels is not None:
        extent = (-0.5, width - 0.5, height - 0.5, -0.5)
        axes.imshow(pixels, extent=extent, interpolation="none", aspect="auto")
    hull = _hull(found.picks_px)
    axes.plot(*hull.T, color=BLUE, linewidth=1)
    offs = np.array([point.pick_px for point in found.findings.points])
    times = _exaggeration(float(np.max(np.hypot(*offs.T), initial=0.0)), 0.03 * width)
    for name, (x, y), (dx, dy) in zip(found.names, found.picks_px, offs, strict=True):
        axes.plot(x, y, "+", color=ORANGE, markersize=9)
        axes.plot([x, x + times * dx], [y, y + times * dy], color=ORANGE, linewidth=1.2)
        axes.annotate(
            printable(name), (x, y), (5, 5), textcoords="offset points", color=ORANGE, fontsize=9
        )
    axes.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5), aspect="equal")
    axes.grid(visible=False)
    axes.set_title(f"residuals {times:g} times as long", color=MUTED, loc="left")
    return figure


def plan_figure(found: Rectification) -> Any:
    """The ground from above: the points with their 95 % ellipses, and the camera."""
    figure = style.sheet(FULL, FULL * 0.8)
    axes = figure.subplots()
    _, joint = found.joint(found.names, {})
    blocks = [joint[i : i + 2, i : i + 2] for i in range(0, len(joint), 2)]
    ellipses = [ellipse(block) for block in blocks]
    span = float(np.max(np.ptp(found.places_m, axis=0))) or 1.0
    times = _exaggeration(max(each[0] for each in ellipses), _SHOWN * span)
    turn = np.linspace(0, 2 * np.pi, 73)
    for name, place, (long, short, angle) in zip(
        found.names, found.places_m, ellipses, strict=True
    ):
        along = np.radians(angle)
        u, v = times * long * np.cos(turn), times * short * np.sin(turn)
        axes.plot(
            place[0] + u * np.cos(along) - v * np.sin(along),
            place[1] + u * np.sin(along) + v * np.cos(along),
            color=BLUE,
            linewidth=1,
        )
        axes.plot(*place, ".", color=BLUE)
        axes.annotate(printable(name), tuple(place), (5, 5), textcoords="offset points")
    axes.plot(*found.camera.place[:2], "^", color=ORANGE, markersize=8)
    axes.annotate("camera", tuple(found.camera.place[:2]), (6, -4), textcoords="offset points")
    axes.set(xlabel="X, m", ylabel="Y, m", aspect="equal")
    axes.set_title(f"95 % ellipses {times:g} times as large", color=MUTED, loc="left")
    return figure


def error_map_figure(found: Rectification) -> Any:
    """The standard error of a new pick's place over the ground that the photo shows."""
    foot = found.camera.place[:2]
    far = _BEYOND * float(np.max(np.hypot(*(found.places_m - foot).T)))
    way = found.places_m.mean(axis=0) - foot
    middle = foot + way / max(float(np.hypot(*way)), 1e-9) * far / 2
    low = np.minimum(found.places_m.min(axis=0), middle - far / 2)
    high = np.maximum(found.places_m.max(axis=0), middle + far / 2)
    x, y = (np.linspace(low[i], high[i], _NODES) for i in (0, 1))
    places = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    with np.errstate(all="ignore"):
        picks = found.to_photo(places)
        inside = found.camera.optics.lens.frame.contains(picks)
        errors = standard_errors(found.covariances(picks))
    errors = np.where(inside, errors, np.nan).reshape(_NODES, _NODES)
    figure = style.sheet(FULL, FULL * 0.8)
    axes = figure.subplots()
    lines = axes.contour(x, y, errors, levels=_LEVELS_M, colors=ORANGE, linewidths=1.2)
    axes.clabel(lines, fmt="%g m", fontsize=8)
    axes.plot(*found.places_m.T, ".", color=BLUE)
    axes.plot(*foot, "^", color=ORANGE, markersize=8)
    axes.set(xlabel="X, m", ylabel="Y, m", aspect="equal")
    return figure


def _exaggeration(longest: float, shown: float) -> float:
    """A round number of times by which lengths are drawn longer."""
    if longest <= 0:
        return 1.0
    wanted = max(shown / longest, 1.0)
    decade = 10.0 ** np.floor(np.log10(wanted))
    return float(max(step * decade for step in _ROUND if step * decade <= wanted))


def _hull(points: Array) -> Array:
    """The closed convex hull of points, by A. Andrew (1979), shape (m + 1, 2)."""
    ordered = points[np.lexsort((points[:, 1], points[:, 0]))]

    def chain(run: Array) -> list[Array]:
        hull: list[Array] = []
        for point in run:
            while len(hull) > 1 and _left(hull[-2], hull[-1], point) <= 0:
                hull.pop()
            hull.append(point)
        return hull[:-1]

    corners = [*chain(ordered), *chain(ordered[::-1])]
    return np.array([*corners, corners[0]])


def _left(a: Array, b: Array, c: Array) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))

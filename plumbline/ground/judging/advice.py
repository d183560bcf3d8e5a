"""Which further observation would help most, computed before anybody makes it.

Each possible observation is added at the adjusted state, without errors, and the covariance
computed again. What counts is the standard error ahead, at twice the distance of the farthest
point, without the error that any pick there has for itself.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from plumbline.frame import Array
from plumbline.ground.adjusting.adjustment import Adjustment
from plumbline.ground.adjusting.equations import blocks
from plumbline.ground.adjusting.network import (
    SIGMA_GROUND_M,
    SIGMA_TAPE_M,
    Focal,
    GroundLine,
    Network,
    Tape,
)
from plumbline.ground.adjusting.state import Layout, State
from plumbline.ground.camera import Camera
from plumbline.ground.findings import Advice
from plumbline.ground.outcome import rectification_of
from plumbline.ground.rectification import Rectification, gains

_BEYOND = 2.0
"""The target's distance over that of the farthest point; chosen."""

_LANE_M = 3.5
"""Distance of two lane edges; a usual lane."""

_TRACED, _FARTHEST_M = 4.0, 60.0
"""To where edges are traced: over the distance of the farthest point, but not beyond 60 m, where a
lane edge is a pixel wide; chosen."""

_PICKS = 10
_WORTH_IT = 0.1
"""Least share by which an observation must cut the error to be advised; chosen."""


@dataclass(frozen=True)
class _View:
    """The ground before a camera: a place by its distance ahead and sideways."""

    foot: Array
    ahead: Array
    near_m: float
    far_m: float

    def at(self, distance: Array | float, aside: float) -> Array:
        """Places, shape (n, 2)."""
        right = np.array([self.ahead[1], -self.ahead[0]])
        return self.foot + np.atleast_1d(distance)[:, None] * self.ahead + aside * right


def advise(found: Adjustment) -> list[Advice]:
    """What would help most, best first; only what cuts the error by a tenth at least."""
    camera = found.state.camera
    view = _view(camera, found.state.places[:, :2])
    target = view.at(_BEYOND * view.far_m, 0.0)[0]
    if not np.isfinite(_seen_inside(camera, target[None])).all():
        target = view.at(view.far_m, 0.0)[0]
    now = _error(rectification_of(found), target)
    advice: list[Advice] = []
    for what, network, state in _possible(found, view):
        layout = Layout.of(network, camera.optics.names)
        with np.errstate(all="ignore"):
            equations = tuple(blocks(network, layout, state, state))
        if not all(np.isfinite(block.derivative).all() for block in equations):
            continue
        then = _error(
            rectification_of(Adjustment(network, layout, state, state, equations, True)), target
        )
        if then < (1 - _WORTH_IT) * now:
            advice.append(Advice(what, (float(target[0]), float(target[1])), now, then))
    return sorted(advice, key=lambda each: each.then_m)


def _view(camera: Camera, places: Array) -> _View:
    foot = camera.place[:2]
    ahead = places.mean(axis=0) - foot
    ahead = ahead / max(float(np.hypot(*ahead)), 1e-9)
    away = (places - foot) @ ahead
    return _View(foot, ahead, max(float(away.min()), 0.1), max(float(away.max()), 0.2))


def _error(found: Rectification, target: Array) -> float:
    """Standard error at a place, the pick's own left out."""
    gain = gains(found.camera, target[None])[0]
    size = gain.shape[1]
    return float(np.sqrt(np.trace(gain @ found.covariance[:size, :size] @ gain.T)))


def _possible(found: Adjustment, view: _View) -> Iterator[tuple[str, Network, State]]:
    yield from _lines(found, view)
    yield from _points(found, view)
    yield from _tape(found)
    network = found.network
    if network.focal is None:
        told = replace(network, focal=Focal(found.state.camera.focal_px))
        yield "give the focal length (--focal-px, or EXIF)", told, found.state


def _lines(found: Adjustment, view: _View) -> Iterator[tuple[str, Network, State]]:
    """Two parallel lane edges along the view."""
    network, state = found.network, found.state
    ends = (view.near_m, max(min(_TRACED * view.far_m, _FARTHEST_M), view.far_m))
    along = np.geomspace(*ends, _PICKS)
    group, lines, anchors = network.n_groups, list[GroundLine](), list[Array]()
    for aside in (-_LANE_M / 2, _LANE_M / 2):
        places = view.at(along, aside)
        picks = _seen_inside(state.camera, places)
        picks = picks[np.isfinite(picks).all(axis=1)]
        if len(picks) < 3:
            return
        lines.append(GroundLine(f"edge {aside:+g}", picks, group))
        anchors.append(places.mean(axis=0))
    turn = float(np.arctan2(view.ahead[1], view.ahead[0]))
    wider = replace(
        state,
        directions=np.append(state.directions, turn),
        anchors=np.concatenate((state.anchors, anchors)),
        offsets=np.append(state.offsets, np.zeros(2)),
    )
    yield (
        f"mark two parallel lane edges, from {ends[0]:.0f} to {ends[1]:.0f} m ahead",
        replace(network, lines=(*network.lines, *lines)),
        wider,
    )


def _points(found: Adjustment, view: _View) -> Iterator[tuple[str, Network, State]]:
    """One more point, beyond the others or beside them."""
    network, state = found.network, found.state
    wide = max(float(np.ptp(state.places[:, 0])), float(np.ptp(state.places[:, 1])), 1.0)
    for distance, aside, where in (
        (1.5 * view.far_m, 0.0, "beyond the others, about"),
        (view.far_m, wide, "far right, about"),
        (view.far_m, -wide, "far left, about"),
    ):
        place = view.at(distance, aside)
        pick = _seen_inside(state.camera, place)
        if not np.isfinite(pick).all():
            continue
        yield (
            f"mark one more point of known place {where} {distance:.0f} m ahead",
            replace(
                network,
                names=(*network.names, "another"),
                picks_px=np.concatenate((network.picks_px, pick)),
                places_m=np.concatenate((network.places_m, place)),
                sigma_places_m=np.append(network.sigma_places_m, SIGMA_GROUND_M),
            ),
            replace(state, places=np.concatenate((state.places, np.append(place, 0.0)[None]))),
        )


def _tape(found: Adjustment) -> Iterator[tuple[str, Network, State]]:
    """The longest tape that was not measured between points without places."""
    network, places = found.network, found.state.places[:, :2]
    known = set(network.known.tolist())
    taped = {frozenset((t.first, t.second)) for t in network.tapes}
    pairs = [
        (float(np.hypot(*(places[i] - places[j]))), j, i)
        for i in range(network.n_points)
        for j in range(i)
        if frozenset((i, j)) not in taped and not {i, j} <= known
    ]
    if not pairs:
        return
    length, first, second = max(pairs)
    names = f"{network.names[first]} to {network.names[second]}"
    tape = Tape(first, second, length, SIGMA_TAPE_M)
    yield f"tape from {names}", replace(network, tapes=(*network.tapes, tape)), found.state


def _seen_inside(camera: Camera, places: Array) -> Array:
    """Where places are seen; NaN outside of the photo."""
    with np.errstate(all="ignore"):
        px = camera.project(np.column_stack((places, np.zeros(len(places)))))
        inside = camera.optics.lens.frame.contains(px)
    return np.where(inside[:, None], px, np.nan)

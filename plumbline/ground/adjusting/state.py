"""What an adjustment looks for, and how its steps are laid out in one vector."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from plumbline.frame import Array, Indices
from plumbline.ground.adjusting.network import Network
from plumbline.ground.camera import N_STEPS, Camera


@dataclass(frozen=True)
class Layout:
    """Where in the vector of steps each unknown stands.

    The order: the camera's steps, the refined coefficients, X, Y, Z of each point, a direction
    for each set of parallel lines, an offset for each line, two slopes of the horizon, angle and
    offset of each straight line of the photo.

    Attributes:
        refined: Indices of the refined coefficients.
        points: Number of points.
        groups: Number of sets of parallel lines.
        lines: Number of lines on the plane.
        horizon: Whether there is a horizon.
        straight: Number of other straight lines.
    """

    refined: tuple[int, ...]
    points: int
    groups: int
    lines: int
    horizon: bool
    straight: int

    @classmethod
    def of(cls, network: Network, coefficients: tuple[str, ...]) -> Layout:
        """The layout of a network seen by a lens with these coefficients."""
        return cls(
            tuple(coefficients.index(name) for name in network.refined),
            network.n_points,
            network.n_groups,
            len(network.lines),
            len(network.horizon_px) > 0,
            len(network.straight),
        )

    @cached_property
    def starts(self) -> tuple[int, ...]:
        """Where each kind of unknown begins, and the length of the vector last."""
        sizes = (
            N_STEPS,
            len(self.refined),
            3 * self.points,
            self.groups,
            self.lines,
            2 * self.horizon,
            2 * self.straight,
        )
        return (0, *np.cumsum(sizes).tolist())

    @property
    def size(self) -> int:
        """Length of the vector."""
        return self.starts[-1]

    @property
    def seen(self) -> slice:
        """Camera and refined coefficients: what a new pick needs to know."""
        return slice(0, self.starts[2])

    @property
    def lens(self) -> slice:
        """The refined coefficients."""
        return slice(self.starts[1], self.starts[2])

    def point(self, index: int) -> slice:
        """X, Y, Z of a point."""
        start = self.starts[2] + 3 * index
        return slice(start, start + 3)

    @property
    def places(self) -> Indices:
        """Indices of X and Y of every point, shape (n, 2)."""
        first = self.starts[2] + 3 * np.arange(self.points)
        return np.stack((first, first + 1), axis=1)

    def direction(self, group: int) -> int:
        """The direction of a set of parallel lines."""
        return self.starts[3] + group

    def offset(self, line: int) -> int:
        """The sideways offset of a line on the plane."""
        return self.starts[4] + line

    @property
    def slopes(self) -> slice:
        """The two slopes of the horizon."""
        return slice(self.starts[5], self.starts[6])

    def straight_line(self, index: int) -> slice:
        """Angle and offset of a straight line of the photo."""
        start = self.starts[6] + 2 * index
        return slice(start, start + 2)


@dataclass(frozen=True)
class State:
    """Values of all unknowns.

    Attributes:
        camera: The camera with its lens.
        places: X, Y, Z of the points, shape (n, 3).
        directions: Of the sets of parallel lines, radians from X towards Y.
        anchors: A place near each line on the plane, which its offset is counted from; held.
        offsets: Sideways distance of each line from its anchor.
        slopes: Rise of the horizon's plane along X and Y.
        straight: For each straight line of the photo angle and offset from its anchor, (m, 2).
        straight_anchors: An ideal point near each, shape (m, 2); held.
    """

    camera: Camera
    places: Array
    directions: Array
    anchors: Array
    offsets: Array
    slopes: Array
    straight: Array
    straight_anchors: Array

    def stepped(self, step: Array, layout: Layout) -> State:
        """The state after a step of all unknowns."""
        starts = layout.starts
        camera = self.camera.stepped(step[:N_STEPS])
        if layout.refined:
            values = np.array(camera.optics.lens.coefficients)
            values[list(layout.refined)] += step[layout.lens]
            camera = replace(camera, optics=camera.optics.with_coefficients(values))
        return replace(
            self,
            camera=camera,
            places=self.places + step[starts[2] : starts[3]].reshape(-1, 3),
            directions=self.directions + step[starts[3] : starts[4]],
            offsets=self.offsets + step[starts[4] : starts[5]],
            slopes=self.slopes + (step[layout.slopes] if layout.horizon else 0.0),
            straight=self.straight + step[starts[6] :].reshape(-1, 2),
        )

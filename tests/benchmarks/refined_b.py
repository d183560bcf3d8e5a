"""How well points on the ground tell the lens's b: its standard error by height and points.

    python -m tests.benchmarks.refined_b [trials]

A Coolpix 995 at 8.2 mm (b = −0.02), picks good to half a pixel, ground points to a centimetre, the
ground flat or uneven by 2 cm. The points are spread over what the photo shows from 16 to 40 m, to
its sides; nearer together they tell far less. A row has the standard error that is stated, the root
mean squared error over the trials, and the share of 95 % bars that hold the truth.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace

import numpy as np

from plumbline.ground.adjusting.adjustment import adjust
from tests.benchmarks.road_scenes import EYE, HIGH, Group, observe, optics
from tests.ground.scenes import Scene
from tests.truth import Array

SCENES = {"1.6 m": EYE, "5 m": HIGH}
NEAR_M, FAR_M, ASIDE = 16.0, 40.0, 0.4
COUNTS = (5, 6, 12)


@dataclass(frozen=True)
class Spread(Group):
    """A scene whose points lie at both sides of what the photo shows, and between."""

    @property
    def ground(self) -> Array:
        """The points."""
        across = {5: (-1, 1), 6: (-1, 0, 1), 12: (-1, -0.4, 0.4, 1)}[self.points]
        along = np.geomspace(NEAR_M, FAR_M, 3 if self.points == 12 else 2)
        places = [(side * ASIDE * y, y) for y in along for side in across]
        if self.points == 5:
            places.append((0.0, float(np.sqrt(NEAR_M * FAR_M))))
        return np.array(places, dtype=np.float64)


@dataclass(frozen=True)
class Row:
    """Results for one height and number of points."""

    stated: float
    rms: float
    held: float


def measured(scene: Scene, points: int, trials: int, flat_m: float = 1e-6) -> Row:
    """Adjust so many networks with b free."""
    group = Spread("spread", scene, (), points, ((0.0, 20.0),), flat_m=flat_m)
    unknown = np.diag([0.0, np.inf, 0.0])
    stated: list[float] = []
    errors: list[float] = []
    for seed in range(trials):
        network, _, _ = observe(group, np.random.default_rng([points, seed]))
        network = replace(network, refined=("b",), lens_covariance=unknown)
        found = adjust(network, optics(scene))
        variance = found.cofactor[found.layout.lens, found.layout.lens].item()
        stated.append(found.widening * variance**0.5)
        errors.append(found.state.camera.optics.lens.coefficients[1] - scene.b)
    off, sigma = np.array(errors), np.array(stated)
    held = float(np.mean(np.abs(off) < 1.96 * sigma))
    return Row(float(np.mean(sigma)), float(np.sqrt(np.mean(off**2))), held)


def main() -> None:
    """Print the table."""
    trials = int(sys.argv[1]) if len(sys.argv) > 1 else 300
    print("height  points  uneven  stated     rms      held")
    for flat_m in (1e-6, 0.02):
        for name, scene in SCENES.items():
            for points in COUNTS:
                row = measured(scene, points, trials, flat_m)
                print(
                    f"{name:6}  {points:6}  {100 * flat_m:3.0f} cm  {row.stated:.5f}  "
                    f"{row.rms:.5f}  {100 * row.held:5.1f} %"
                )


if __name__ == "__main__":
    main()

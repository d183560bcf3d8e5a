"""Do the 95 % ellipses of places on the ground hold the truth? Simulated roads, adjusted.

    python -m tests.benchmarks.ground_coverage                     1,000 trials a scene
    python -m tests.benchmarks.ground_coverage --trials 100 --only "5 m"

A row has, for one scene:

    fails      trials without a result; each counts as a miss
    ellipse %  of new picks' places on the plane, those whose 95 % ellipse holds the truth
    points %   the same for the points of the adjustment
    se/CRB     root of the mean squared error over the check places over its Cramér–Rao bound, by
               the geometric mean over these
    σ 25 m     mean standard error that is stated for the farthest check place, in metres
    flat off % coverage of the ellipses where unevenness is left out, as a control (--control)
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace
from zlib import crc32

import numpy as np

from plumbline.errors import PlumblineError
from plumbline.ground.adjusting.adjustment import adjust
from plumbline.ground.ellipses import CHI_2, standard_errors
from plumbline.ground.outcome import rectification_of
from plumbline.ground.rectification import Rectification
from tests.benchmarks.road_scenes import Group, bound, groups, in_datum, observe, optics
from tests.truth import Array


@dataclass(frozen=True)
class Row:
    """Results of one scene."""

    name: str
    fails: int
    ellipse: float
    points: float
    over_bound: float
    far_m: float
    unweighted: float


def covered(places: Array, truth: Array, covariances: Array) -> Array:
    """Which truths lie within the 95 % ellipses."""
    away = places - truth
    held = np.einsum("ni,nij,nj->n", away, np.linalg.pinv(covariances), away) <= CHI_2
    return held & np.isfinite(away).all(axis=1)


def point_covariances(found: Rectification) -> Array:
    """Covariance of each adjusted point."""
    names = list(found.names)
    _, joint = found.joint(names, {})
    return np.stack([joint[i : i + 2, i : i + 2] for i in range(0, 2 * len(names), 2)])


def trial(
    group: Group, number: int, *, control: bool = False
) -> tuple[Array, Array, Array, float, Array]:
    """One trial: check places covered, points covered, squared errors, σ far away, control."""
    network, picks, truth = observe(
        group, np.random.default_rng([crc32(group.name.encode()), number])
    )
    lens = optics(group.scene)
    found = rectification_of(adjust(network, lens))
    places, sure = found.to_ground(picks), found.covariances(picks)
    ground = in_datum(group.ground, group.ground) if group.taped else group.ground
    chosen = slice(2, None) if group.taped else slice(None)  # the datum's points have no error
    points = covered(found.places_m, ground, point_covariances(found))[chosen]
    uneven = np.full(len(truth), np.nan)
    if control:
        flat = rectification_of(adjust(replace(network, flatness_m=1e-6), lens))
        uneven = covered(flat.to_ground(picks), truth, flat.covariances(picks))
    errors = np.sum((places - truth) ** 2, axis=1)
    far = float(standard_errors(sure)[-1])
    return covered(places, truth, sure), points, errors, far, uneven


def measure(group: Group, trials: int, *, control: bool = False) -> Row:
    """Many trials of one scene."""
    made, fails = [], 0
    for number in range(trials):
        try:
            made.append(trial(group, number, control=control))
        except PlumblineError:
            fails += 1
    ellipse, points, errors, far, uneven = (np.array(each) for each in zip(*made, strict=True))
    expected = np.trace(bound(group), axis1=1, axis2=2)
    ratio = np.exp(np.mean(np.log(np.mean(errors, axis=0) / expected))) ** 0.5
    share = len(made) / trials
    return Row(
        group.name,
        fails,
        100 * float(np.mean(ellipse)) * share,
        100 * float(np.mean(points)) * share,
        float(ratio),
        float(np.mean(far)),
        100 * float(np.mean(uneven)),
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--trials", type=int, default=1000)
    parser.add_argument("--only", default="")
    parser.add_argument("--control", action="store_true")
    options = parser.parse_args()
    print(f"{'scene':40} fails ellipse % points % se/CRB   σ far  flat off %")
    chosen = [g for g in groups() if options.only in g.name]
    rows: list[Row] = []
    for group in chosen:
        row = measure(group, options.trials, control=options.control)
        print(
            f"{row.name:40} {row.fails:5d} {row.ellipse:9.1f} {row.points:8.1f} "
            f"{row.over_bound:6.3f} {row.far_m:7.3f} {row.unweighted:9.1f}",
            flush=True,
        )
        rows.append(row)
    pooled = np.exp(np.mean(np.log([row.over_bound for row in rows])))
    print(f"pooled: ellipses {np.mean([r.ellipse for r in rows]):.1f} %, se/CRB {pooled:.3f}")


if __name__ == "__main__":
    main()

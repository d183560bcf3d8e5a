"""What suspicious picks look like: strays, picks of other lines, bent edges, twice the same.

All of it is seen under the robust fit, whose lens and lines the suspects have not moved.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plumbline.fit.robust.agreement import LEAST
from plumbline.fit.robust.fits import Robust
from plumbline.fit.robust.oddities import bends, twins
from plumbline.fit.robust.screening import BEYOND, Picks, reach
from plumbline.fit.robust.worth import rounded
from plumbline.frame import Array
from plumbline.geometry.lines import Lines
from plumbline.result.calibration import Calibration
from plumbline.trust.linearised import Linearised, across_stretch
from plumbline.trust.suspect import Kind, Suspect
from plumbline.wording import count


@dataclass(frozen=True, eq=False)
class _Scene:
    """The robust fit as the questions below need it.

    Attributes:
        calibration: Its calibration.
        linear: The same, linearised.
        picks: All picks undistorted.
        lines: Lines through the kept ones.
        photo: Photo of each line.
        starts: First pick of each line.
        distance_px: Distance of each pick from its line in the photograph; of a line left out as
            a whole, from the line that most of its picks agree on.
        studentised: Residuals in units of their standard deviations.
        within_px: How far a good pick may lie from its line.
    """

    calibration: Calibration
    linear: Linearised
    picks: Picks
    lines: Lines
    photo: NDArray[np.int64]
    starts: NDArray[np.int64]
    distance_px: Array
    studentised: Array
    within_px: float

    def name(self, line: int) -> str:
        """The line's name."""
        return f"line {self.calibration.observations.lines[line].label}"

    def pick(self, number: int) -> str:
        """A pick in words."""
        line, place = self.place(number)
        x, y = self.calibration.observations.lines[line].points_px[place]
        return f"pick {place + 1} of {self.name(line)} at ({x:.0f}, {y:.0f})"

    def place(self, number: int) -> tuple[int, int]:
        """Line of a pick, and its place on it."""
        line = int(self.linear.line[number])
        return line, number - int(self.starts[line])


def suspects_of(calibration: Calibration, found: Robust) -> tuple[Suspect, ...]:
    """Name the suspicious picks.

    Args:
        calibration: The calibration of the robust fit.
        found: The robust fit.
    """
    linear = calibration.linearised
    lost = [line for line, which in enumerate(calibration.kept) if not which.any()]
    lost_pick = np.isin(linear.line, lost)
    scene = _Scene(
        calibration,
        linear,
        found.picks,
        found.agreed.lines,
        np.array([line.photo for line in calibration.observations.lines]),
        np.searchsorted(linear.line, np.arange(linear.n_lines)),
        np.where(lost_pick, found.agreed.distance_px, linear.image_px),
        linear.studentised(calibration.sigma_px),
        reach(calibration.dof, len(linear.line)) * calibration.sigma_px,
    )
    kept = np.concatenate(calibration.kept)
    sigma_px = np.full(linear.n_lines, calibration.sigma_px)
    rounding_px = rounded(found.picks.finest_px)
    bend_px, bent, _ = bends(linear.line, linear.along_px, linear.image_px, sigma_px, rounding_px)
    away = {int(n): _other_line(scene, int(n)) for n in np.flatnonzero(~kept)}
    unsure = ~kept & ~found.agreed.kept & ~found.agreed.wrong
    unclear = set(np.flatnonzero(unsure).tolist())
    wrong = [
        _wrong_pick(scene, number, away, on_bent=bool(bent[linear.line[number]]))
        for number in away
        if number not in unclear
    ]
    rests = [_lost_line(scene, line, unclear) for line in range(linear.n_lines)]
    whole = [
        _bent_line(scene, line, float(bend_px[line]))
        for line in np.flatnonzero(bent).tolist()
        if calibration.kept[line].all()
    ]
    pairs = twins(linear.line, linear.along_px, linear.image_px)
    return (
        *wrong,
        *filter(None, rests),
        *whole,
        *(_twins(scene, one, two) for one, two in pairs.tolist()),
    )


def _wrong_pick(
    scene: _Scene, number: int, away: dict[int, tuple[int, float] | None], *, on_bent: bool
) -> Suspect:
    line, place = scene.place(number)
    residual_px = abs(float(scene.distance_px[number]))
    far = f"{residual_px:.1f} px from its line"
    sentence = f"{scene.pick(number)} lies {far if np.isfinite(residual_px) else 'beyond the fold'}"
    kind: Kind = "stray"
    other = away[number]
    if on_bent:
        kind = "bent line"
        sentence += ", which bends by itself: the edge may not be straight"
    elif other is not None:
        kind = "other line"
        sentence += f" and fits {scene.name(other[0])} within {other[1]:.1f} px"
        partners = [
            n for n, there in away.items() if there and there[0] == line and _on(scene, n, other[0])
        ]
        if partners:
            kind = "exchanged"
            sentence += f": exchanged with {scene.pick(partners[0])}"
    size = abs(float(scene.studentised[number]))
    return Suspect(line, (place,), kind, residual_px, size, True, sentence)


def _on(scene: _Scene, number: int, line: int) -> bool:
    return scene.place(number)[0] == line


def _other_line(scene: _Scene, number: int) -> tuple[int, float] | None:
    """The line that a pick lies on, if it is another one, and its distance from that."""
    lines, own = scene.lines, int(scene.linear.line[number])
    every = np.arange(len(lines.count))
    ideal = scene.picks.ideal.at(np.full(len(every), number))
    along, across = lines.place(ideal.uv, every)
    away = np.abs(across) / across_stretch(ideal, lines, every)
    fits = (lines.count >= LEAST) & (scene.photo == scene.photo[own]) & (every != own)
    fits &= np.abs(along) <= BEYOND * np.sqrt(lines.spread / np.maximum(lines.count, 1.0))
    away = np.where(fits & np.isfinite(away), away, np.inf)
    best = int(np.argmin(away))
    return (best, float(away[best])) if away[best] <= scene.within_px else None


def _lost_line(scene: _Scene, line: int, unclear: set[int]) -> Suspect | None:
    rows = sorted(number for number in unclear if scene.place(number)[0] == line)
    if not rows:
        return None
    return Suspect(
        line,
        tuple(scene.place(number)[1] for number in rows),
        "no line",
        float(np.max(np.abs(scene.distance_px[rows]))),
        float(np.max(np.abs(scene.studentised[rows]))),
        True,
        f"too few picks of {scene.name(line)} agree on a straight line: {count(len(rows), 'pick')} "
        "of it tell nothing",
    )


def _bent_line(scene: _Scene, line: int, bend_px: float) -> Suspect:
    size = len(scene.calibration.kept[line])
    rows = int(scene.starts[line]) + np.arange(size)
    return Suspect(
        line,
        tuple(range(size)),
        "bent line",
        bend_px,
        float(np.max(np.abs(scene.studentised[rows]))),
        False,
        f"{scene.name(line)} bends by {bend_px:.1f} px by itself: the edge may not be straight",
    )


def _twins(scene: _Scene, one: int, two: int) -> Suspect:
    (line, first), (_, second) = scene.place(one), scene.place(two)
    points = scene.calibration.observations.lines[line].points_px
    gap_px = float(np.hypot(*(points[first] - points[second])))
    return Suspect(
        line,
        (first, second),
        "duplicate",
        gap_px,
        float(np.max(np.abs(scene.studentised[[one, two]]))),
        False,
        f"picks {first + 1} and {second + 1} of {scene.name(line)} are {gap_px:.1f} px apart: one "
        "place picked twice counts double",
    )

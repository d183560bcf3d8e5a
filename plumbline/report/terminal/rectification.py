"""A rectification on the terminal: the camera, the points, the errors ahead, what to do next."""

from __future__ import annotations

import numpy as np
from rich import box
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from plumbline.errors import printable
from plumbline.frame import Array
from plumbline.ground.ellipses import ellipse
from plumbline.ground.findings import AGREES, Findings
from plumbline.ground.rectification import Rectification
from plumbline.wording import number

_MOST_POINTS = 30
"""Rows; chosen, they fit a screen."""
_MOST_ADVICE = 3
"""Chosen: the next steps are enough to do."""
LEAST_SHOWN_M = 0.0005
"""Least part of the budget that is shown; chosen, half a millimetre, the last digit printed."""

BUDGET = {
    "picks": "picks of the points",
    "points": "places of the points",
    "flatness": "unevenness at points",
    "pick": "the pick itself",
    "unevenness": "unevenness there",
}
"""Entries of the budget, for people."""

_AHEAD = (1.0, 1.5, 2.0)
"""Distances that the error is shown at, over that of the farthest point; chosen."""


def print_rectification(console: Console, found: Rectification) -> None:
    """Print what a user needs to judge a rectification."""
    told = found.findings
    _print(console, f"Lens: {_plain(told.lens)}")
    _print_camera(console, found, told)
    console.print(_points(told))
    if told.tapes:
        console.print(_tapes(told))
    _print_fit(console, told)
    console.print(_budget(found))
    for doubt in told.suspects:
        _print(console, f"[red]✗[/] {_plain(doubt.what)}: {_plain(doubt.off)}")
    for advice in told.advice[:_MOST_ADVICE]:
        x, y = advice.place_m
        _print(
            console,
            f"→ {_plain(advice.what)}: the error at {number(x, '.1f')}, {number(y, '.1f')} falls "
            f"from {_metres(advice.now_m)} to {_metres(advice.then_m)}, a pick's own left out",
        )
    told_by = "; ".join(f"{each.what} {each.value}" for each in told.settings)
    _print(console, f"Standard errors: {_plain(told_by)}")


def _print_camera(console: Console, found: Rectification, told: Findings) -> None:
    camera = found.camera
    height = camera.height_m * float(np.sqrt(found.covariance[2, 2]))
    focal = camera.focal_px * float(np.sqrt(found.covariance[6, 6]))
    _print(
        console,
        f"Camera: {camera.height_m:.3f} ± {height:.3f} m over the plane, pitch "
        f"{number(camera.pitch_deg, '.2f')}°, roll {number(camera.roll_deg, '.2f')}°, focal length "
        f"{camera.focal_px:.0f} ± {focal:.0f} px",
    )
    for name, value, error in told.refined:
        _print(console, f"Refined: {name} = {number(value, '.5f')} ± {error:.5f}")
    implied = told.implied
    if implied is None:
        _print(console, "The ground alone implies no camera")
        return
    mark = "[yellow]?[/]"
    if implied.away is not None and implied.away <= AGREES:
        mark = "[green]✓[/]"
    elif not implied.agrees:
        mark = "[red]✗[/]"
    _print(
        console,
        f"{mark} The ground alone implies a focal length of {implied.focal_px:.0f} ± "
        f"{implied.focal_error_px:.0f} px, a height of {implied.height_m:.2f} ± "
        f"{implied.height_error_m:.2f} m and a pitch of {number(implied.pitch_deg, '.1f')} ± "
        f"{implied.pitch_error_deg:.1f}°; {_plain(implied.verdict)}",
    )


def _points(told: Findings) -> Table:
    table = Table(box=box.SIMPLE, pad_edge=False, title="Points", title_justify="left")
    for heading in ("point", "pick\noff px", "place\noff m", "95 % ellipse\nm"):
        table.add_column(heading, justify="left" if heading == "point" else "right")
    for point in told.points[:_MOST_POINTS]:
        place = "" if point.place_m is None else f"{float(np.hypot(*point.place_m)):.3f}"
        table.add_row(
            _plain(point.name),
            f"{float(np.hypot(*point.pick_px)):.2f}",
            place,
            f"{point.error_m[0]:.3f} x {point.error_m[1]:.3f}",
        )
    if len(told.points) > _MOST_POINTS:
        table.add_row(f"and {len(told.points) - _MOST_POINTS} more", "", "", "")
    return table


def _tapes(told: Findings) -> Table:
    table = Table(box=box.SIMPLE, pad_edge=False, title="Tapes", title_justify="left")
    for heading in ("tape", "measured\nm", "adjusted\nm", "off\nm"):
        table.add_column(heading, justify="left" if heading == "tape" else "right")
    for tape in told.tapes[:_MOST_POINTS]:
        table.add_row(
            _plain(f"{tape.first}-{tape.second}"),
            f"{tape.metres:.3f}",
            f"{tape.adjusted_m:.3f}",
            number(tape.metres - tape.adjusted_m, "+.3f"),
        )
    return table


def _print_fit(console: Console, told: Findings) -> None:
    if told.redundancy <= 0:
        _print(console, "[yellow]?[/] Nothing is observed twice: the fit cannot be checked")
        return
    ratio = float(np.sqrt(told.cost / told.redundancy))
    mark, words = ("[red]✗[/]", "more than their errors allow")
    if not told.contradictory:
        mark, words = "[green]✓[/]", "as their errors allow"
    _print(
        console,
        f"{mark} The observations differ {words}: {ratio:.2f} of the stated errors, "
        f"{told.redundancy} of them redundant",
    )


def _budget(found: Rectification) -> Table:
    """The error of a new pick at places ahead, and where it comes from."""
    places = ahead(found)
    picks = found.to_photo(places)
    title = "A new pick's place, metres: standard error, where it comes from, 95 % ellipse"
    table = Table(box=box.SIMPLE, pad_edge=False, title=title, title_justify="left")
    table.add_column("at X, Y")
    for x, y in places:
        table.add_column(f"{number(x, '.1f')}, {number(y, '.1f')}", justify="right", no_wrap=True)
    shares = [found.budget(pick) for pick in picks]
    sure = found.covariances(picks)
    table.add_row("standard error", *(f"{_root(each):.3f}" for each in sure))
    for kind in shares[0] if shares else ():
        roots = [_root(share[kind]) for share in shares]
        if max(roots) >= LEAST_SHOWN_M:
            table.add_row(f"  {BUDGET.get(kind, kind)}", *(f"{root:.3f}" for root in roots))
    ellipses = [ellipse(each) for each in sure]
    table.add_row("95 % ellipse", *(f"{long:.2f} x {short:.2f}" for long, short, _ in ellipses))
    return table


def ahead(found: Rectification) -> Array:
    """Places to quote errors at: among the points, at the farthest, and beyond."""
    foot = found.camera.place[:2]
    middle = found.places_m.mean(axis=0)
    way = middle - foot
    distance = max(float(np.hypot(*way)), 1e-9)
    way = way / distance
    far = float(np.max((found.places_m - foot) @ way))
    places = np.stack([middle, *(foot + times * far * way for times in _AHEAD)])
    with np.errstate(all="ignore"):
        picks = found.to_photo(places)
        seen = np.isfinite(found.covariances(picks)).all(axis=(1, 2))
    return places[seen & found.camera.optics.lens.frame.contains(picks)]


def _root(covariance: Array) -> float:
    return float(np.sqrt(np.trace(covariance)))


def _metres(length: float) -> str:
    return f"{length:.3f} m" if length < 1 else f"{length:.2f} m"


def _print(console: Console, text: str) -> None:
    console.print(text, highlight=False, soft_wrap=True)


def _plain(text: str) -> str:
    return escape(printable(text))

"""A rectification as one page of HTML that needs nothing besides itself."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from importlib.resources import files
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plumbline._version import __version__
from plumbline.files import MARK
from plumbline.frame import Array
from plumbline.ground.ellipses import ellipse
from plumbline.ground.findings import InputFile
from plumbline.ground.measure import Measurement
from plumbline.ground.rectification import Rectification
from plumbline.ground.stored import StoredRectification
from plumbline.report.figures import style
from plumbline.report.figures.ground import error_map_figure, photo_figure, plan_figure
from plumbline.report.page.inline_svg import inline
from plumbline.report.page.markup import Element, Node, document, table, tag
from plumbline.report.page.measured import measured
from plumbline.report.terminal.rectification import BUDGET, LEAST_SHOWN_M, ahead
from plumbline.wording import number


def ground_page(
    stored: StoredRectification,
    pixels: NDArray[np.uint8] | None,
    measurements: Sequence[Measurement] = (),
    inputs: Sequence[InputFile] = (),
) -> bytes:
    """The page of a rectification.

    Args:
        stored: The rectification as it was saved.
        pixels: The photo, upright, red, green and blue; None where it is not at hand.
        measurements: What was measured.
        inputs: The files that these came from.
    """
    title = f"Rectified: {stored.photo}"
    sheet = tag("style")
    sheet.text = files("plumbline.report.page").joinpath("page.css").read_text("utf-8")
    head = tag(
        "head",
        tag("meta", charset="utf-8"),
        tag("meta", name="generator", content=f"{MARK} {__version__}"),
        tag("meta", name="viewport", content="width=device-width, initial-scale=1"),
        tag("title", title),
        sheet,
    )
    body = tag(
        "body",
        tag("header", tag("h1", title)),
        tag("main", tag("section", *_section(stored, pixels, measurements, inputs))),
        tag("footer", f"Made by plumbline {__version__}."),
    )
    return document(head, body)


def _section(
    stored: StoredRectification,
    pixels: NDArray[np.uint8] | None,
    measurements: Sequence[Measurement],
    inputs: Sequence[InputFile],
) -> Iterator[Node]:
    found = stored.rectification
    yield from _camera(found)
    yield from measured(measurements)
    shown = "" if pixels is not None else " The photo itself is not at hand."
    yield _figure(
        1,
        lambda: photo_figure(found, pixels),
        f"The points, the polygon around them, and by how much picks are off.{shown}",
    )
    yield _figure(2, lambda: plan_figure(found), "The ground from above, with the camera.")
    yield _figure(
        3,
        lambda: error_map_figure(found),
        "Standard error of a new pick's place, metres, where the photo shows the ground.",
    )
    yield tag("h3", "Where the error comes from")
    yield _budget(found)
    yield tag("h3", "Points")
    yield _points(found)
    if found.findings.tapes:
        yield tag("h3", "Tapes")
        yield _tapes(found)
    yield tag("h3", "Doubts and advice")
    yield _doubts(found)
    yield tag("h3", "Notes")
    notes = found.findings.notes
    yield tag("ul", *(tag("li", note) for note in notes)) if notes else tag("p", "None.")
    yield tag("h3", "How it was made")
    yield tag("dl", *(node for pair in _provenance(stored, inputs) for node in pair))


def _camera(found: Rectification) -> Iterator[Node]:
    camera, told = found.camera, found.findings
    yield tag(
        "p",
        f"The camera stood {camera.height_m:.3f} m over the plane, "
        f"pitch {number(camera.pitch_deg, '.2f')}°, roll {number(camera.roll_deg, '.2f')}°, "
        f"with a focal length of {camera.focal_px:.0f} px.",
        class_="finding",
    )
    implied = told.implied
    if implied is not None:
        yield tag(
            "p",
            f"The ground alone implies a focal length of {implied.focal_px:.0f} ± "
            f"{implied.focal_error_px:.0f} px, a height of {implied.height_m:.2f} ± "
            f"{implied.height_error_m:.2f} m and a pitch of {number(implied.pitch_deg, '.1f')} ± "
            f"{implied.pitch_error_deg:.1f}°; {implied.verdict}.",
        )
    for name, value, error in told.refined:
        yield tag("p", f"Refined: {name} = {number(value, '.5f')} ± {error:.5f}.")


def _figure(number: int, draw: Callable[[], Any], shows: str) -> Element:
    with style.drawing():
        drawing = inline(draw(), f"f{number}-", shows)
    return tag("figure", drawing, tag("figcaption", tag("b", f"Figure {number}."), f" {shows}"))


def _budget(found: Rectification) -> Element:
    places = ahead(found)
    picks = found.to_photo(places)
    shares = [found.budget(pick) for pick in picks]
    sure = found.covariances(picks)
    rows: list[list[Node]] = [["standard error", *(f"{_root(each):.3f}" for each in sure)]]
    rows += [
        [BUDGET.get(kind, kind), *(f"{_root(share[kind]):.3f}" for share in shares)]
        for kind in (shares[0] if shares else ())
        if any(_root(share[kind]) >= LEAST_SHOWN_M for share in shares)
    ]
    ellipses = [ellipse(each) for each in sure]
    rows.append(["95 % ellipse", *(f"{long:.2f} × {short:.2f}" for long, short, _ in ellipses)])
    return table(["at X, Y (m)", *(f"{x:.1f}, {y:.1f}" for x, y in places)], rows)


def _points(found: Rectification) -> Element:
    rows: list[list[Node]] = []
    for point, (x, y) in zip(found.findings.points, found.places_m, strict=True):
        off = "" if point.place_m is None else f"{float(np.hypot(*point.place_m)):.3f}"
        rows.append(
            [
                point.name,
                f"{x:.3f}",
                f"{y:.3f}",
                f"{float(np.hypot(*point.pick_px)):.2f}",
                off,
                f"{point.error_m[0]:.3f} × {point.error_m[1]:.3f}",
            ]
        )
    heads = ("point", "X, m", "Y, m", "pick off, px", "place off, m", "95 % ellipse, m")
    return table(heads, rows)


def _tapes(found: Rectification) -> Element:
    rows: list[list[Node]] = [
        [
            f"{tape.first}-{tape.second}",
            f"{tape.metres:.3f}",
            f"{tape.adjusted_m:.3f}",
            number(tape.metres - tape.adjusted_m, "+.3f"),
        ]
        for tape in found.findings.tapes
    ]
    return table(("tape", "measured, m", "adjusted, m", "off, m"), rows)


def _doubts(found: Rectification) -> Element:
    told = found.findings
    items = [tag("li", f"{doubt.what}: {doubt.off}") for doubt in told.suspects]
    for advice in told.advice:
        x, y = advice.place_m
        items.append(
            tag(
                "li",
                f"{advice.what}: the error at {x:.1f}, {y:.1f} falls from {advice.now_m:.3f} to "
                f"{advice.then_m:.3f} m, a pick's own left out",
            )
        )
    return tag("ul", *items) if items else tag("p", "None.")


def _provenance(
    stored: StoredRectification, inputs: Sequence[InputFile]
) -> Iterator[tuple[Node, Node]]:
    told = stored.rectification.findings

    def row(name: str, *content: Node) -> tuple[Node, Node]:
        return tag("dt", name), tag("dd", *content)

    yield row("plumbline", __version__)
    if stored.command:
        yield row("command", tag("code", stored.command))
    for name, digest in (
        (stored.photo, stored.photo_sha256),
        *((each.name, each.sha256) for each in (*told.inputs, *inputs)),
    ):
        yield row("file", name, tag("br"), tag("code", f"SHA-256 {digest}"))
    yield row("lens", told.lens)
    for setting in told.settings:
        yield row(setting.what, setting.value)
    ratio = float(np.sqrt(told.cost / told.redundancy)) if told.redundancy > 0 else 0.0
    yield row("fit", f"{told.redundancy} observations redundant, {ratio:.2f} of the stated errors")


def _root(covariance: Array) -> float:
    return float(np.sqrt(np.trace(covariance)))

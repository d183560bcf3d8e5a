"""A report as one page of HTML that needs nothing besides itself."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.resources import files

from plumbline._version import __version__
from plumbline.files import MARK
from plumbline.report.page import tables
from plumbline.report.page.figures import count_figures, figures, photo_name
from plumbline.report.page.markup import Element, Node, document, tag
from plumbline.report.page.verdict import limits, recommends_the_fitted, verdict
from plumbline.report.photos import FoundPhotos
from plumbline.report.terminal.summary import lens_title
from plumbline.result.calibration import Calibration
from plumbline.result.comparison import Comparison
from plumbline.result.pair import PairCalibration
from plumbline.result.sentence import finding_sentence
from plumbline.wording import count

_RESIDUALS = {
    "image": "distances in the photograph's own pixels (image)",
    "corrected": "distances in the corrected photo (corrected)",
}


@dataclass(frozen=True, eq=False)
class Part:
    """One lens of a report.

    Attributes:
        calibration: Its calibration.
        found: Its photos.
        compared: The models side by side; None where they were not compared.
    """

    calibration: Calibration
    found: FoundPhotos
    compared: Comparison | None = None


@dataclass(frozen=True)
class Assignment:
    """What a report is for.

    Attributes:
        case: Name or number of the case; may be empty.
        examiner: Who calibrated; may be empty.
    """

    case: str = ""
    examiner: str = ""


def page_bytes(parts: Sequence[Part], assignment: Assignment) -> bytes:
    """The page; the same calibrations and photos give the same bytes.

    Args:
        parts: One a lens.
        assignment: What the report is for.
    """
    names = [lens_title(part.calibration.observations) for part in parts]
    style = files("plumbline.report.page").joinpath("page.css").read_text("utf-8")
    head = tag(
        "head",
        tag("meta", charset="utf-8"),
        tag("meta", name="generator", content=f"{MARK} {__version__}"),
        tag("meta", name="viewport", content="width=device-width, initial-scale=1"),
        tag("title", f"Lens calibration: {', '.join(names)}"),
        _style(style),
    )
    sections: list[Element] = []
    first = 1
    for part, name in zip(parts, names, strict=True):
        title = tag("h2", name) if len(parts) > 1 else None
        sections.append(tag("section", title, *_section(part, first)))
        first += count_figures(part.calibration)
    heading = names[0] if len(parts) == 1 else count(len(parts), "lens", "lenses")
    body = tag(
        "body",
        tag("header", tag("h1", f"Lens calibration: {heading}"), _assigned(assignment)),
        tag("main", *sections),
        tag("footer", f"Made by plumbline {__version__}."),
    )
    return document(head, body)


def _assigned(assignment: Assignment) -> Element | None:
    given = [
        (name, text)
        for name, text in (("Case", assignment.case), ("Examiner", assignment.examiner))
        if text
    ]
    rows = [node for name, text in given for node in (tag("dt", name), tag("dd", text))]
    return tag("dl", *rows) if rows else None


def _style(text: str) -> Element:
    """Our own style sheet: the one text of a page that `tag` must not touch."""
    element = tag("style")
    element.text = text
    return element


def _section(part: Part, first: int) -> Iterator[Node]:
    calibration = part.calibration
    yield tag("p", f"{finding_sentence(calibration)}.", class_="finding")
    yield tag("p", verdict(calibration, part.compared), class_="quote")
    yield tag("dl", *(node for pair in _subject(part) for node in pair))
    yield from (tag("p", f"{note}.", class_="muted") for note in part.found.notes)
    yield from figures(calibration, part.found, first)
    yield tag("h3", "Coefficients")
    yield from tables.coefficients(calibration)
    matrix = tables.correlations(calibration)
    if matrix is not None:
        yield tag("h3", "Correlations")
        yield matrix
    if isinstance(calibration, PairCalibration):
        yield tag("h3", "Matches by part of the photo")
        yield tables.straightness(calibration)
    else:
        yield tag("h3", "Straightness of the lines")
        yield tables.straightness(calibration)
        yield tag("h3", "Suspicious picks")
        yield tables.suspects(calibration)
    yield tag("h3", "Checks")
    yield tables.checks(calibration)
    yield from (tag("p", sentence, class_="muted") for sentence in tables.errors(calibration))
    if part.compared is not None:
        yield tag("h3", "Models compared")
        fitted = recommends_the_fitted(calibration, part.compared)
        yield from tables.comparison(part.compared, quoted=fitted)
    yield tag("h3", "Limits")
    yield tag("ul", *(tag("li", sentence) for sentence in limits(calibration)))
    notes = tables.further_notes(calibration)
    if notes:
        yield tag("h3", "Notes")
        yield tag("ul", *(tag("li", note) for note in notes))
    yield tag("h3", "How it was made")
    yield tag("dl", *(node for pair in _provenance(part) for node in pair))
    yield tag("h3", "Picks")
    yield from tables.picks(calibration)


def _row(name: str, *content: Node) -> tuple[Node, Node]:
    return tag("dt", name), tag("dd", *content)


def _subject(part: Part) -> Iterator[tuple[Node, Node]]:
    """Which camera, lens and photos it is about."""
    observations = part.calibration.observations
    facts = observations.lenses[0]
    serials = dict.fromkeys(photo.serial for photo in observations.photos if photo.serial)
    focal_mm = facts.focal_length_mm(part.calibration.lens.frame)
    rows = {
        "camera": facts.camera,
        "serial number": ", ".join(serials),
        "lens": facts.model,
        "focal length": f"{focal_mm:.4g} mm" if focal_mm else "",
    }
    yield from (_row(name, text or "not known") for name, text in rows.items())
    pictures = zip(observations.photos, part.found.pictures, strict=True)
    for photo, picture in pictures:
        width, height = photo.frame.size
        shown = f"{photo_name(photo)}, {width} × {height} px"
        if photo.pixel_aspect != 1:
            shown += f", pixel aspect {photo.pixel_aspect:g}"
        if photo.taken:
            shown += f", taken {photo.taken} (EXIF)"
        note = ""
        if not photo.sha256 and picture is not None:
            note = " (of the picture shown; that of the picked one was not recorded)"
        sha256 = photo.sha256 or (picture.sha256 if picture else "")
        yield _row("photo", shown, *_checksum(sha256, note))


def _provenance(part: Part) -> Iterator[tuple[Node, Node]]:
    calibration = part.calibration

    yield _row("plumbline", calibration.version)
    if calibration.command:
        yield _row("command", tag("code", calibration.command))
    for origin in calibration.observations.origins:
        yield _row("points", f"{origin.path} ({origin.format})", *_checksum(origin.sha256))
    model = calibration.lens.model
    yield _row(
        "model",
        f"{calibration.model}: {model.formula}, {model.direction}; r in units of {model.unit}, "
        f"scale 1 at r = {model.gauge}. {model.source}",
    )
    yield _row("free", ", ".join(calibration.free))
    yield _row("residuals", _RESIDUALS[calibration.residual])
    yield _row(
        "fit", f"{'robust' if calibration.robust else 'least squares'}; {calibration.reason}"
    )


def _checksum(sha256: str, note: str = "") -> tuple[Node, ...]:
    return (tag("br"), tag("code", f"SHA-256 {sha256}"), note) if sha256 else ()

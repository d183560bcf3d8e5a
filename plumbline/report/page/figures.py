"""The figures of a page, with what each shows in words."""

from __future__ import annotations

from collections.abc import Iterator

from plumbline.observations import Photo
from plumbline.report.figures import FIGURES, OF_EVERY_PHOTO, Subject, style
from plumbline.report.page.inline_svg import inline
from plumbline.report.page.markup import Element, tag
from plumbline.report.photos import FoundPhotos
from plumbline.result.calibration import Calibration
from plumbline.result.pair import PairCalibration

_SHOWS = {
    "photo": "The picks, the straight lines fitted to them as the lens shows them, and how far "
    "each pick lies from its line, magnified as stated",
    "lines": "How far every line is from straight before the fit and after, on a scale of equal "
    "ratios (rms: root mean square of its picks)",
    "curve": "How far the lens displaces points outwards, relative to the scale at the centre "
    "(negative: towards the centre). Lines see neither scale nor place of the corrected photo: "
    "the band holds after the best common ones",
    "displacement": "Displacement over the photo, as in the curve. Arrows lead from where a "
    "perfect perspective would show a point towards where the lens shows it",
    "uncertainty": "Standard error of the correction over the photo, the one to quote",
    "corrected": "The photo after the correction: its picks lie on straight lines as far as they "
    "were picked well",
    "radius": "Residuals over the distance from the distortion centre. A trend says that the "
    "model cannot follow the lens",
    "along": "Residuals along the lines. A bow of one line says that the edge was not straight, "
    "a bow shared by all that the model cannot follow the lens",
}
_SHOWS_OF_A_PAIR = {
    "photo": "The matches in the original, and how far each lies from where the lens puts the "
    "point that it matches in the corrected picture, magnified as stated",
    "curve": "How far the lens displaces points outwards, relative to the scale at the centre "
    "(negative: towards the centre). The corrected picture's scale and place are fitted: the "
    "band holds after the best common ones",
    "radius": "Residuals, outwards, over the distance from the distortion centre. A trend says "
    "that the model cannot follow the correction",
}
_OF_LINES = ("lines", "along", "corrected")
_PAIR = ("displacement", "uncertainty")


def figures(calibration: Calibration, found: FoundPhotos, first: int) -> Iterator[Element]:
    """The figures of one lens.

    Args:
        calibration: Its calibration.
        found: Its photos.
        first: Number of the first figure.
    """
    number = first
    pair: list[Element] = []
    for name in FIGURES:
        for photo in shown_photos(name, calibration):
            figure = _figure(name, Subject(calibration, photo, found.pictures[photo]), number)
            number += 1
            if name not in _PAIR:
                yield figure
                continue
            pair.append(figure)
            if len(pair) == len(_PAIR):
                yield tag("div", *pair, class_="pair")


def shown_photos(name: str, calibration: Calibration) -> range:
    """For which photos a figure is drawn: every one, or the first to stand for them all."""
    if name in _OF_LINES and isinstance(calibration, PairCalibration):
        return range(0)
    return range(len(calibration.observations.photos) if name in OF_EVERY_PHOTO else 1)


def count_figures(calibration: Calibration) -> int:
    """How many figures a lens has."""
    return sum(len(shown_photos(name, calibration)) for name in FIGURES)


def _figure(name: str, subject: Subject, number: int) -> Element:
    shows = _SHOWS[name]
    if isinstance(subject.calibration, PairCalibration):
        shows = _SHOWS_OF_A_PAIR.get(name, shows)
    if name in OF_EVERY_PHOTO:
        photo = subject.calibration.observations.photos[subject.photo]
        empty = "" if subject.picture else " The photo itself is not at hand."
        shows = f"{photo_name(photo)}. {shows}.{empty}"
    else:
        shows = f"{shows}."
    with style.drawing():
        drawing = inline(FIGURES[name](subject), f"f{number}-", shows)
    shown = tag("div", drawing, class_="drawing")
    return tag("figure", shown, tag("figcaption", tag("b", f"Figure {number}."), f" {shows}"))


def photo_name(photo: Photo) -> str:
    """What to call a photo."""
    return photo.name or photo.source or f"Photo {photo.number}"

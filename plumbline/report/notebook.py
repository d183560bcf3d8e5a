"""What a calibration shows of itself in Python: figures, and the finding with its table."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from lxml import html  # pyright: ignore[reportAttributeAccessIssue]

from plumbline.errors import OptionError
from plumbline.report.figures import FIGURES, Subject, style
from plumbline.report.page.figures import shown_photos
from plumbline.report.page.markup import tag
from plumbline.report.page.tables import coefficients
from plumbline.report.photos import find_photos
from plumbline.result.sentence import finding_sentence

if TYPE_CHECKING:
    from plumbline.result.calibration import Calibration


class Plots:
    """The figures of a report, one method each, as in `calibration.plot.curve()`.

    Each takes the index of the photo to show, 0 by default, and returns a
    `matplotlib.figure.Figure`, which notebooks show and whose `savefig` writes it.
    """

    def __init__(self, calibration: Calibration) -> None:
        self._calibration = calibration

    def __dir__(self) -> list[str]:
        return list(FIGURES)

    def __getattr__(self, name: str) -> Callable[..., Any]:
        if name not in FIGURES:
            raise AttributeError(f"there is no figure {name!r}: use one of {', '.join(FIGURES)}")
        draw = partial(self._drawn, name)
        draw.__doc__ = FIGURES[name].__doc__
        return draw

    def _drawn(self, name: str, photo: int = 0) -> Any:
        calibration = self._calibration
        n_photos = len(calibration.observations.photos)
        if photo not in range(n_photos):
            raise OptionError(
                f"there is no photo number {photo!r}", hint=f"give 0 to {n_photos - 1}"
            )
        if not shown_photos(name, calibration):
            raise OptionError(f"the matches of two pictures have no figure {name!r}")
        (found,) = find_photos([calibration], None)
        with style.drawing():
            return FIGURES[name](Subject(calibration, photo, found.pictures[photo]))


def html_of(calibration: Calibration) -> str:
    """The finding, the error to quote and the coefficients as HTML, for a notebook."""
    quoted = calibration.quoted
    shown = tag(
        "div",
        tag("p", tag("b", finding_sentence(calibration))),
        tag("p", quoted.sentence) if quoted is not None else None,
        *coefficients(calibration),
    )
    return str(html.tostring(shown, encoding="unicode"))

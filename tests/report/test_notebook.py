"""What a calibration shows of itself in Python."""

from __future__ import annotations

import pickle
import re
from typing import Any

import numpy as np
import pytest
from lxml import html  # pyright: ignore[reportAttributeAccessIssue]
from matplotlib.figure import Figure

from plumbline.errors import OptionError
from plumbline.report.figures import FIGURES
from plumbline.result.sentence import finding_sentence
from tests.report.made import SCRIPT, building, hostile

PNG = b"\x89PNG"


def shown_in_a_notebook(made: Any) -> str:
    return made._repr_html_()


@pytest.mark.parametrize("name", FIGURES)
def test_every_figure_is_a_method_that_returns_it(name: str) -> None:
    figure = getattr(building().plot, name)()
    assert isinstance(figure, Figure)
    assert figure.axes
    shown: Any = figure
    assert shown._repr_png_().startswith(PNG)


def test_figures_are_listed_and_explained() -> None:
    plot = building().plot
    assert set(dir(plot)) == set(FIGURES)
    assert "95 % band" in (plot.curve.__doc__ or "")
    with pytest.raises(AttributeError, match="use one of photo, lines, curve"):
        plot.nonsense()
    with pytest.raises(OptionError, match="no photo number 1"):
        plot.photo(1)


def test_a_figure_survives_another_process() -> None:
    figure = pickle.loads(pickle.dumps(building().plot.curve()))
    assert figure._repr_png_().startswith(PNG)


def test_a_notebook_shows_the_finding_and_the_coefficients() -> None:
    made = building()
    page = html.fragment_fromstring(shown_in_a_notebook(made))
    text = page.text_content()
    assert finding_sentence(made) in text
    assert made.quoted is not None
    assert made.quoted.sentence in text
    (table,) = page.iter("table")
    rows = [[cell.text_content() for cell in row.iter("th", "td")] for row in table.iter("tr")]
    assert [row[0] for row in rows[1:]] == [*"abcde"]
    for name, shown, _, error, *_ in rows[1:4]:
        assert float(shown.replace("−", "-")) == pytest.approx(made.coefficients[name], abs=5e-7)
        assert float(error[2:]) == pytest.approx(made.standard_errors[name], abs=5e-7)


def test_names_from_files_are_text_in_a_notebook() -> None:
    assert SCRIPT not in shown_in_a_notebook(hostile())


def test_repr_is_one_line() -> None:
    for each in (building(), building().observations):
        assert re.fullmatch(r"<.+>", repr(each))
        assert np.ndim(repr(each)) == 0

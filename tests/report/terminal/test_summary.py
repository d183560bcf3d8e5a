"""The summary on the terminal: its numbers keep the digits that mean something."""

from __future__ import annotations

from dataclasses import replace
from io import StringIO

import numpy as np
import pytest
from rich.console import Console

from plumbline.frame import Frame
from plumbline.geometry.lens import Lens
from plumbline.models import get_model
from plumbline.observations import Line, Observations, Photo
from plumbline.report.terminal.summary import coefficients_table, print_summary
from plumbline.result.calibration import Calibration
from plumbline.result.sentence import finding_sentence
from plumbline.trust.bootstrap import Bootstrap
from tests.report.made import building, without_a_line


def made(values: dict[str, float], errors: dict[str, float]) -> Calibration:
    line = Line(np.array([[1.0, 2], [30, 4.5], [50, 6]]), 0, "t3")
    zero = dict.fromkeys("abcde", 0.0)
    return Calibration(
        observations=Observations((Photo((100, 80)),), (line,)),
        lens=Lens(get_model("ptlens"), Frame(100, 80), zero | values),
        free=tuple(errors),
        start=zero,
        residual="image",
        covariance=np.diag(np.square(list(errors.values()))),
        sigma_px=0.1,
        dof=1,
        residuals_px=(np.zeros(3),),
        rms_corrected_px=0.1,
        converged=True,
        reason="done",
    )


def shown(values: dict[str, float], errors: dict[str, float]) -> dict[str, list[str]]:
    """The table's rows as words, by coefficient."""
    out = StringIO()
    Console(file=out, width=100).print(coefficients_table(made(values, errors)))
    rows = [line.split() for line in out.getvalue().splitlines()]
    return {row[0]: row[1:] for row in rows if row and row[0] in "abcde"}


@pytest.mark.parametrize(
    ("value", "error", "printed"),
    [
        (0.0320594, 0.0086, "0.032059 ± 0.008600"),
        (-1.2345e-6, 2.345e-6, "−0.0000012 ± 0.0000023"),
        (0.5, 4.4e-9, "0.5000000000 ± 0.0000000044"),
        (12.5, 1.25, "12.500000 ± 1.250000"),
        (0.25, 0.0, "0.250000 ± 0.000000"),
    ],
)
def test_coefficients_show_two_digits_of_their_error(
    value: float, error: float, printed: str
) -> None:
    assert " ".join(shown({"a": value}, {"a": error})["a"]).startswith(printed)


def summary(made: Calibration) -> list[str]:
    """The lines of the summary."""
    out = StringIO()
    print_summary(Console(file=out, width=100), [made], [])
    return [line.strip() for line in out.getvalue().splitlines()]


def test_what_was_left_out_is_not_counted_as_fitted() -> None:
    lines = summary(without_a_line())
    (counted,) = [line for line in lines if "σ̂" in line]
    assert counted.startswith("98 of 108 points on 11 of 12 lines; σ̂ 0.")
    assert counted.endswith(" px with 75 degrees of freedom")  # 98 − 2 · 11 − 1
    assert ["5", "0", "left", "out"] in [line.split() for line in lines]
    (kept,) = [line for line in lines if line.startswith("8  ")]
    assert kept.split()[1] == "8"
    plain = summary(building())
    assert any(line.startswith("140 points on 14 lines; σ̂") for line in plain)


def test_a_bootstrap_stands_beside_the_error_to_quote() -> None:
    fitted = building()
    sure, quoted = fitted.displacement, fitted.quoted_displacement
    assert sure is not None
    assert quoted is not None
    again = Bootstrap(90, 10, 4 * fitted.covariance, np.zeros((3, 2)))
    lines = summary(replace(fitted, bootstrap=again))
    (first, second) = [line for line in lines if line.startswith("bootstrap")]
    assert first.startswith("bootstrap of 90 fits: a ± 0.0033")
    assert first.endswith("(10 more found no minimum)")
    assert second == (
        f"bootstrap: the correction is uncertain by {2 * sure.worst_px:#.2g} px; that checks the "
        f"{sure.worst_px:#.2g} px of independent picking errors, and {quoted.worst_px:#.2g} px "
        "stays the error to quote"
    )


def test_the_finding_of_next_to_no_degrees_of_freedom_carries_a_doubt() -> None:
    told = finding_sentence(made({"b": -0.03}, {"b": 0.001}))
    assert told.endswith("; error bars from 1 degree of freedom are nearly worthless")
    assert "error bars" not in finding_sentence(building())


def test_the_centre_shows_two_digits_of_its_error() -> None:
    rows = shown({"d": 1.25, "e": -0.5}, {"d": 0.125, "e": 0.00021})
    assert rows["d"][:5] == ["1.250", "px", "±", "0.125", "px"]
    assert rows["e"][:5] == ["−0.50000", "px", "±", "0.00021", "px"]


def test_held_values_are_not_shown_as_zero() -> None:
    rows = shown({"a": 1.26e-8, "c": 0.5}, {"b": 0.01})
    assert rows["a"] == ["0.000000013", "held"]
    assert rows["c"] == ["0.500000", "held"]
    assert rows["e"] == ["0.000", "px", "held"]

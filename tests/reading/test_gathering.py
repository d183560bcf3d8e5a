"""The verbs minus their parsing."""

from __future__ import annotations

import numpy as np

from plumbline.cli.tools.narration import name_the_source
from plumbline.errors import CollapsedFitError
from plumbline.observations import Line, Observations, Origin, Photo


def test_an_error_that_is_named_stays_as_it_was() -> None:
    line = Line(np.array([[1.0, 2], [3, 4], [5, 6.5]]))
    part = Observations((Photo((9, 9), "a.jpg", number=2),), (line,), origins=(Origin("x", "csv"),))
    error = CollapsedFitError("it is bad", hint="mend it")
    named = name_the_source(error, part, 2)
    assert (named.message, str(named), named.hint) == (
        "x: photo 2 a.jpg: it is bad",
        "x: photo 2 a.jpg: it is bad",
        "mend it",
    )
    assert isinstance(named, CollapsedFitError)
    assert (error.message, str(error)) == ("it is bad", "it is bad")

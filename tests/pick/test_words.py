"""Sentences on the page: none names an option of the command line."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator

import pytest

from plumbline.pick.words import on_page
from tests.pick.served import ROOT

OPTION = re.compile(r"(?<![\w-])--[a-z]")
ROOMS = ("fit", "formats", "geometry", "photos", "report", "result", "trust", "writing")


def sentences() -> Iterator[str]:
    """Strings of the rooms that the page hears of; what is filled in stands as "5"."""
    for room in ROOMS:
        for path in sorted((ROOT / "plumbline" / room).rglob("*.py")):
            for node in ast.walk(ast.parse(path.read_text("utf-8"))):
                if isinstance(node, ast.JoinedStr):
                    parts = (getattr(part, "value", None) for part in node.values)
                    yield "".join(part if isinstance(part, str) else "5" for part in parts)
                elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                    yield node.value


def test_no_option_is_left() -> None:
    told = [each for each in sentences() if OPTION.search(each) and "\n" not in each]
    assert len(told) > 20
    assert [each for each in told if OPTION.search(on_page(each))] == []


@pytest.mark.parametrize(
    ("said", "shown"),
    [
        (
            "2 picks of 212 are suspicious: look at each of them, or leave them out with --robust",
            "2 picks of 212 are suspicious: look at each of them, or correct or delete them",
        ),
        (
            "the mount is not known and written as Generic (--mount)",
            "the mount is not known and written as Generic; give it below",
        ),
        (
            "the crop factor 1 is good to 1.2 % (--crop-factor)",
            "the crop factor 1 is good to 1.2 %; give it below",
        ),
        (
            "the picks put the distortion centre at d = 1.0 ± 0.2 px: free it: --free a,b,c,d,e",
            "the picks put the distortion centre at d = 1.0 ± 0.2 px: compare the models: those "
            "with a centre free it",
        ),
        ("facade.jpg was not found (--photo names it)", "facade.jpg was not found"),
        ("nothing of all this - not -- a word", "nothing of all this - not -- a word"),
        ("a file name with a\nbreak", "a file name with a�break"),
    ],
)
def test_remedies_are_those_of_the_page(said: str, shown: str) -> None:
    assert on_page(said) == shown

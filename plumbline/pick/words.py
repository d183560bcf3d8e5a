"""Sentences of plumbline for who sits before the page, where the command line has no say."""

from __future__ import annotations

import re

from plumbline.errors import printable

_ON_PAGE = (
    (r" \((--maker|--lens-name|--mount|--focal|--crop-factor)\)", "; give it below"),
    (r"give (it|them) with (--focal|--crop-factor)( and --crop-factor)?", r"give \1 below"),
    (r"fit with --model (.*?)(, or write -o .*)?$", r"choose the model \1"),
    (r"free it: --free .*", "compare the models: those with a centre free it"),
    (r"free fewer coefficients with --free", "choose a model with fewer coefficients"),
    (r"\(--free, --hold\)", "(compare the models)"),
    (r"hold the (distortion )?centre \(--hold d,e\)", r"choose a model without a \1centre"),
    (r"leave (it|them) out with --robust", r"correct or delete \1"),
    (r"plumbline fit --robust leaves them out", "correct or delete them"),
    (r": --robust fits the others", ": correct or delete them"),
    (r"choose another name with -o, or replace it with --overwrite", "move that file away"),
    (r"check that every pick is on its line,? and that .* \(and --grid\) is right", "check that "
     "every pick is on its line"),
    (r" \(--[a-z][^)]*\)", ""),
    (r"(, or | or |, |; |: )?[^,;:()]*(?<![\w-])--[a-z][^;]*", ""),
)  # fmt: skip
"""Patterns and what the page says instead. The last two leave out what it has no words for."""


def on_page(text: str) -> str:
    """A sentence, safe to show, with the page's remedies in place of options."""
    for pattern, instead in _ON_PAGE:
        text = re.sub(pattern, instead, text)
    return printable(text)

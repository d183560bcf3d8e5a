"""One question about a result, and its answer."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Check:
    """One question and its answer.

    Attributes:
        name: What was looked at, in a word or two.
        passed: Whether nothing is wrong.
        finding: What was found.
        remedy: What to do about it; empty where nothing is wrong.
        doubtful: Whether it passed, but deserves a look.
    """

    name: str
    passed: bool
    finding: str
    remedy: str = ""
    doubtful: bool = False

    @property
    def sentence(self) -> str:
        """Finding and remedy."""
        return f"{self.finding}: {self.remedy}" if self.remedy else self.finding

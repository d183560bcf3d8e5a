"""The errors plumbline raises, and how their sentences reach a terminal unharmed.

    PlumblineError
    ├── ReadError                a file that cannot be read or makes no sense
    ├── WriteError               a file that cannot or must not be written
    ├── OptionError              an argument that contradicts the data or another argument
    │   └── UnsupportedModelError
    ├── DegenerateLinesError     the lines cannot show what is asked of them
    │   └── CollapsedFitError    the fit ran off to a nonsensical lens
    ├── PairError                two pictures that are not an original and its correction
    ├── UnsettledError           a fit without a result is to be written for other programs
    └── FoldedError              a point lies where the distortion folds over

Every message is one sentence for the user; `hint` is the remedy. A fit that does not
converge is not an exception: see `Calibration.converged`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path  # no other module that --help loads needs it


Made = TypeVar("Made")


class PlumblineError(Exception):
    """Base of all errors that plumbline raises on purpose.

    Args:
        message: What is wrong, in one sentence.
        hint: What the user can do about it; may be empty.
    """

    def __init__(self, message: str, *, hint: str = "") -> None:
        super().__init__(message)
        self.message = message
        self.hint = hint


def or_error(make: Callable[[], Made]) -> Made | PlumblineError:
    """What is made, or the error that this ends in, free of the frames it came through."""
    try:
        return make()
    except PlumblineError as error:
        return error.with_traceback(None)


def refuse_other_type(value: object, wanted: type | tuple[type, ...], name: str, hint: str) -> None:
    """Refuse an argument of another type, for those who run no type checker.

    Raises:
        OptionError: the value is not of the type that is wanted.
    """
    if not isinstance(value, wanted):
        raise OptionError(f"{name} expected, not {type(value).__name__}", hint=hint)


def printable(text: str) -> str:
    """Text from a file or a file name, made safe to show: no line breaks, no escape codes."""
    return "".join(c if c.isprintable() else "�" for c in text)


class _FileError(PlumblineError):
    """An error about a file, and perhaps a row of its text (`line`, counted from 1).

    A sentence says "row", since a "line" is one that was picked.
    """

    def __init__(
        self, message: str, *, path: str | Path = "", line: int | None = None, hint: str = ""
    ) -> None:
        where = str(path) + (f", row {line}" if line is not None else "")
        super().__init__(f"{where}: {message}" if where else message, hint=hint)
        self.path = str(path)
        self.line = line


class ReadError(_FileError):
    """A file is missing, unreadable, or does not hold what it should."""


class WriteError(_FileError):
    """A file cannot be written, or must not be overwritten."""


class OptionError(PlumblineError, ValueError):
    """An argument is unknown, or contradicts the data or another argument."""


class UnsupportedModelError(OptionError):
    """The distortion model is unknown, or the target format cannot hold it."""


class DegenerateLinesError(PlumblineError):
    """The lines cannot determine the coefficients asked for.

    Attributes:
        suspects: Picks that a robust fit finds wrong, as `Calibration.suspects`; empty where
            there is none.
    """

    def __init__(self, message: str, *, hint: str = "", suspects: tuple[Any, ...] = ()) -> None:
        super().__init__(message, hint=hint)
        self.suspects = suspects


class CollapsedFitError(DegenerateLinesError):
    """The fit reached a small residual by shrinking or folding the photo."""


class PairError(PlumblineError):
    """Two pictures, or matched points, that are not an original and its correction."""


class UnsettledError(PlumblineError):
    """A fit that did not reach a minimum has no result that other programs could use."""


class FoldedError(PlumblineError):
    """The distortion folds over: some points have no counterpart on the other side."""

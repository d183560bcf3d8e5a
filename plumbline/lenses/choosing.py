"""Choose one of several matching lenses, or ask which."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from plumbline.errors import OptionError, printable
from plumbline.wording import listed

_FAR = 0.1
"""As `clamp_focal` allows outside the calibrated range, relatively."""


@dataclass(frozen=True)
class LensMatch:
    """A lens that may be meant.

    Attributes:
        name: Its name, as `--lens-name` takes it.
        range_mm: Shortest and longest calibrated focal length; None if not calibrated.
        attached: Whether it is a variant: a converter is attached, or it is for close distances.
        score: How well its name matches; larger is better.
    """

    name: str
    range_mm: tuple[float, float] | None
    attached: bool = False
    score: int = 0

    def __str__(self) -> str:
        if self.range_mm is None:
            return f"{printable(self.name)} (distortion not calibrated)"
        low, high = self.range_mm
        span = f"{low:g} mm" if low == high else f"{low:g}–{high:g} mm"
        return f"{printable(self.name)} ({span})"

    def covers(self, focal_mm: float | None) -> bool:
        """Whether the lens is calibrated within 10 % of a focal length."""
        if self.range_mm is None:
            return False
        low, high = self.range_mm
        return focal_mm is None or low * (1 - _FAR) <= focal_mm <= high * (1 + _FAR)


def choose(
    candidates: Sequence[LensMatch], named: str | None, focal_mm: float | None, where: str
) -> tuple[int, str]:
    """The number of the lens that is meant, and a note if others were left aside.

    A lens named word for word wins; those with a converter attached go unless the name is
    theirs, then those without distortion or out of the focal length.

    Raises:
        OptionError: none or several are left.
    """
    if not candidates:
        raise OptionError(f"{where} has no lens for this photo", hint="name another with --lens")
    exact = [i for i, each in enumerate(candidates) if named and _same(each.name, named)] or range(
        len(candidates)
    )
    meant = _meant(candidates, exact, named)
    left = [i for i in meant if candidates[i].covers(focal_mm)]
    if not left:
        if len(meant) == 1 and candidates[meant[0]].range_mm is not None:
            return meant[0], ""  # the focal length is refused with its own sentence
        raise OptionError(_none_fits(candidates, focal_mm, where), hint=_calibrate(candidates))
    converters = [
        str(candidates[i]) for i in exact if i not in meant and candidates[i].covers(focal_mm)
    ]
    note = ""
    if converters:
        note = f"variants (converter, macro) were left aside: {listed(converters, 4)} (--lens-name)"
    best = [i for i in left if candidates[i].score == max(candidates[j].score for j in left)]
    if len(best) > 1 or (not named and len(left) > 1):
        raise OptionError(
            f"several lenses of {where} match this photo: "
            + listed([str(candidates[i]) for i in left], 12),
            hint="say which with --lens-name, or name a file with --lens",
        )
    if len(left) > 1:
        aside = [str(candidates[i]) for i in left if i != best[0]]
        note = f"it matches best; others that match: {listed(aside, 4)} (--lens-name)"
    return best[0], note


def like_note(own: str, other: str) -> str:
    """What is said where another camera's lens is taken, as `--like` asks."""
    return f"{own or 'this camera'} is treated like the {other}, as --like asks"


def no_camera() -> OptionError:
    """The photo does not tell its camera, and the user does not either."""
    return OptionError(
        "the photo has no EXIF that names its camera",
        hint="give it with --camera (and --focal), or name a file of the lens with --lens",
    )


def _meant(
    candidates: Sequence[LensMatch], among: Sequence[int], named: str | None
) -> Sequence[int]:
    """Those without a converter, unless the name matches one with a converter better."""
    plain = [i for i in among if not candidates[i].attached]
    if not named:
        return plain
    best = max(candidates[i].score for i in among)
    return plain if any(candidates[i].score == best for i in plain) else among


def _same(name: str, other: str) -> bool:
    return name.casefold().split() == other.casefold().split()


def _none_fits(candidates: Sequence[LensMatch], focal_mm: float | None, where: str) -> str:
    names = listed([str(each) for each in candidates], 8)
    at = f" at {focal_mm:.4g} mm" if focal_mm else ""
    return f"no matching lens of {where} is calibrated for distortion{at}: {names}"


def _calibrate(candidates: Sequence[LensMatch]) -> str:
    if all(each.range_mm is None for each in candidates):
        return "calibrate the lens with plumbline fit, and name the result with --lens"
    if all(each.attached for each in candidates):
        return "if a converter was attached, name it with --lens-name"
    return "give the right focal length with --focal, or calibrate the lens at this one"

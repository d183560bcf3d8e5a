"""What an adjustment says of itself: fit, checks, doubts and advice."""

from __future__ import annotations

from dataclasses import dataclass

AGREES, DOUBTFUL = 2.0, 3.0
"""Standard errors up to which two focal lengths agree, and from which they contradict; chosen."""


@dataclass(frozen=True)
class Advice:
    """A further observation.

    Attributes:
        what: What to do, in words.
        place_m: Where the error is looked at.
        now_m: Standard error there as things are, but for the pick's own.
        then_m: The same with the observation.
    """

    what: str
    place_m: tuple[float, float]
    now_m: float
    then_m: float


@dataclass(frozen=True)
class ImpliedCamera:
    """The camera by the ground alone, without the focal length that was told.

    Attributes:
        focal_px: Focal length, ideal pixels.
        focal_error_px: Its standard error.
        height_m: Height over the plane.
        height_error_m: Its standard error.
        pitch_deg: How far it looks up; negative is down.
        pitch_error_deg: Its standard error.
        told_px: The focal length that EXIF or the user told, ideal pixels; None without.
        away: Difference of the two focal lengths in its own standard errors.
        verdict: In one sentence.
    """

    focal_px: float
    focal_error_px: float
    height_m: float
    height_error_m: float
    pitch_deg: float
    pitch_error_deg: float
    told_px: float | None
    away: float | None
    verdict: str

    @property
    def agrees(self) -> bool:
        """Whether the focal lengths do not contradict each other."""
        return self.away is None or self.away < DOUBTFUL


@dataclass(frozen=True)
class Doubtful:
    """An observation that contradicts the others.

    Attributes:
        what: "point A" or "tape A-B".
        off: By how much it is off, in words.
    """

    what: str
    off: str


@dataclass(frozen=True)
class PointFit:
    """How one point fits.

    Attributes:
        name: The point.
        pick_px: Pick minus where the adjusted point is seen, x and y.
        place_m: Given minus adjusted place, X and Y; None where no place was given.
        error_m: Half axes of the 95 % ellipse of the adjusted place, long and short, metres.
    """

    name: str
    pick_px: tuple[float, float]
    place_m: tuple[float, float] | None
    error_m: tuple[float, float]


@dataclass(frozen=True)
class TapeFit:
    """How one tape fits: measured and adjusted length, metres, and its stated error."""

    first: str
    second: str
    metres: float
    adjusted_m: float
    sigma_m: float


@dataclass(frozen=True)
class Setting:
    """A stated standard error or assumption, for people: what it is, and its value in words."""

    what: str
    value: str


@dataclass(frozen=True)
class InputFile:
    """A file that was read: its name and the SHA-256 of its bytes."""

    name: str
    sha256: str


@dataclass(frozen=True)
class Findings:
    """What there is to say of a rectification.

    Attributes:
        lens: The lens that was used, in one sentence.
        redundancy: Observations beyond what the unknowns need.
        cost: Sum of the squared residuals over their standard errors.
        contradictory: Whether the observations disagree more than their errors allow.
        points: How each point fits.
        tapes: How each tape fits.
        implied: The camera by the ground alone.
        refined: Coefficients that were adjusted, name, value and standard error.
        suspects: Observations that contradict the others.
        advice: What would help most.
        settings: The standard errors and assumptions that were used.
        inputs: The files.
        notes: What the user should know.
    """

    lens: str = ""
    redundancy: int = 0
    cost: float = 0.0
    contradictory: bool = False
    points: tuple[PointFit, ...] = ()
    tapes: tuple[TapeFit, ...] = ()
    implied: ImpliedCamera | None = None
    refined: tuple[tuple[str, float, float], ...] = ()
    suspects: tuple[Doubtful, ...] = ()
    advice: tuple[Advice, ...] = ()
    settings: tuple[Setting, ...] = ()
    inputs: tuple[InputFile, ...] = ()
    notes: tuple[str, ...] = ()

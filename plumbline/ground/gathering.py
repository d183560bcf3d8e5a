"""From what the user names to a network: files read, lens found, standard errors filled in."""

from __future__ import annotations

from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path

import numpy as np

from plumbline.errors import OptionError
from plumbline.files import read_bytes
from plumbline.formats.base import Source
from plumbline.frame import Array, Frame
from plumbline.ground.adjusting.network import (
    SIGMA_CENTRE,
    SIGMA_SQUARE_RAD,
    Focal,
    Network,
    RightAngle,
)
from plumbline.ground.findings import InputFile, Setting
from plumbline.ground.optics import Optics
from plumbline.ground.reading.lines import Lines, parallel_column, sorted_lines
from plumbline.ground.reading.matches import Matches, read_matches
from plumbline.ground.reading.tapes import read_tapes
from plumbline.ground.request import GroundRequest
from plumbline.ground.world_file import read_world
from plumbline.lenses.lookup import LensSource, profile_for
from plumbline.lenses.profile import LensProfile, laid_over
from plumbline.lenses.request import LensRequest
from plumbline.models import CENTRE
from plumbline.photos.exif import PhotoFacts
from plumbline.reading.points import read
from plumbline.wording import listed

_HELD = 1e-6
"""Relative standard error of a focal length that is held; chosen, far below any effect."""

_SQUARE_FOCAL, _SQUARE_SIGMA = 1.0, 0.7
"""Focal length over the photo's diagonal, and its relative error, where a square-on photo tells
none: chosen, a factor of two to either side."""


@dataclass(frozen=True)
class Gathered:
    """A network with its lens, and where it all came from.

    Attributes:
        network: What was observed.
        optics: The lens over the photo.
        lens: The lens in one sentence.
        settings: Standard errors and assumptions, for people.
        inputs: The files.
        notes: What the user should know.
    """

    network: Network
    optics: Optics
    lens: str
    settings: tuple[Setting, ...]
    inputs: tuple[InputFile, ...]
    notes: tuple[str, ...]


def gather(photo: PhotoFacts, lens: LensSource, request: GroundRequest) -> Gathered:
    """Read all files that a request names, and find the photo's lens.

    Raises:
        PlumblineError: a file is damaged, a name unknown, or no lens is found.
    """
    profile, lens_request = profile_for(photo, lens)
    laid, notes = laid_over(profile, photo, lens_request)
    optics = Optics(laid)
    matches = read_matches(request.points)
    _refuse_outside(matches, laid.frame)
    tapes = ()
    if request.tapes is not None:
        tapes = read_tapes(request.tapes, matches.names, request.sigma_tape_m)
    lines = _lines(request, laid.frame)
    refined, freed = _refined(request, optics)
    sigma_centre = SIGMA_CENTRE * laid.frame.radius_px
    if request.sigma_centre_px is not None:
        sigma_centre = request.sigma_centre_px
    focal, told = _focal(photo, profile, lens_request, optics, request)
    given = np.isfinite(matches.sigmas)
    network = Network(
        matches.names,
        matches.picks_px,
        _places(matches, request),
        np.where(given, matches.sigmas, request.sigma_ground_m),
        request.sigma_pick_px,
        request.flatness_m,
        request.sigma_ground_m,
        tapes,
        _right_angles(request, matches),
        lines.ground,
        lines.straight if refined else (),
        lines.horizon_px,
        focal,
        np.inf if freed else sigma_centre,
        SIGMA_SQUARE_RAD if request.square_on else None,
        refined,
        profile.covariance,
    )
    notes = (*notes, *matches.notes, *_line_notes(lines, refined))
    settings = _settings(network, told, sigma_centre, freed=freed)
    return Gathered(network, optics, profile.description, settings, _inputs(request), notes)


def _refuse_outside(matches: Matches, frame: Frame) -> None:
    outside = np.flatnonzero(~frame.contains(matches.picks_px))
    if len(outside):
        first = int(outside[0])
        x, y = matches.picks_px[first]
        raise OptionError(
            f"{matches.path}, row {matches.rows[first]}: {matches.names[first]} at {x:g}, {y:g} "
            f"lies outside of the photo of {frame.width}x{frame.height} pixels",
            hint="give x and y in pixels of this photo as a viewer shows it",
        )


def _places(matches: Matches, request: GroundRequest) -> Array:
    if request.aerial is None:
        return matches.places
    return read_world(request.aerial).places(matches.places)


def _lines(request: GroundRequest, frame: Frame) -> Lines:
    if request.lines is None:
        if request.parallel or request.horizon:
            raise OptionError(
                "parallel lines and the horizon are lines of a file", hint="give it with --lines"
            )
        return Lines((), (), np.empty((0, 2)))
    source = Source(request.lines, read_bytes(request.lines))
    observations = read(request.lines, size=frame.size, pixel_aspect=frame.pixel_aspect)
    if len({line.photo for line in observations.lines}) > 1:
        raise OptionError(
            f"{request.lines} has lines of several photos", hint="give those of this photo alone"
        )
    column = parallel_column(source) if observations.origins[0].format == "csv" else {}
    return sorted_lines(observations, column, request.parallel, request.horizon)


def _line_notes(lines: Lines, refined: tuple[str, ...]) -> list[str]:
    if lines.straight and not refined:
        return [
            f"{len(lines.straight)} straight lines that are in no parallel set say nothing about "
            "the ground, and about the lens only with --refine: they were not used"
        ]
    return []


def _refined(request: GroundRequest, optics: Optics) -> tuple[tuple[str, ...], bool]:
    """The coefficients to adjust, and whether the centre is freed."""
    known = (*optics.names, *CENTRE)
    wrong = [name for name in request.refine if name not in known]
    if wrong:
        raise OptionError(
            f"{listed(wrong)} is not a coefficient of this lens, whose model is "
            f"{optics.lens.model.label}",
            hint=f"it has {', '.join(known)}",
        )
    centre = [name for name in request.refine if name in CENTRE]
    if len(centre) == 1:
        raise OptionError("d and e are refined together", hint="give --refine d,e")
    return tuple(name for name in optics.names if name in request.refine), bool(centre)


def _right_angles(request: GroundRequest, matches: Matches) -> tuple[RightAngle, ...]:
    angles: list[RightAngle] = []
    for names in request.right_angles:
        for name in names:
            if name not in matches.names:
                raise OptionError(
                    f"no point is named {name}", hint=f"there are {listed(list(matches.names))}"
                )
        if len(set(names)) < 3:
            raise OptionError(
                "a right angle needs three different points", hint="as A,B,C with the corner at B"
            )
        first, corner, last = (matches.names.index(name) for name in names)
        angles.append(RightAngle(first, corner, last))
    return tuple(angles)


def _focal(
    photo: PhotoFacts,
    profile: LensProfile,
    asked: LensRequest,
    optics: Optics,
    request: GroundRequest,
) -> tuple[Focal | None, str]:
    """The focal length that is told, in ideal pixels, and by whom."""
    facts = photo.facts
    sigma, by = request.sigma_focal, "given"
    observed = request.focal_px
    if observed is None:
        crop = asked.crop_factor or facts.crop_factor or profile.photo_crop
        told = replace(facts, focal_mm=asked.focal_mm or facts.focal_mm, crop_factor=crop)
        observed = told.focal_length_px(optics.lens.frame)
        sigma, by = float(np.hypot(sigma, facts.crop_factor_error or 0.0)), "by EXIF"
    if observed is None:
        if not request.square_on:
            return None, "not known"
        diagonal = float(np.hypot(*optics.lens.frame.square_size))
        return Focal(_SQUARE_FOCAL * diagonal, _SQUARE_SIGMA), "assumed, to a factor of two"
    return Focal(observed / optics.paraxial_scale, max(sigma, _HELD)), by


def _settings(
    network: Network, told: str, sigma_centre: float, *, freed: bool
) -> tuple[Setting, ...]:
    focal = "not known"
    if network.focal is not None:
        error = 100 * network.focal.sigma
        focal = f"{network.focal.px:.0f} px ± {error:.2g} %, {told}"
    settings = [
        Setting("a pick", f"± {network.sigma_pick_px:g} px in x and in y"),
        Setting("unevenness of the plane", f"± {network.flatness_m:g} m"),
        Setting("focal length", focal),
        Setting("centre of the lens", "free" if freed else f"± {sigma_centre:.1f} px"),
    ]
    if len(network.known):
        sigmas = network.sigma_places_m[network.known]
        low, high = float(sigmas.min()), float(sigmas.max())
        shown = f"{low:g} m" if low == high else f"{low:g} to {high:g} m"
        settings.append(Setting("a coordinate on the ground", f"± {shown}"))
    if network.tapes:
        low, high = (f([t.sigma_m for t in network.tapes]) for f in (min, max))
        shown = f"{low:g} m" if low == high else f"{low:g} to {high:g} m"
        settings.append(Setting("a tape", f"± {shown}"))
    if network.lines:
        settings.append(Setting("a point of a line, sideways", f"± {network.sigma_line_m:g} m"))
    if network.sigma_square_rad is not None:
        angle = float(np.degrees(network.sigma_square_rad))
        settings.append(Setting("the camera held square to the plane", f"± {angle:.1f}°"))
    return tuple(settings)


def _inputs(request: GroundRequest) -> tuple[InputFile, ...]:
    paths = (request.points, request.tapes, request.lines)
    return tuple(
        InputFile(Path(path).name, sha256(read_bytes(path)).hexdigest()) for path in paths if path
    )

"""Rectify a photo of a plane: gather, adjust, check, and say how sure it is."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from plumbline.errors import OptionError
from plumbline.ground.adjusting.adjustment import Adjustment, adjust
from plumbline.ground.ellipses import ellipse
from plumbline.ground.findings import Findings, PointFit, TapeFit
from plumbline.ground.gathering import Gathered, gather
from plumbline.ground.judging.advice import advise
from plumbline.ground.judging.degeneracy import refuse_too_few, refuse_undetermined
from plumbline.ground.judging.implied import implied_camera
from plumbline.ground.judging.order import refuse_beyond_fold, refuse_disorder, refuse_one_line
from plumbline.ground.judging.refining import refuse_unrefined
from plumbline.ground.judging.suspects import find_suspects
from plumbline.ground.outcome import rectification_of
from plumbline.ground.rectification import Rectification
from plumbline.ground.request import GroundRequest
from plumbline.lenses.lookup import LensSource
from plumbline.photos.exif import read_photo

_EXACT = 4
"""Points with places that any camera fits."""


def rectify(
    photo: str | Path, points: str | Path, lens: LensSource = None, **request: Any
) -> Rectification:
    """Rectify a photograph of a plane to scale.

    Args:
        photo: The photograph; its size, and by EXIF its lens and focal length, are read.
        points: File of match points, see `ground.reading.matches`.
        lens: A calibration, a lens, a file that holds one, or what is known of it; by default
            it is looked up by the photo's EXIF.
        **request: The other fields of `GroundRequest`: tapes, lines, parallel, right_angles,
            horizon, aerial, sigma_pick_px, sigma_ground_m, sigma_tape_m, flatness_m, focal_px,
            sigma_focal, sigma_centre_px, refine, square_on.

    Returns:
        The camera over the plane: `to_ground`, `to_photo`, `covariances`, `measure`.

    Raises:
        PlumblineError: a file is damaged, no lens is found, the observations do not determine
            the plane, or they contradict each other by an exchange.

    Example:
        >>> import plumbline
        >>> road = plumbline.rectify("road.jpg", "points.csv", "lens.json")  # doctest: +SKIP
        >>> road.measure("distance", ["A", "B"]).values  # doctest: +SKIP
        (3.5021,)
    """
    asked = GroundRequest(str(points), **request)
    return rectified(gather(read_photo(photo), lens, asked))


def rectified(gathered: Gathered) -> Rectification:
    """Adjust what was gathered, with all checks before and after; raises as `rectify`."""
    network, optics = gathered.network, gathered.optics
    refuse_too_few(network)
    ideal = refuse_beyond_fold(network, optics)
    refuse_one_line(network, ideal)
    refuse_disorder(network, ideal)
    found = adjust(network, optics)
    refuse_undetermined(found)
    refuse_unrefined(found, centre=not np.isfinite(network.sigma_centre_px))
    if not found.converged:
        raise OptionError(
            "the adjustment does not settle", hint="check the picks, places, tapes and their units"
        )
    result = rectification_of(found)
    return replace(result, findings=_findings(found, result, gathered))


def _findings(found: Adjustment, result: Rectification, gathered: Gathered) -> Findings:
    suspects = find_suspects(found)
    implied = implied_camera(found.network, gathered.optics)
    notes = [*gathered.notes, *_notes(found)]
    return Findings(
        gathered.lens,
        found.redundancy,
        found.cost,
        found.contradictory,
        tuple(_point_fits(found, result)),
        tuple(_tape_fits(found)),
        implied,
        tuple(_refined(found)),
        tuple(suspects),
        tuple(advise(found)),
        gathered.settings,
        gathered.inputs,
        tuple(notes),
    )


def _notes(found: Adjustment) -> list[str]:
    notes: list[str] = []
    network = found.network
    only_points = not (network.tapes or network.lines or network.right_angles)
    if len(network.known) == _EXACT and only_points and not len(network.horizon_px):
        notes.append(
            "any four points fit some camera, so only the focal length checks them: it shows "
            "blunders of more than about 0.1 to 0.8 m; a fifth point shows smaller ones"
        )
    if found.contradictory:
        notes.append(
            "the observations contradict each other more than their stated errors allow: all "
            f"standard errors were widened by {found.widening:.1f}"
        )
    if network.sigma_square_rad is not None:
        notes.append("the plane was taken as photographed square-on")
    if network.lines and network.refined:
        notes.append("lane edges along the view run radially and say nothing about the lens")
    return notes


def _point_fits(found: Adjustment, result: Rectification) -> list[PointFit]:
    network = found.network
    seen = found.state.camera.project(found.state.places)
    _, joint = result.joint(network.names, {})
    fits: list[PointFit] = []
    for index, name in enumerate(network.names):
        pick = network.picks_px[index] - seen[index]
        given = network.places_m[index]
        away = given - found.state.places[index, :2]
        block = joint[2 * index : 2 * index + 2, 2 * index : 2 * index + 2]
        place = (float(away[0]), float(away[1])) if np.isfinite(given).all() else None
        long, short, _ = ellipse(block)
        fits.append(PointFit(name, (float(pick[0]), float(pick[1])), place, (long, short)))
    return fits


def _tape_fits(found: Adjustment) -> list[TapeFit]:
    network, places = found.network, found.state.places[:, :2]
    return [
        TapeFit(
            network.names[tape.first],
            network.names[tape.second],
            tape.metres,
            float(np.hypot(*(places[tape.second] - places[tape.first]))),
            tape.sigma_m,
        )
        for tape in network.tapes
    ]


def _refined(found: Adjustment) -> list[tuple[str, float, float]]:
    optics, layout = found.state.camera.optics, found.layout
    spread = np.sqrt(np.diag(found.cofactor)) * found.widening
    coefficients = [
        (name, float(optics.lens.coefficients[index]), float(spread[layout.lens.start + at]))
        for at, (name, index) in enumerate(zip(found.network.refined, layout.refined, strict=True))
    ]
    if not np.isfinite(found.network.sigma_centre_px):
        coefficients += [
            (name, value, float(spread[7 + at]))
            for at, (name, value) in enumerate(zip("de", optics.shift_px, strict=True))
        ]
    return coefficients

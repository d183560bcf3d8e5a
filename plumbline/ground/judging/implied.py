"""The camera that the ground alone implies, judged against what EXIF says of it.

With four points nothing else can be checked: any four points fit some camera. A wrong one shows
by a camera that nobody has.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from plumbline.errors import PlumblineError
from plumbline.ground.adjusting.adjustment import Adjustment, adjust
from plumbline.ground.adjusting.network import Focal, Network
from plumbline.ground.camera import FOCAL, HEIGHT, TURN
from plumbline.ground.findings import AGREES, DOUBTFUL, ImpliedCamera
from plumbline.ground.optics import Optics

_UNTOLD = 0.5
"""Relative standard error from which the ground tells no focal length; chosen."""


def implied_camera(network: Network, optics: Optics) -> ImpliedCamera | None:
    """The camera without any focal length told; None where the ground tells none."""
    if network.sigma_square_rad is not None:
        return None
    try:
        found = adjust(replace(network, focal=None), optics)
    except PlumblineError:
        return None
    if len(found.undetermined):
        return None
    spread = np.sqrt(np.diag(found.cofactor)) * found.widening
    if spread[FOCAL] > _UNTOLD or spread[HEIGHT] > _UNTOLD:
        return None
    camera = found.state.camera
    away = _away(camera.focal_px, float(spread[FOCAL]), network.focal)
    return ImpliedCamera(
        camera.focal_px,
        float(camera.focal_px * spread[FOCAL]),
        camera.height_m,
        float(camera.height_m * spread[HEIGHT]),
        camera.pitch_deg,
        pitch_error_deg(found),
        None if network.focal is None else network.focal.px,
        away,
        _verdict(away, network),
    )


def pitch_error_deg(found: Adjustment) -> float:
    """Standard error of the camera's pitch."""
    up = found.state.camera.rotation[:, 2]
    by_turn = np.array([-up[1], up[0], 0.0]) / max(float(np.hypot(up[0], up[1])), 1e-9)
    sure = by_turn @ found.cofactor[TURN, TURN] @ by_turn
    return float(np.degrees(np.sqrt(max(sure, 0.0)))) * found.widening


def _away(focal_px: float, error: float, told: Focal | None) -> float | None:
    if told is None:
        return None
    return abs(float(np.log(focal_px / told.px))) / float(np.hypot(error, told.sigma))


def _verdict(away: float | None, network: Network) -> str:
    if away is None or network.focal is None:
        return "no focal length was given, so that the points cannot be checked against it"
    told = f"{network.focal.px:.0f} px"
    if away <= AGREES:
        return f"it agrees with the {told} that were given ({away:.1f} standard errors apart)"
    if away < DOUBTFUL:
        return (
            f"it barely agrees with the {told} that were given ({away:.1f} standard errors apart)"
        )
    return (
        f"it contradicts the {told} that were given ({away:.1f} standard errors apart): a point, a "
        "tape or the focal length is wrong"
    )

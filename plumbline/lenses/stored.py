"""A lens as a file holds it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from plumbline.frame import Array
from plumbline.geometry.lens import Lens
from plumbline.observations import Observations
from plumbline.observations.facts import LensFacts
from plumbline.result.calibration import Calibration
from plumbline.result.given import refuse_unsettled


@dataclass(frozen=True)
class StoredLens:
    """A lens as a file holds it.

    Attributes:
        lens: The lens, for pictures of its frame.
        facts: What the file says of it.
        photos: Names of the photos it belongs to.
        notes: What to warn of.
        observations: The points it was fitted to; None where there are none.
        homography: Where it was refitted, from plumbline's ideal points to those of `lens`,
            both in half shorter sides from the image centre, shape (3, 3); None if not.
        covariance: Of the model's coefficients in its order, shape (k, k); None if unknown.
    """

    lens: Lens
    facts: LensFacts
    photos: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    observations: Observations | None = None
    homography: Array | None = field(default=None, compare=False)
    covariance: Array | None = field(default=None, compare=False)


def of_calibration(calibration: Calibration) -> StoredLens:
    """The lens of a calibration.

    Raises:
        UnsettledError: its fit did not reach a minimum.
    """
    refuse_unsettled([calibration])
    names = tuple(photo.name for photo in calibration.observations.photos if photo.name)
    facts = calibration.observations.lenses[0]
    return StoredLens(
        calibration.lens,
        facts,
        names,
        observations=calibration.observations,
        covariance=_covariance(calibration),
    )


def _covariance(calibration: Calibration) -> Array:
    """Covariance of all of the model's coefficients, zero where one was held."""
    names = calibration.lens.model.coefficients
    whole = np.zeros((len(names), len(names)))
    free = [index for index, name in enumerate(calibration.free) if name in names]
    into = [names.index(calibration.free[index]) for index in free]
    whole[np.ix_(into, into)] = calibration.covariance[np.ix_(free, free)]
    return whole


def projection_note(projection: str) -> tuple[str, ...]:
    """A warning where a lens has another projection than straight lines need."""
    if projection == "rectilinear":
        return ()
    return (
        f"the lens is not rectilinear ({projection}): its distortion is corrected, its "
        "projection stays, so straight lines stay curved",
    )

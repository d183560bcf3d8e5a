"""A lens as a file holds it."""

from __future__ import annotations

from dataclasses import dataclass

from plumbline.calibration import Calibration
from plumbline.facts import LensFacts
from plumbline.lens import Lens
from plumbline.observations import Observations


@dataclass(frozen=True)
class StoredLens:
    """A lens as a file holds it.

    Attributes:
        lens: The lens, for pictures of its frame.
        facts: What the file says of it.
        photos: Names of the photos it belongs to.
        notes: What to warn of.
        observations: The points it was fitted to; None where there are none.
    """

    lens: Lens
    facts: LensFacts
    photos: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    observations: Observations | None = None


def of_calibration(made: Calibration) -> StoredLens:
    """The lens of a calibration."""
    names = tuple(photo.name for photo in made.observations.photos if photo.name)
    notes = () if made.converged else ("its fit did not end in a minimum",)
    facts = made.observations.lenses[0]
    return StoredLens(made.lens, facts, names, notes=notes, observations=made.observations)


def projection_note(projection: str) -> tuple[str, ...]:
    """A warning where a lens has another projection than straight lines need."""
    if projection == "rectilinear":
        return ()
    return (
        f"the lens is no rectilinear one ({projection}): its distortion is corrected, its "
        "projection stays, so straight lines stay curved",
    )

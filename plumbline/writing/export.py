"""A lens in the words of other programs.

Most hold the a, b, c polynomial of Panorama Tools alone; a lens of another model is refitted
over the photo, and how far the two differ comes with the result.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from plumbline.files import sealed
from plumbline.frame import Frame
from plumbline.geometry.lens import Lens
from plumbline.lenses.stored import StoredLens
from plumbline.models import get_model
from plumbline.writing.refit import refit
from plumbline.writing.targets import TARGETS


@dataclass(frozen=True)
class Exported:
    """An exported lens.

    Attributes:
        content: The file.
        deviation_px: How far the refitted lens differs over the photo; None if not refitted.
        model: The model it was refitted to.
        notes: What to be aware of, in plain sentences.
    """

    content: bytes
    deviation_px: float | None
    model: str
    notes: tuple[str, ...]


def export(stored: StoredLens, name: str) -> Exported:
    """A lens as another program reads it.

    Args:
        stored: The lens.
        name: A row of `TARGETS`.

    Raises:
        OptionError: the target needs a focal length or a crop factor that is not known.
        FoldedError: the lens folds inside the photo, so that it cannot be refitted.
    """
    target = TARGETS[name]
    notes = list(stored.notes)
    square = _squared(stored, notes)
    lens = square.lens
    centred = not any(lens.coefficients[each] for each in ("d", "e"))
    if lens.model.name in target.models and (target.centre or centred):
        content = sealed(target.write(square))
        return Exported(content, None, lens.model.label, (*notes, *_notes(square, name)))
    focal_px = square.facts.focal_length_px(lens.frame) or lens.focal_px
    model = get_model(target.models[0])
    if model.unit == "focal length":
        focal_px = focal_px or float(max(lens.frame.size))
    # Decentring terms are, but for a perspective, a shift of the centre.
    shifted = not centred or any(lens.coefficients[each] for each in lens.model.tangential)
    found = refit(lens, model, centre=target.centre and shifted, focal_px=focal_px)
    if not target.centre and not centred:
        notes.append(f"{name} holds no distortion centre: the lens was refitted without")
    rewritten = replace(square, lens=found.lens, homography=found.homography)
    notes += _notes(rewritten, name)
    return Exported(sealed(target.write(rewritten)), found.deviation_px, model.label, tuple(notes))


def _squared(stored: StoredLens, notes: list[str]) -> StoredLens:
    """The lens of the photo resampled to square pixels."""
    lens = stored.lens
    if lens.frame.pixel_aspect == 1:
        return stored
    width = round(lens.frame.square_size[0])
    shift = {"d": lens.coefficients["d"] * width / lens.frame.width}
    notes.append(f"the lens is written for the photo at square pixels, {width}x{lens.frame.height}")
    frame = Frame(width, lens.frame.height)
    return replace(
        stored,
        lens=Lens(lens.model, frame, {**lens.coefficients, **shift}, lens.focal_px),
        observations=stored.observations.squared() if stored.observations else None,
    )


def _notes(stored: StoredLens, name: str) -> list[str]:
    notes: list[str] = []
    if name == "opencv":
        notes.append(
            "cv2.initUndistortRectifyMap makes plumbline's own picture with new_camera_matrix of "
            "the file; with camera_matrix in its place the picture is scaled and shifted"
        )
    if name == "opencv" and not stored.facts.focal_length_px(stored.lens.frame):
        notes.append(
            "the focal length is not known: the camera matrix has a stand-in, which straightens "
            "lines all the same"
        )
    if name == "lensfun" and stored.lens.model.name == "acm":
        notes.append("acm needs LensFun 0.4; released versions (0.3) refuse the file")
    return notes

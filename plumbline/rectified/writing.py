"""A rectification as files: the picture to scale, its world file, and the rectification itself."""

from __future__ import annotations

from hashlib import sha256
from pathlib import Path

from plumbline.files import as_path, read_bytes, refuse_to_clobber, write_atomically
from plumbline.ground.rectification import Rectification
from plumbline.ground.stored import StoredRectification, rectification_json
from plumbline.imaging.targets import check_target
from plumbline.rectified.georeference import world_file_name
from plumbline.rectified.picture import PictureRequest, picture_files, rectify_picture


def description_of(found: Rectification) -> str:
    """What a rectified picture says of itself."""
    return f"rectified from {found.camera.height_m:.2f} m over the plane"


def stored_bytes(found: Rectification, photo: Path, command: str = "") -> bytes:
    """The JSON of a rectification, which `read_rectification` takes back.

    Args:
        found: The rectification.
        photo: Its photograph, whose name and checksum are kept.
        command: The command that made it.
    """
    digest = sha256(read_bytes(photo)).hexdigest()
    return rectification_json(StoredRectification(found, photo.name, digest, command))


def write_rectified(
    found: Rectification,
    photo: str | Path,
    path: str | Path,
    request: PictureRequest | None = None,
    *,
    overwrite: bool = False,
) -> tuple[list[Path], list[str]]:
    """Write a photograph rectified to scale, with its world file and the rectification as JSON.

    Args:
        found: What `rectify` gave.
        photo: The photograph it was given.
        path: The picture to write, `.png`, `.jpg`, `.tif` or `.webp`; the others go beside it.
        request: Resolution, extent and so on; 1 cm a pixel over the points by default.
        overwrite: Replace files that plumbline did not write.

    Returns:
        The files written, and notes in plain sentences on what was cut or could not be kept.

    Raises:
        WriteError: a file exists and is not plumbline's, or cannot be written; then none is.
        OptionError: the photo is another one, or shows nothing of the extent.
        ReadError: the photo cannot be read.

    Example:
        >>> road = plumbline.rectify("road.jpg", "points.csv")  # doctest: +SKIP
        >>> plumbline.write_rectified(road, "road.jpg", "road_rectified.png")  # doctest: +SKIP
    """
    source, target, wanted = as_path(photo), as_path(path), request or PictureRequest()
    saved = target.with_suffix(".json")
    check_target(target, source, overwrite=overwrite)
    refuse_to_clobber(saved, [str(source)], overwrite=overwrite)
    world = world_file_name(target)
    refuse_to_clobber(world, [str(source)], overwrite=overwrite or target.exists())
    picture = rectify_picture(found, source, target, wanted)
    files, lost = picture_files(picture, target, wanted, description_of(found))
    files[saved] = stored_bytes(found, source)
    write_atomically(files)
    return list(files), [*picture.notes, *picture.picture.notes, *lost]

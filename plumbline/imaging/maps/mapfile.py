"""The sampling map as a file, for programs that move the pixels themselves.

`.tif`: an ST map as compositing programs have it: 32-bit floats, red the observed x as a share
of the width, green the observed y as a share of the height from the bottom, both counted from
the picture's edge; blue is 0. `.npz`: `observed_px`, shape (rows, columns, 2), in pixels with
(0, 0) the centre of the top-left pixel; NaN where the photograph shows nothing. Both end in
plumbline's mark: TIFF's Software, and the comment of the zip file that an `.npz` is.
"""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import cv2
import numpy as np

from plumbline._version import __version__
from plumbline.errors import OptionError
from plumbline.files import MARK
from plumbline.imaging.maps.sampling import fold_notes, sampling_of
from plumbline.imaging.maps.sampling_map import NOWHERE, SamplingMap
from plumbline.imaging.maps.view import Scale
from plumbline.lenses.correction import Correction
from plumbline.photos.files.metadata import Metadata

SUFFIXES = (".tif", ".tiff", ".npz")


def map_bytes(
    correction: Correction, target: str | Path, *, scale: Scale = "keep", inverse: bool = False
) -> tuple[bytes, tuple[str, ...]]:
    """The file that holds the map of the upright picture, ideal pixels to observed ones.

    Args:
        correction: The lens.
        target: The file it is for, whose suffix says in which form.
        scale: As for `correct`.
        inverse: The map of observed pixels to ideal ones.

    Returns:
        The file, and what the user should know, in plain sentences.

    Raises:
        OptionError: the suffix stands for no map, or the lens folds.
    """
    suffix = Path(target).suffix.lower()
    if suffix not in SUFFIXES:
        raise OptionError(
            f"a map cannot be written as {suffix or 'a file without suffix'}",
            hint=f"use one of {', '.join(SUFFIXES)}",
        )
    sampling = sampling_of(correction, scale=scale, inverse=inverse)
    content = _npz(sampling) if suffix == ".npz" else _stmap(sampling)
    return content, fold_notes(sampling)


def _npz(sampling: SamplingMap) -> bytes:
    width, height = sampling.size
    observed = np.empty((height, width, 2), dtype=np.float32)
    for tile in sampling.tiles():
        observed[tile] = np.stack(sampling.coordinates(tile), axis=-1)
    observed[observed[..., 0] == NOWHERE] = np.nan
    buffer = io.BytesIO()
    np.savez_compressed(buffer, observed_px=observed)
    with zipfile.ZipFile(buffer, "a") as file:
        file.comment = f"{MARK} {__version__}".encode()
    return buffer.getvalue()


def _stmap(sampling: SamplingMap) -> bytes:
    width, height = sampling.size
    stmap = np.zeros((height, width, 3), dtype=np.float32)
    for tile in sampling.tiles():
        x, y = sampling.coordinates(tile)
        stmap[(*tile, 2)] = (x + 0.5) / width
        stmap[(*tile, 1)] = 1 - (y + 0.5) / height
    done, data = cv2.imencode(".tif", stmap)
    if not done:
        raise OptionError("the map is too large for a TIFF", hint="name a .npz with --map")
    from plumbline.photos.files.tiff_writing import with_metadata

    return with_metadata(data.tobytes(), Metadata(), f"{MARK} {__version__}")

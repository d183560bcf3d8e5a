"""`plumbline rectify` without its parsing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from plumbline.errors import OptionError, WriteError, printable
from plumbline.files import (
    refuse_to_clobber,
    refuse_unknown_suffix,
    write_atomically,
)
from plumbline.ground.gathering import gather
from plumbline.ground.measure import Measurement
from plumbline.ground.rectification import Rectification
from plumbline.ground.rectify import rectified
from plumbline.ground.request import GroundRequest
from plumbline.imaging.targets import beside, check_target
from plumbline.lenses.request import LensRequest
from plumbline.photos.exif import read_photo
from plumbline.photos.files.encode import format_of
from plumbline.rectified.compare import grid_like, mosaic, overlay_bytes
from plumbline.rectified.dxf import dxf_bytes
from plumbline.rectified.georeference import epsg_code, world_file_name
from plumbline.rectified.grid import Extent
from plumbline.rectified.picture import (
    PictureRequest,
    RectifiedPicture,
    Shown,
    picture_files,
    rectify_picture,
)
from plumbline.rectified.writing import description_of, stored_bytes
from plumbline.writing.beside import command_line

SUFFIX = "_rectified"


def run(photo: str, lens: LensRequest, how: Mapping[str, Any]) -> None:
    """Rectify a photo, write what is asked for, and print what was found."""
    source = Path(photo)
    picture = None if how["no_picture"] else _picture_target(source, how["output"])
    saved = Path(how["save"]) if how["save"] else _saved_target(source, picture)
    request = ground_request(how)
    wanted = _picture_request(how)
    inputs = [path for path in (photo, request.points, request.tapes, request.lines) if path]
    _refuse_targets(source, picture, saved, inputs, how)
    found = rectified(gather(read_photo(photo), lens, request))
    contents, notes = dict[Path, bytes](), list[str]()
    rectified_picture: RectifiedPicture | None = None
    if picture is not None:
        rectified_picture = rectify_picture(found, source, picture, wanted)
        files, lost = picture_files(rectified_picture, picture, wanted, description_of(found))
        contents |= files | _beside_others(rectified_picture, picture, wanted, found, how)
        notes += [*rectified_picture.notes, *rectified_picture.picture.notes, *lost]
    if how["dxf"]:
        frame = None if rectified_picture is None else rectified_picture.grid.corners_m
        contents[Path(how["dxf"])] = dxf_bytes(found, {}, tape_measurements(found), frame)
    contents[saved] = stored_bytes(found, source, command_line())
    write_atomically(contents)
    _tell(found, contents, notes, how)


def ground_request(how: Mapping[str, Any]) -> GroundRequest:
    """The request that the options stand for."""
    corners = how["right_angles"]
    for names in corners:
        if len(names) != 3:
            raise OptionError(
                f"--right-angle {','.join(names)} does not name three points", hint="as A,B,C"
            )
    return GroundRequest(
        how["points"],
        how["tapes"],
        how["lines"],
        how["parallel"],
        corners,
        how["horizon"],
        how["aerial"],
        how["sigma_pick"],
        how["sigma_ground"],
        how["sigma_tape"],
        how["flatness"],
        how["focal_px"],
        how["sigma_focal"] / 100,
        refine=how["refine"] or (),
        square_on=how["square_on"],
    )


def _picture_request(how: Mapping[str, Any]) -> PictureRequest:
    if how["crs"] is not None:
        epsg_code(how["crs"])
    return PictureRequest(
        how["resolution"],
        _extent(how["extent"]),
        how["coarsest"],
        how["border"],
        how["quality"],
        how["crs"],
        None if how["grid_like"] is None else grid_like(how["grid_like"]),
    )


def _extent(text: str) -> Shown | Extent:
    if text in ("points", "photo"):
        return text
    try:
        left, bottom, right, top = (float(part) for part in text.replace("−", "-").split(","))
    except ValueError:
        raise OptionError(
            f"--extent {text} is neither points, photo nor four numbers",
            hint="as --extent -5,0,5,25: X and Y of the lower left and of the upper right corner",
        ) from None
    return left, bottom, right, top


def _picture_target(photo: Path, output: str | None) -> Path:
    target = Path(output) if output else beside(photo, SUFFIX)
    format_of(target)
    return target


def _saved_target(photo: Path, picture: Path | None) -> Path:
    return (picture or beside(photo, SUFFIX)).with_suffix(".json")


def _refuse_targets(
    photo: Path, picture: Path | None, saved: Path, inputs: list[str], how: Mapping[str, Any]
) -> None:
    """Refuse to write over what plumbline did not write, before any work is done."""
    overwrite: bool = how["overwrite"]
    refuse_to_clobber(saved, inputs, overwrite=overwrite)
    if how["dxf"]:
        refuse_unknown_suffix(Path(how["dxf"]), (".dxf",), "drawings")
        refuse_to_clobber(Path(how["dxf"]), inputs, overwrite=overwrite)
    if picture is None:
        return
    if how["mosaic"] and not how["grid_like"]:
        raise OptionError(
            "--mosaic blends with the picture of --grid-like", hint="name it with --grid-like"
        )
    more = [Path(how["mosaic"])] if how["mosaic"] else []
    more += [_overlay_target(picture)] if how["overlay"] else []
    for target in (picture, *more):
        check_target(target, photo, overwrite=overwrite)
    refuse_to_clobber(world_file_name(picture), inputs, overwrite=overwrite or picture.exists())
    if saved == picture:
        raise WriteError("picture and rectification are one file", path=saved, hint="see --save")


def _overlay_target(picture: Path) -> Path:
    return picture.with_name(f"{picture.stem}_overlay.png")


def _beside_others(
    rectified: RectifiedPicture,
    picture: Path,
    wanted: PictureRequest,
    found: Rectification,
    how: Mapping[str, Any],
) -> dict[Path, bytes]:
    """The overlay and the mosaic, where they are asked for."""
    contents: dict[Path, bytes] = {}
    if how["overlay"]:
        target = _overlay_target(picture)
        contents[target] = overlay_bytes(rectified, how["overlay"], target)
    if how["mosaic"]:
        blended = replace(rectified, picture=mosaic(rectified, how["grid_like"]))
        target = Path(how["mosaic"])
        contents |= picture_files(blended, target, wanted, description_of(found))[0]
    return contents


def tape_measurements(found: Rectification) -> list[Measurement]:
    """The taped distances as adjusted."""
    return [found.measure("distance", [t.first, t.second]) for t in found.findings.tapes]


def _tell(
    found: Rectification, written: Mapping[Path, bytes], notes: list[str], how: Mapping[str, Any]
) -> None:
    for note in (*found.findings.notes, *notes):
        click.echo(f"Note: {printable(note)}.", err=True)
    if how["as_json"]:
        saved = next(data for path, data in written.items() if path.suffix == ".json")
        click.echo(saved.decode(), nl=False)
        return
    if how["quiet"]:
        return
    from plumbline.report.terminal.rectification import print_rectification
    from plumbline.report.terminal.summary import WideConsole

    print_rectification(WideConsole(), found)
    for path in written:
        click.echo(f"Wrote {printable(str(path))}")

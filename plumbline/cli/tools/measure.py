"""`plumbline measure` without its parsing."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator, Mapping, Sequence
from hashlib import sha256
from itertools import pairwise
from pathlib import Path
from typing import Any

import click
import numpy as np

from plumbline.cli.tools.ground_report import pixels_of
from plumbline.errors import OptionError, WriteError, printable
from plumbline.files import read_bytes, refuse_to_clobber, write_atomically
from plumbline.ground.findings import InputFile
from plumbline.ground.measure import KINDS, Kind, Measurement
from plumbline.ground.reading.matches import read_matches
from plumbline.ground.rectification import Rectification
from plumbline.ground.stored import StoredRectification, read_rectification
from plumbline.wording import listed

_FORMAT = "plumbline measurements"


def run(picks: str | None, saved: str, how: Mapping[str, Any], *, as_json: bool) -> None:
    """Measure what is asked for, print it, and write it where wanted."""
    stored = read_rectification(saved)
    points = _picks(picks, stored.rectification)
    measurements = list(_measured(stored.rectification, points, how))
    contents: dict[Path, bytes] = {}
    if how["output"]:
        target = Path(how["output"])
        refuse_to_clobber(target, [saved, *([picks] if picks else [])], overwrite=how["overwrite"])
        contents[target] = _file(target, stored, (saved, picks), points, measurements)
    write_atomically(contents)
    if as_json:
        click.echo(_json(stored, measurements), nl=False)
        return
    from plumbline.report.terminal.measurements import print_measurements
    from plumbline.report.terminal.summary import WideConsole

    print_measurements(WideConsole(), measurements)
    for path in contents:
        click.echo(f"Wrote {printable(str(path))}")


def _picks(path: str | None, found: Rectification) -> dict[str, tuple[float, float]]:
    """Named picks of a file; those of the rectification keep their names for themselves."""
    if path is None:
        return {}
    matches = read_matches(path)
    frame = found.camera.optics.lens.frame
    outside = np.flatnonzero(~frame.contains(matches.picks_px))
    if len(outside):
        names = listed([matches.names[index] for index in outside])
        raise OptionError(
            f"{path}: outside of the photo are {names}: it has {frame.width}x{frame.height} pixels",
            hint="give pixels of the photo that was rectified",
        )
    points: dict[str, tuple[float, float]] = {}
    for name, (x, y) in zip(matches.names, matches.picks_px.tolist(), strict=True):
        if name in found.names and (x, y) != tuple(found.picks_px[found.names.index(name)]):
            raise OptionError(
                f"{path}: {name} is a point of the rectification, and picked elsewhere here",
                hint="give the pick another name",
            )
        if name not in found.names:
            points[name] = (x, y)
    return points


def _measured(
    found: Rectification, picks: Mapping[str, tuple[float, float]], how: Mapping[str, Any]
) -> Iterator[Measurement]:
    asked: list[tuple[Kind, Sequence[str]]] = [
        (kind, names) for kind in KINDS for names in how[kind]
    ]
    for kind, names in asked or _all(found, picks):
        yield found.measure(kind, names, picks)


def _all(found: Rectification, picks: Mapping[str, object]) -> Iterator[tuple[Kind, Sequence[str]]]:
    """Every place, and the distance from each point to the next."""
    names = list(picks) or list(found.names)
    for name in names:
        yield "place", [name]
    for pair in pairwise(names):
        yield "distance", pair


def _file(
    target: Path,
    stored: StoredRectification,
    sources: tuple[str, str | None],
    points: Mapping[str, tuple[float, float]],
    measurements: Sequence[Measurement],
) -> bytes:
    suffix = target.suffix.lower()
    if suffix == ".dxf":
        from plumbline.rectified.dxf import dxf_bytes

        return dxf_bytes(stored.rectification, points, measurements)
    if suffix == ".html":
        from plumbline.report.page.ground import ground_page

        saved, picks = sources
        inputs = (
            [InputFile(Path(picks).name, sha256(read_bytes(picks)).hexdigest())] if picks else []
        )
        return ground_page(stored, pixels_of(stored, Path(saved)), measurements, inputs)
    if suffix == ".json":
        return _json(stored, measurements).encode()
    if suffix == ".csv":
        return _csv(measurements).encode()
    raise WriteError(
        f"measurements are not written as {suffix or 'files without a suffix'}",
        path=target,
        hint="use .csv, .json, .dxf or .html",
    )


def _csv(measurements: Sequence[Measurement]) -> str:
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    heads = ("kind", "points", "quantity", "value", "standard_error", "low_95", "high_95", "unit")
    writer.writerow([*heads, "ellipse_long", "ellipse_short", "ellipse_angle_deg"])
    for each in measurements:
        names = ("X", "Y") if each.kind == "place" else (each.kind,)
        ellipse = [f"{value:.9g}" for value in each.ellipse or ()]
        for quantity, value, error, (low, high) in zip(
            names, each.values, each.errors, each.intervals, strict=True
        ):
            numbers = [f"{number:.9g}" for number in (value, error, low, high)]
            points = " ".join(each.names)
            writer.writerow([each.kind, points, quantity, *numbers, each.unit, *ellipse])
    return text.getvalue()


def _json(stored: StoredRectification, measurements: Sequence[Measurement]) -> str:
    whole = {
        "format": _FORMAT,
        "photo": stored.photo,
        "photo_sha256": stored.photo_sha256,
        "measurements": [
            {
                "kind": each.kind,
                "points": list(each.names),
                "values": list(each.values),
                "standard_errors": list(each.errors),
                "intervals_95": [list(ends) for ends in each.intervals],
                "unit": each.unit,
                "ellipse_95": each.ellipse
                and dict(zip(("long_m", "short_m", "angle_deg"), each.ellipse, strict=True)),
            }
            for each in measurements
        ],
    }
    return json.dumps(whole, indent=2, ensure_ascii=False, allow_nan=False) + "\n"

"""PTLens profiles (2006), read and written.

    begin camera
    menu_make: Nikon
    menu_model: Coolpix 995
    exif_make: NIKON
    exif_model: E995
    group: nikon995
    multiplier: 4.843
    end
    begin lens
    menu_lens: Standard
    group: nikon995
    multiplier: 4.843
    cal_abc: 8.2 0 -0.019966 0
    end

An index (`version: 4.2`, then `file: canon.txt` lines) names other such files beside it. A
camera takes the lenses whose group it shares. Vignetting and colour fringes (`cal_vig:`,
`cal_tca:`) are left aside. Source: the profiles that PTLens 6 came with.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from plumbline.errors import printable
from plumbline.files import read_bytes
from plumbline.formats.base import Source, shown

_HINT = "take the profile as PTLens came with it, or correct this line"
_MOST_FILES = 1000
"""Chosen: PTLens ships a few; a folder of more is another folder."""
_MOST_LINES = 1_000_000
"""Chosen: PTLens' database has some 30,000."""
_LARGEST = 100.0
"""Of a coefficient; chosen, those of real lenses stay below 1."""

ABC = tuple[float, float, float]


@dataclass(frozen=True)
class PTLensCamera:
    """A camera.

    Attributes:
        menu_make: Maker for people.
        menu_model: Model for people.
        exif_make: Maker as EXIF has it.
        exif_model: Model as EXIF has it.
        groups: Names of the groups of lenses that fit it.
        multiplier: Crop factor.
    """

    menu_make: str
    menu_model: str
    exif_make: str
    exif_model: str
    groups: frozenset[str]
    multiplier: float

    @property
    def menu_name(self) -> str:
        """Maker and model for people."""
        return f"{self.menu_make} {self.menu_model}".strip()

    def is_of(self, make: str, model: str) -> bool:
        """Whether EXIF's maker and model are this camera's, however often they name the maker."""
        own, other = (
            (make.casefold().split()[:1], without_maker(model, make).casefold())
            for make, model in ((self.exif_make, self.exif_model), (make, model))
        )
        return own == other


@dataclass(frozen=True)
class PTLensLens:
    """A lens.

    Attributes:
        name: Name for people.
        groups: The groups it belongs to.
        multiplier: Crop factor of the camera it was calibrated with.
        calibrations: a, b, c by focal length in millimetres, ascending.
        converter_factor: Of an attached converter; 1 without.
    """

    name: str
    groups: frozenset[str]
    multiplier: float
    calibrations: tuple[tuple[float, ABC], ...]
    converter_factor: float = 1.0


@dataclass(frozen=True)
class PTLensProfile:
    """All cameras and lenses of a profile."""

    cameras: tuple[PTLensCamera, ...]
    lenses: tuple[PTLensLens, ...]


def recognises(source: Source) -> bool:
    """Whether a file looks like a PTLens profile or the index of one."""
    rows = [row.split("#")[0].strip() for row in source.head.splitlines()]
    rows = [row for row in rows if row]
    return any(row in ("begin camera", "begin lens") for row in rows) or (
        bool(rows) and rows[0].startswith("version:") and any(r.startswith("file:") for r in rows)
    )


def read_ptlens(source: Source) -> PTLensProfile:
    """Read a profile and, where it is an index, the files it names.

    Raises:
        ReadError: a file is damaged or missing, or holds no lens.
    """
    cameras, lenses, others = _read_one(source)
    if len(others) > _MOST_FILES:
        raise source.error(f"the index names {len(others):,} files", hint=_HINT)
    for row, name in others:
        plain = PurePosixPath(name.replace("\\", "/"))
        if plain.name != str(plain) or plain.name in ("", ".", ".."):
            raise source.error(f"{shown(name)} is not a plain file name", row, hint=_HINT)
        path = Path(source.path).parent / plain.name
        more_cameras, more_lenses, _ = _read_one(Source(str(path), read_bytes(path)))
        cameras += more_cameras
        lenses += more_lenses
    if not lenses:
        raise source.error("there is no lens in this profile", hint=_HINT)
    return PTLensProfile(tuple(cameras), tuple(lenses))


_Fields = list[tuple[int, str, str]]


def _read_one(
    source: Source,
) -> tuple[list[PTLensCamera], list[PTLensLens], list[tuple[int, str]]]:
    """Cameras, lenses and the names of further files, with their lines."""
    cameras, lenses, files = list[PTLensCamera](), list[PTLensLens](), list[tuple[int, str]]()
    for kind, fields in _blocks(source):
        if kind == "camera":
            cameras.append(_camera(source, fields))
        elif kind == "lens":
            lenses.append(_lens(source, fields))
        else:
            files += [(row, value) for row, key, value in fields if key == "file"]
    return cameras, lenses, files


def _blocks(source: Source) -> Iterator[tuple[str, _Fields]]:
    """Each block's kind and its fields; the fields outside of blocks come last, as `index`."""
    texts = source.text().splitlines()
    if len(texts) > _MOST_LINES:
        raise source.error(f"the profile has {len(texts):,} lines", hint=_HINT)
    kind, fields, outside = "", _Fields(), _Fields()
    for row, text in enumerate(texts, 1):
        line = text.split("#")[0].strip()
        if line in ("begin camera", "begin lens"):
            if kind:
                raise source.error("a new block begins before the last one ended", row, _HINT)
            kind, fields = line.removeprefix("begin "), [(row, "begin", "")]
        elif line == "end":
            if kind:
                yield kind, fields
            kind = ""
        elif line:
            key, colon, value = line.partition(":")
            if not colon:
                raise source.error(f"{shown(line)} is not 'key: value'", row, _HINT)
            (fields if kind else outside).append((row, key.strip(), value.strip()))
    if kind:
        raise source.error(f"the last {kind} does not end: the file is cut off", hint=_HINT)
    yield "index", outside


def _text(fields: _Fields, key: str) -> str:
    return printable(next((value for _, name, value in fields if name == key), ""))[:120]


def _groups(fields: _Fields) -> frozenset[str]:
    return frozenset(value.casefold() for _, name, value in fields if name == "group")


def _number(source: Source, fields: _Fields, key: str, default: float | None = None) -> float:
    for row, name, value in fields:
        if name == key:
            found = source.number(value, row, what=f"the value of {key}")
            if found <= 0:
                raise source.error(f"{key} is not above zero", row, _HINT)
            return found
    if default is None:
        raise source.error(f"this block has no {key}", fields[0][0], _HINT)
    return default


def without_maker(model: str, make: str) -> str:
    """A camera's model without the words of its maker that it begins with."""
    of_maker, words = make.casefold().split(), model.split()
    while len(words) > 1 and words[0].casefold() in of_maker:
        del words[0]
    return " ".join(words)


def _camera(source: Source, fields: _Fields) -> PTLensCamera:
    return PTLensCamera(
        _text(fields, "menu_make"),
        _text(fields, "menu_model"),
        _text(fields, "exif_make"),
        _text(fields, "exif_model"),
        _groups(fields),
        _number(source, fields, "multiplier"),
    )


def _lens(source: Source, fields: _Fields) -> PTLensLens:
    found: dict[float, ABC] = {}
    for row, name, value in fields:
        if name != "cal_abc":
            continue
        numbers = [source.number(part, row, what="a value of cal_abc") for part in value.split()]
        if len(numbers) != 4 or numbers[0] <= 0:
            raise source.error("cal_abc does not hold a focal length, a, b and c", row, _HINT)
        if max(map(abs, numbers[1:])) > _LARGEST:
            raise source.error("a value of cal_abc is impossibly large", row, _HINT)
        found[numbers[0]] = (numbers[1], numbers[2], numbers[3])
    return PTLensLens(
        _text(fields, "menu_lens"),
        _groups(fields),
        _number(source, fields, "multiplier"),
        tuple(sorted(found.items())),
        _number(source, fields, "converter_factor", 1.0),
    )


def ptlens_profile(camera: PTLensCamera, lens: PTLensLens, mark: str) -> bytes:
    """A profile of one camera and one lens.

    Args:
        camera: The camera.
        lens: The lens.
        mark: A comment for its first line.
    """
    rows = [f"# {mark}", "begin camera"]
    rows += [f"menu_make: {camera.menu_make}", f"menu_model: {camera.menu_model}"]
    rows += [f"exif_make: {camera.exif_make}", f"exif_model: {camera.exif_model}"]
    rows += [f"group: {group}" for group in sorted(camera.groups)]
    rows += [f"multiplier: {camera.multiplier:.7g}", "end"]
    rows += ["begin lens", f"menu_lens: {lens.name}"]
    rows += [f"group: {group}" for group in sorted(lens.groups)]
    rows += [f"multiplier: {lens.multiplier:.7g}"]
    rows += _calibration_rows(lens.calibrations)
    return ("\n".join([*rows, "end"]) + "\n").encode()


def _calibration_rows(calibrations: Sequence[tuple[float, ABC]]) -> list[str]:
    return [f"cal_abc: {focal:.7g} {a:.9f} {b:.9f} {c:.9f}" for focal, (a, b, c) in calibrations]

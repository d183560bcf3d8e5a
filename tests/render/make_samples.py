"""Regenerates the photographs, picks and expected results under `sample_projects/`.

Run from the top of the repository: `python -m tests.render.make_samples [folder]`.
"""

import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from . import make_others, optics, painting, photo, picks, writers
from .optics import Array, Pose, View
from .scene import Facade

TARGET = Path(__file__).resolve().parents[2] / "sample_projects"
CURVE_WITHIN_PX = 1.5

OFFICES = Facade(bays=15, seed=11)
LIBRARY = Facade(
    bays=14, storeys=5, bay=3.6, storey=3.6, window=(2.4, 2.1), sill=0.8, pier_every=2, pier=0.5,
    wall=(164, 104, 82), trim=(222, 214, 198), frame=(40, 46, 48), seed=23,
    neighbours=((190, 184, 170), (150, 152, 156)), neighbour_heights=(22.0, 16.0),
)  # fmt: skip
TOWER = Facade(
    bays=11, storeys=8, bay=3.2, storey=3.0, window=(1.9, 1.7), sill=0.75, pier_every=11, pier=0.4,
    wall=(206, 204, 200), trim=(234, 232, 228), frame=(44, 58, 74), seed=37,
    neighbours=((142, 128, 112), (176, 120, 96)), neighbour_heights=(16.0, 24.0),
)  # fmt: skip
STATION = Facade(
    bays=17, storeys=6, bay=2.8, storey=3.3, window=(1.8, 2.0), sill=0.75, pier_every=4, pier=0.4,
    wall=(182, 180, 166), trim=(218, 216, 204), frame=(60, 56, 50), seed=53,
    neighbours=((170, 130, 104), (140, 146, 150)), neighbour_heights=(19.0, 14.0),
)  # fmt: skip

GRID_ROWS, GRID_COLUMNS = range(1, 8), range(1, 10)


@dataclass(frozen=True)
class Exposure:
    """A photograph to be taken: its file, view, façade, seed, picks a line and date."""

    name: str
    view: View
    facade: Facade
    seed: int
    count: int
    taken: str

    def lines(self) -> list[picks.Line]:
        edges = picks.choose(self.view, self.facade)
        return picks.pick(self.view, edges, self.count, self.seed + 1)

    def grid(self) -> Array:
        return picks.pick_grid(self.view, self.facade, GRID_ROWS, GRID_COLUMNS, self.seed + 1)


BUILDING = Exposure(
    "facade.jpg",
    View(optics.EFS_18, Pose(22.5, 9.0, 31.0, yaw=-4, pitch=6.0, roll=0.6), 2256, 1504),
    OFFICES, seed=101, count=10, taken="2021:06:12 10:24:31",
)  # fmt: skip
CSV = Exposure(
    "facade.jpg",
    View(optics.NIKKOR_42, Pose(24.0, 9.0, 43.0, yaw=3, pitch=3, roll=-0.5), 2256, 1504),
    LIBRARY, seed=211, count=9, taken="2022:04:03 15:02:10",
)  # fmt: skip
GRID = Exposure(
    "facade.jpg",
    View(optics.G15_6, Pose(16.9, 14.9, 22.9, yaw=1.5, pitch=0.5, roll=0.4), 2048, 1536),
    TOWER, seed=307, count=0, taken="2020:09:18 11:47:55",
)  # fmt: skip
ZOOM = (
    Exposure(
        "facade_18mm.jpg",
        View(optics.DX_18, Pose(22.4, 9.0, 29.5, yaw=3, pitch=6.0, roll=-0.4), 2160, 1440),
        STATION, seed=401, count=10, taken="2023:05:21 09:12:04",
    ),
    Exposure(
        "facade_35mm.jpg",
        View(optics.DX_35, Pose(23.0, 10.0, 58.0, yaw=-3, pitch=2.3, roll=0.3), 2160, 1440),
        STATION, seed=409, count=10, taken="2023:05:21 09:15:47",
    ),
    Exposure(
        "facade_105mm.jpg",
        View(optics.DX_105, Pose(18.0, 11.0, 175.0, yaw=2.0, pitch=0.5, roll=-0.3), 2160, 1440),
        STATION, seed=419, count=10, taken="2023:05:21 09:21:30",
    ),
)  # fmt: skip
OFFICE_TOWER = Facade(
    bays=14, storeys=6, bay=3.1, storey=3.2, pier_every=2, pier=0.45,
    wall=(186, 178, 160), trim=(230, 226, 216), frame=(46, 50, 56), seed=71,
    neighbours=((150, 120, 100), (166, 164, 158)), neighbour_heights=(17.0, 21.0),
)  # fmt: skip
UNPICKED = Exposure(
    "facade.jpg",
    View(optics.G15_6, Pose(21.5, 10.0, 27.0, yaw=2, pitch=2.5, roll=-0.5), 2048, 1536),
    OFFICE_TOWER, seed=503, count=0, taken="2022:09:03 11:20:05",
)  # fmt: skip
UNPICKED_WITHIN_PX = 0.3

EXPOSURES = {
    "building": (BUILDING,),
    "facade_csv": (CSV,),
    "grid_winmorph": (GRID,),
    "zoom": ZOOM,
}


def shots(exposures: Sequence[Exposure]) -> list[writers.Shot]:
    """Return what the Hugin writer asks for."""
    return [writers.Shot(each.name, each.view, each.lines()) for each in exposures]


def truth(view: View) -> dict[str, object]:
    """Return the coefficients that bent the photograph, and where they were published."""
    lens = view.lens
    return {"model": "ptlens", "coefficients": lens.coefficients, "source": lens.source}


def tally(lines: Sequence[picks.Line]) -> dict[str, object]:
    """Return how much was picked."""
    total = sum(len(line.points) for line in lines)
    return {"n_points": total, "n_lines": len(lines)}


def expected(command: Sequence[str], stem: str, rest: Mapping[str, object]) -> str:
    """Return the text of an `expected.json`: the renderer's truth, nothing that a fit printed."""
    outputs = [f"{stem}.fit.pto", f"{stem}.fit.xml"]
    known = {"noise_px": picks.NOISE_PX, "curve_within_px": CURVE_WITHIN_PX, "outputs": outputs}
    content = {"command": list(command), **rest, **known}
    return json.dumps(content, indent=2, ensure_ascii=False) + "\n"


def _of_photo_alone(exposure: Exposure) -> str:
    """Return the `expected.json` of a photograph without picks."""
    content = {
        "command": ["fit", exposure.name],
        "truth": truth(exposure.view),
        "curve_within_px": UNPICKED_WITHIN_PX,
        "outputs": ["facade.fit.pto", "facade.fit.xml"],
    }
    return json.dumps(content, indent=2, ensure_ascii=False) + "\n"


def texts() -> dict[str, str]:
    """Return every text file that is generated, by its path below `sample_projects/`."""
    building, facade, zoom = BUILDING.lines(), CSV.lines(), shots(ZOOM)
    grid_fit = ["fit", "grid.mrf", "--photo", "facade.jpg", "--grid", "7x9"]
    rows, columns = len(GRID_ROWS), len(GRID_COLUMNS)
    # A corner belongs to a row and to a column, so each of the picks counts in two lines.
    grid_tally = {"n_points": 2 * rows * columns, "n_lines": rows + columns}
    lenses = [
        {
            "image": each.name,
            "focal": each.view.lens.focal,
            "truth": truth(each.view),
            **tally(shot.lines),
        }
        for each, shot in zip(ZOOM, zoom, strict=True)
    ]
    return {
        "building/building.pto": writers.hugin(shots([BUILDING])),
        "building/expected.json": expected(
            ["fit", "building.pto"], "building", {"truth": truth(BUILDING.view), **tally(building)}
        ),
        "facade_csv/picks.csv": writers.csv(facade),
        "facade_csv/expected.json": expected(
            ["fit", "picks.csv", "--photo", "facade.jpg"],
            "picks",
            {"truth": truth(CSV.view), **tally(facade)},
        ),
        "grid_winmorph/grid.mrf": writers.winmorph(GRID.view, GRID.grid()),
        "grid_winmorph/expected.json": expected(
            grid_fit, "grid", {"truth": truth(GRID.view), "n_picks": rows * columns, **grid_tally}
        ),
        "facade_photo/expected.json": _of_photo_alone(UNPICKED),
        "zoom/zoom.pto": writers.hugin(zoom),
        "zoom/expected.json": expected(["fit", "zoom.pto"], "zoom", {"lenses": lenses}),
        **make_others.texts(),
    }


def main(target: Path = TARGET) -> None:
    """Write everything but the READMEs."""
    for name, text in texts().items():
        path = target / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8", newline="\n")
    for folder, exposures in {**EXPOSURES, "facade_photo": (UNPICKED,)}.items():
        for each in exposures:
            picture = photo.take(each.view, painting.paint(each.facade), each.seed)
            photo.save(picture, each.view, target / folder / each.name, each.taken)
    make_others.pictures(target)


if __name__ == "__main__":
    main(*(Path(argument) for argument in sys.argv[1:2]))

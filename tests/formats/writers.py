"""Files of points as other programs write them, for each format that is read.

Every writer takes lines in plumbline's coordinates and writes them in its program's own, and in
the way that the program has for a kind of drawing: `lines` (a polyline each), `picks` (single
points that bear the name of their line) or `groups` (single points that share a group). Where a
program has no such way the writer returns None. Written from the programs' formats, not from the
readers.
"""

from __future__ import annotations

import csv
import io
import json
import struct
import zipfile
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal

Points = Sequence[tuple[float, float]]
Lines = Mapping[str, Points]
Kind = Literal["lines", "picks", "groups"]
SIZE = (800, 600)
W, H = SIZE
NAME = "wall.jpg"


def _shifted(lines: Lines, by: float = 0.5) -> dict[str, list[list[float]]]:
    return {label: [[x + by, y + by] for x, y in points] for label, points in lines.items()}


def _singly(lines: Lines, by: float = 0.5) -> list[tuple[int, str, float, float]]:
    return [
        (number, label, x + by, y + by)
        for number, (label, points) in enumerate(lines.items(), start=1)
        for x, y in points
    ]


def _json(value: object) -> bytes:
    return json.dumps(value).encode()


def _table(rows: Sequence[Sequence[object]]) -> bytes:
    text = io.StringIO(newline="")
    csv.writer(text).writerows(rows)
    return text.getvalue().encode()


def own_json(lines: Lines, kind: Kind) -> bytes | None:
    if kind != "lines":
        return None
    whole = {
        "lenses": [{"maker": "", "focal_mm": 9.2, "stored": {"a": 0.1}, "requested": ["b"]}],
        "photos": [{"name": NAME, "number": 0, "size": SIZE, "pixel_aspect": 1, "lens": 0}],
        "lines": [{"label": n, "photo": 0, "points_px": list(p)} for n, p in lines.items()],
        "origins": [{"path": "a.csv", "format": "csv", "sha256": "12ab"}],
        "notes": ["a note"],
    }
    return _json({"format": "plumbline points", "format_version": 1, "observations": whole})


def _pairs(points: Points) -> list[tuple[tuple[float, float], tuple[float, float]]]:
    return [(a, points[(i + 1) % len(points)]) for i, a in enumerate(points)]


def pto(lines: Lines, kind: Kind) -> bytes | None:
    if kind != "lines":
        return None
    text = f'# hugin project file\ni w{W} h{H} f0 v50 a0 b0 c0 d0 e0 n"{NAME}"\n'
    for number, points in enumerate(lines.values(), start=3):
        for (x, y), (x2, y2) in _pairs(points):
            text += f"c n0 N0 x{x!r} y{y!r} X{x2!r} Y{y2!r} t{number}\n"
    return text.encode()


def ptgui(lines: Lines, kind: Kind) -> bytes | None:
    if kind != "lines":
        return None
    points = [
        {"t": number, "0": [0, 0, *a], "1": [0, 0, *b]}
        for number, each in enumerate(lines.values(), start=3)
        for a, b in _pairs(each)
    ]
    group = {"size": SIZE, "images": [{"filename": NAME}]}
    project = {"imagegroups": [group], "controlpoints": points}
    return _json({"contenttype": "com.ptgui.project_pro", "project": project})


def cvat(lines: Lines, kind: Kind) -> bytes | None:
    shapes = ""
    if kind == "lines":
        for label, points in _shifted(lines).items():
            text = ";".join(f"{x!r},{y!r}" for x, y in points)
            shapes += f'<polyline label="{label}" points="{text}"/>\n'
    for number, label, x, y in _singly(lines) if kind != "lines" else ():
        group = f' group_id="{number}"' if kind == "groups" else ""
        name = "edge" if kind == "groups" else label
        shapes += f'<points label="{name}"{group} points="{x!r},{y!r}"/>\n'
    image = f'<image id="0" name="{NAME}" width="{W}" height="{H}">{shapes}</image>'
    return f'<?xml version="1.0"?>\n<annotations>{image}</annotations>'.encode()


def cell_counter(lines: Lines, kind: Kind) -> bytes | None:
    if kind != "groups":
        return None
    types = ""
    for number, points in enumerate(lines.values(), start=1):
        markers = "".join(
            f"<Marker><MarkerX>{x!r}</MarkerX><MarkerY>{y!r}</MarkerY><MarkerZ>1</MarkerZ></Marker>"
            for x, y in points
        )
        types += f"<Marker_Type><Type>{number}</Type>{markers}</Marker_Type>"
    return (
        f"<CellCounter_Marker_File><Image_Properties><Image_Filename>{NAME}</Image_Filename>"
        f"</Image_Properties><Marker_Data>{types}</Marker_Data></CellCounter_Marker_File>"
    ).encode()


def svg(lines: Lines, kind: Kind) -> bytes | None:
    if kind != "lines":
        return None
    shapes = ""
    for number, (label, points) in enumerate(_shifted(lines).items()):
        # A drawing in units of 2 pixels, moved by (7, 3), and every second line a path.
        text = " ".join(f"{x / 2 + 7!r},{y / 2 + 3!r}" for x, y in points)
        tag = f'<path d="M {text}"' if number % 2 else f'<polyline points="{text}"'
        shapes += f'{tag} id="{label}"/>'
    image = f'<image x="7" y="3" width="{W / 2}" height="{H / 2}" xlink:href="{NAME}"/>'
    space = 'xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"'
    return f'<svg {space}><g transform="translate(5 2)">{image}{shapes}</g></svg>'.encode()


def labelme(lines: Lines, kind: Kind) -> bytes | None:
    shapes: list[dict[str, Any]] = [
        {"label": label, "points": points, "shape_type": "linestrip"}
        for label, points in _shifted(lines).items()
    ]
    if kind != "lines":
        shapes = [
            {
                "label": "edge" if kind == "groups" else label,
                "group_id": number if kind == "groups" else None,
                "points": [[x, y]],
                "shape_type": "point",
            }
            for number, label, x, y in _singly(lines)
        ]
    return _json({"shapes": shapes, "imagePath": NAME, "imageHeight": H, "imageWidth": W})


def via(lines: Lines, kind: Kind) -> bytes | None:
    if kind == "groups":
        return None
    rows: list[list[object]] = [
        ["filename", "file_size", "region_shape_attributes", "region_attributes"]
    ]
    if kind == "lines":
        for label, points in _shifted(lines).items():
            x, y = zip(*points, strict=True)
            shape = {"name": "polyline", "all_points_x": x, "all_points_y": y}
            rows.append([NAME, 9, json.dumps(shape), json.dumps({"line": label})])
        return _table(rows)
    for _, label, x, y in _singly(lines):
        shape = {"name": "point", "cx": x, "cy": y}
        rows.append([NAME, 9, json.dumps(shape), json.dumps({"line": label})])
    return _table(rows)


def via3(lines: Lines, kind: Kind) -> bytes | None:
    if kind == "groups":
        return None
    regions = [
        ([6, *(n for p in points for n in p)], label) for label, points in _shifted(lines).items()
    ]
    if kind == "picks":
        regions = [([1, x, y], label) for _, label, x, y in _singly(lines)]
    head = (
        b"# Exported using VGG Image Annotator\n# CSV_HEADER = metadata_id,file_list,flags,"
        b"temporal_coordinates,spatial_coordinates,metadata\n"
    )
    rows = [
        [f"1_{i}", json.dumps([NAME]), 0, "[]", json.dumps(xy), json.dumps({"1": label})]
        for i, (xy, label) in enumerate(regions)
    ]
    return head + _table(rows)


def datumaro(lines: Lines, kind: Kind) -> bytes | None:
    names = list(lines)
    shapes: list[dict[str, Any]] = [
        {"type": "polyline", "label_id": i, "points": [n for p in points for n in p]}
        for i, points in enumerate(_shifted(lines).values())
    ]
    if kind != "lines":
        groups = kind == "groups"
        shapes = [
            {
                "type": "points",
                "label_id": 0 if groups else number - 1,
                "group": number if groups else 0,
                "points": [x, y],
            }
            for number, _, x, y in _singly(lines)
        ]
    labels = {"label": {"labels": [{"name": name} for name in names]}}
    item = {"id": "wall", "image": {"path": NAME, "size": [H, W]}, "annotations": shapes}
    return _json({"categories": labels, "items": [item]})


def coco(lines: Lines, kind: Kind) -> bytes | None:
    if kind != "groups":
        return None
    annotations = [
        {"image_id": 3, "category_id": i, "keypoints": [n for x, y in points for n in (x, y, 2)]}
        for i, points in enumerate(_shifted(lines).values())
    ]
    kinds = [{"id": i, "name": name} for i, name in enumerate(lines)]
    images = [{"id": 3, "file_name": NAME, "width": W, "height": H}]
    return _json({"images": images, "categories": kinds, "annotations": annotations})


def geojson(lines: Lines, kind: Kind) -> bytes | None:
    if kind == "groups":
        return None
    shapes = [("LineString", points, label) for label, points in _shifted(lines).items()]
    if kind == "picks":
        shapes = [("Point", [x, y], label) for _, label, x, y in _singly(lines)]
    features = [
        {
            "type": "Feature",
            "geometry": {"type": of, "coordinates": xy},
            "properties": {"classification": {"name": label}},
        }
        for of, xy, label in shapes
    ]
    return _json({"type": "FeatureCollection", "features": features})


def imagej(lines: Lines, kind: Kind) -> bytes | None:
    if kind == "picks":
        return None
    if kind == "groups":
        rows = [[" ", "Area", "X", "Y", "Group"]]
        rows += [
            [str(i), "0", repr(x), repr(y), str(n)]
            for i, (n, _, x, y) in enumerate(_singly(lines, 0.0))
        ]
        return _table(rows)
    whole = io.BytesIO()
    with zipfile.ZipFile(whole, "w") as archive:
        for label, points in lines.items():
            archive.writestr(f"{label}.roi", roi(points))
    return whole.getvalue()


def roi(points: Points) -> bytes:
    """A polyline with parts of pixels, big-endian, as `ij/io/RoiEncoder.java` lays it out."""
    x, y = ([p[axis] for p in points] for axis in (0, 1))
    n = len(points)
    left, top = int(min(x)), int(min(y))
    box = (top, left, int(max(y)) + 1, int(max(x)) + 1)
    head = struct.pack(">4shBBhhhhH30xhh12x", b"Iout", 228, 5, 0, *box, n, 0, 128)
    whole = [int(v) - left for v in x] + [int(v) - top for v in y]
    return head + struct.pack(f">{2 * n}h{2 * n}f64x", *whole, *x, *y)


def wpd_project(lines: Lines, kind: Kind) -> bytes | None:
    if kind != "lines":
        return None
    sets = [
        {"name": label, "data": [{"x": x, "y": y, "value": [0.1, 5]} for x, y in points]}
        for label, points in _shifted(lines).items()
    ]
    return _json({"version": [4, 2], "axesColl": [], "datasetColl": sets})


def webplotdigitizer(lines: Lines, kind: Kind) -> bytes | None:
    if kind != "lines":
        return None
    shifted = _shifted(lines)
    names: list[object] = [cell for label in shifted for cell in (label, "")]
    axes: list[object] = ["X", "Y"] * len(shifted)
    rows = [names, axes]
    for i in range(max(map(len, shifted.values()))):
        rows.append([n for p in shifted.values() for n in (p[i] if i < len(p) else ("", ""))])
    return _table(rows)


def napari(lines: Lines, kind: Kind) -> bytes | None:
    if kind != "lines":
        return None
    rows: list[Sequence[object]] = [["index", "shape-type", "vertex-index", "axis-0", "axis-1"]]
    for i, points in enumerate(lines.values()):
        rows += [[float(i), "path", float(v), y, x] for v, (x, y) in enumerate(points)]
    return _table(rows)


def makesense(lines: Lines, kind: Kind) -> bytes | None:
    if kind != "picks":
        return None
    return _table([[label, x, y, NAME, W, H] for _, label, x, y in _singly(lines)])


def xlsx(lines: Lines, kind: Kind) -> bytes | None:
    from openpyxl import Workbook

    if kind != "picks":
        return None
    workbook = Workbook()
    sheet: Any = workbook.active
    sheet.append(["line", "x", "y"])
    for _, label, x, y in _singly(lines, 0.0):
        sheet.append([label, x, y])
    workbook.create_sheet("notes")["A1"] = "picked on Monday"
    out = io.BytesIO()
    workbook.save(out)
    return out.getvalue()


def winmorph(lines: Lines, kind: Kind) -> bytes | None:
    if kind != "lines":
        return None
    text = ""
    for points in _shifted(lines).values():
        rows = "".join(f"  {x / W!r} {y / H!r}\n" for x, y in points)
        text += f"  Shape1\n  a\n  b\n{rows}  Sets = 0\n"
    return text.encode()


def table(lines: Lines, kind: Kind) -> bytes | None:
    if kind == "lines":  # blank rows part the lines
        parts = ("".join(f"{x!r},{y!r}\n" for x, y in points) for points in lines.values())
        return ("x,y\n" + "\n".join(parts)).encode()
    rows = _singly(lines, 0.0)
    if kind == "groups":
        return _table([["x", "y", "Kante"], *([x, y, n] for n, _, x, y in rows)])
    return _table([["line", "x", "y"], *([label, x, y] for _, label, x, y in rows)])


WRITERS: dict[str, Callable[[Lines, Kind], bytes | None]] = {
    "json": own_json,
    "pto": pto,
    "ptgui": ptgui,
    "cvat": cvat,
    "cell-counter": cell_counter,
    "svg": svg,
    "labelme": labelme,
    "via": via,
    "via3": via3,
    "datumaro": datumaro,
    "coco": coco,
    "geojson": geojson,
    "imagej": imagej,
    "wpd-project": wpd_project,
    "webplotdigitizer": webplotdigitizer,
    "napari": napari,
    "makesense": makesense,
    "xlsx": xlsx,
    "winmorph": winmorph,
    "csv": table,
}
"""One a row of the table of formats; a new row needs one here."""

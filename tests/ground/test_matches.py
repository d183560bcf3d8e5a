"""Match points and tapes in the dialects that people have."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from plumbline.errors import ReadError
from plumbline.ground.reading.matches import MOST_POINTS, read_matches
from plumbline.ground.reading.tapes import read_tapes

PICKS = np.array([[412.5, 903.0], [1211.25, 640.5]])
PLACES = np.array([[-1.52, 6.1], [3.25, 17.0]])

DIALECTS = {
    "header": "x,y,X,Y,name\n412.5,903,-1.52,6.1,A\n1211.25,640.5,3.25,17,B\n",
    "bare": "412.5,903,-1.52,6.1,A\n1211.25,640.5,3.25,17,B\n",
    "decimal comma": "x;y;X;Y;name\n412,5;903;-1,52;6,1;A\n1211,25;640,5;3,25;17;B\n",
    "tabs": "x\ty\tX\tY\tname\n412.5\t903\t-1.52\t6.1\tA\n1211.25\t640.5\t3.25\t17\tB\n",
    "blanks": "412.5 903 -1.52 6.1 A\n1211.25 640.5 3.25 17 B\n",
    "mark and comments": "\ufeff# road\nx,y,X,Y,name\n\n412.5,903,-1.52,6.1,A\n"
    "1211.25,640.5,3.25,17,B\n",
    "columns in another order": "name,X,Y,x,y\nA,-1.52,6.1,412.5,903\nB,3.25,17,1211.25,640.5\n",
    "east and north": "id,px,py,Easting,Northing\nA,412.5,903,-1.52,6.1\nB,1211.25,640.5,3.25,17\n",
    "further columns": "x,y,X,Y,name,colour\n412.5,903,-1.52,6.1,A,red\n"
    "1211.25,640.5,3.25,17,B,blue\n",
    "windows": "x,y,X,Y,name\r\n412.5,903,-1.52,6.1,A\r\n1211.25,640.5,3.25,17,B\r\n",
    "QGIS": "#CRS: EPSG:25832\nmapX,mapY,sourceX,sourceY,enable,dX,dY,residual\n"
    "-1.52,6.1,413,-903.5,1,0,0,0\n3.25,17,1211.75,-641,1,0,0,0\n9,9,9,-9,0,0,0,0\n",
    "older QGIS": "mapX,mapY,pixelX,pixelY,enable\n-1.52,6.1,413,-903.5,1\n"
    "3.25,17,1211.75,-641,1\n",
    "Global Mapper": "Name,Pixel X,Pixel Y,Ground X,Ground Y,Error\n"
    "A,413,903.5,-1.52,6.1,0\nB,1211.75,641,3.25,17,0\n",
}


def written(tmp_path: Path, text: str) -> str:
    path = tmp_path / "points.csv"
    path.write_text(text, encoding="utf-8", newline="")
    return str(path)


@pytest.mark.parametrize("text", DIALECTS.values(), ids=DIALECTS.keys())
def test_every_dialect_says_the_same(tmp_path: Path, text: str) -> None:
    found = read_matches(written(tmp_path, text))
    assert np.allclose(found.picks_px, PICKS)
    assert np.allclose(found.places, PLACES)
    assert np.isnan(found.sigmas).all()
    assert found.names in (("A", "B"), ("1", "2"))


def test_utf_16_is_read(tmp_path: Path) -> None:
    path = tmp_path / "points.csv"
    path.write_bytes(DIALECTS["tabs"].encode("utf-16"))
    assert np.allclose(read_matches(str(path)).places, PLACES)


def test_points_that_qgis_has_switched_off_are_said_to_be_left_out(tmp_path: Path) -> None:
    found = read_matches(written(tmp_path, DIALECTS["QGIS"]))
    assert found.notes == ("1 point that QGIS has switched off was left out",)


def test_a_standard_error_of_its_own(tmp_path: Path) -> None:
    found = read_matches(written(tmp_path, "1,2,3,4,A,0.05\n5,6,7,8,B,\n"))
    assert found.sigmas[0] == 0.05
    assert np.isnan(found.sigmas[1])


@pytest.mark.parametrize("text", ["x,y,name\n1,2,A\n3,4,B\n", "1,2,A\n3,4,B\n", "1,2\n3,4\n"])
def test_points_may_have_no_places(tmp_path: Path, text: str) -> None:
    found = read_matches(written(tmp_path, text))
    assert np.isnan(found.places).all()
    assert found.picks_px.tolist() == [[1, 2], [3, 4]]


BAD = {
    "empty": ("", "empty"),
    "header only": ("x,y,X,Y\n", "no match points"),
    "no columns": ("a,b,c\n1,2,3\n", "no columns x and y"),
    "one coordinate": ("x,y,X\n1,2,3\n", "only one of the columns X and Y"),
    "two columns": ("x,y,X,Y,X\n1,2,3,4,5\n", "two columns are named 'X'"),
    "wide": ("1,2,3,4,A,0.1,7\n", "7 columns"),
    "sigma": ("1,2,3,4,A,-1\n", "standard error must be above 0"),
    "binary": ("x,y\0\n", "binary"),
    "many": ("x,y\n" + "".join(f"{i},1\n" for i in range(MOST_POINTS + 1)), "301 match points"),
    "huge": ("1,2,1e300,4\n", "impossibly large"),
    "underscore": ("x,y,X,Y\n1_0,2,3,4\n", "'1_0' stands where"),
}


@pytest.mark.parametrize(("text", "match"), BAD.values(), ids=BAD.keys())
def test_a_damaged_file_is_refused(tmp_path: Path, text: str, match: str) -> None:
    with pytest.raises(ReadError, match=match):
        read_matches(written(tmp_path, text))


@pytest.mark.parametrize(
    "text",
    [
        "from,to,metres\nA,B,3.5\n",
        "A;B;3,5\n",
        "A\tB\t3.5\t0.02\n",
        "# tapes\n\nA,B,3.5\n",
    ],
)
def test_tapes_are_read_in_every_dialect(tmp_path: Path, text: str) -> None:
    (tape,) = read_tapes(written(tmp_path, text), ["A", "B"], 0.01)
    assert (tape.first, tape.second, tape.metres) == (0, 1, 3.5)
    assert tape.sigma_m == (0.02 if "0.02" in text else 0.01)

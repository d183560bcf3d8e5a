"""Every kind of file a lens can come from."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from plumbline.errors import OptionError, UnsettledError, WriteError
from plumbline.frame import Array, Frame
from plumbline.geometry.lens import Lens
from plumbline.imaging.correct import correction_for
from plumbline.lenses import store
from plumbline.lenses.lookup import find_correction
from plumbline.lenses.request import LensRequest
from plumbline.models import get_model
from plumbline.observations.facts import LensFacts
from plumbline.photos.exif import PhotoFacts
from plumbline.writing.files import export_file
from plumbline.writing.zoom import read_zoom_lens
from tests.lenses.made import calibration, saved
from tests.peers.tools import program, run

SIZE = (2048, 1536)
POINTS = np.random.default_rng(3).uniform((0, 0), (2047, 1535), (200, 2))


@pytest.fixture(autouse=True)
def _empty_store(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))


def shot(size: tuple[int, int] = SIZE, focal_mm: float | None = 8.2, **more: object) -> PhotoFacts:
    camera = str(more.pop("camera", "NIKON E995"))
    known = LensFacts(camera=camera, focal_mm=focal_mm, model=str(more.pop("lens", "")))
    return PhotoFacts(size, known, **({"maker": "NIKON", "model": "E995"} | more))  # type: ignore[arg-type]


def ptlens(size: tuple[int, int], **values: float) -> Lens:
    zero = dict.fromkeys(("a", "b", "c", "d", "e"), 0.0)
    return Lens(get_model("ptlens"), Frame(*size), zero | values)


def same(found: Array, expected: Array, px: float = 1e-9) -> None:
    assert np.max(np.hypot(*(found - expected).T)) <= px


class TestResult:
    """A result JSON."""

    @pytest.mark.parametrize(
        ("model", "values"),
        [
            ("ptlens", {"a": 0.02, "b": -0.06, "c": 0.01, "d": 14.0, "e": -9.0}),
            ("brown", {"k1": 0.05, "k2": -0.01, "k3": 0.002, "p1": 0.001, "p2": -0.002, "d": 5.0}),
            ("division", {"l1": -0.05, "l2": 0.004}),
            ("radial:1,2,3", {"a1": 0.01, "a2": 0.03, "a3": -0.01}),
        ],
    )
    def test_a_photo_of_its_size_gets_its_very_lens(
        self, tmp_path: Path, model: str, values: dict[str, float]
    ) -> None:
        made = calibration(model, coefficients=values)
        found = find_correction(shot(), LensRequest(source=saved(tmp_path / "r.json", made)))
        same(found.undistort(POINTS), made.lens.undistort(POINTS))
        same(found.distort(POINTS), made.lens.distort(POINTS))
        assert "r.json" in found.description

    def test_models_in_focal_lengths_scale_with_the_photo(self, tmp_path: Path) -> None:
        made = calibration("opencv", focal_px=2400.0, k1=-0.2, p1=0.003)
        source = saved(tmp_path / "r.json", made)
        small = find_correction(shot((1024, 768)), LensRequest(source=source))
        half = (POINTS + 0.5) / 2 - 0.5
        same((small.distort(half) + 0.5) * 2 - 0.5, made.lens.distort(POINTS))

    def test_another_focal_length_is_refused_or_warned_of(self, tmp_path: Path) -> None:
        source = saved(tmp_path / "r.json", calibration(b=-0.02))
        with pytest.raises(
            OptionError, match=r"at 10 mm, more than 10 % away from the 8\.2 mm that "
        ):
            find_correction(shot(focal_mm=10.0), LensRequest(source=source))
        notes = find_correction(shot(focal_mm=8.5), LensRequest(source=source)).notes
        assert any("the lens is calibrated at 8.2 mm: corrected as there" in note for note in notes)
        notes = find_correction(shot(focal_mm=None), LensRequest(source=source)).notes
        assert any("focal length is not known" in note for note in notes)
        assert not find_correction(shot(), LensRequest(source=source)).notes

    def test_another_shape_is_asked_about(self, tmp_path: Path) -> None:
        source = saved(tmp_path / "r.json", calibration(b=-0.02))
        with pytest.raises(OptionError, match=r"sides are as 1\.78:1") as error:
            find_correction(shot((1920, 1080)), LensRequest(source=source))
        assert "--full-size" in error.value.hint
        full = LensRequest(source=source, full_size=(1920, 1440))
        wide = find_correction(shot((1920, 1080)), full)
        whole = find_correction(shot((1920, 1440)), LensRequest(source=source))
        points = POINTS / 2
        same(wide.distort(points), whole.distort(points + np.array([0, 180])) - [0, 180])

    def test_another_camera_is_scaled_by_the_crop_factors_or_told(self, tmp_path: Path) -> None:
        source = saved(tmp_path / "r.json", calibration(b=-0.02))
        other = PhotoFacts(SIZE, LensFacts(camera="Other", focal_mm=8.2, crop_factor=2 * 4.843))
        found = find_correction(other, LensRequest(source=source))
        assert any("scaled by the crop factors" in note for note in found.notes)
        # Half the sensor: r counts half as much.
        r = np.array([[1023.5 + 768, 767.5]])
        assert found.distort(r)[0, 0] - 1023.5 == pytest.approx(768 * (1.02 - 0.02 / 4), abs=1e-9)
        silent = PhotoFacts(SIZE, LensFacts(camera="Other", focal_mm=8.2))
        notes = find_correction(silent, LensRequest(source=source)).notes
        assert any("sensors of one size" in note for note in notes)

    def test_a_turned_photo_turns_the_centre(self, tmp_path: Path) -> None:
        made = calibration(b=-0.04, d=20.0, e=-7.0)
        source = saved(tmp_path / "r.json", made)
        turned = shot((1536, 2048), turned=True, orientation=6)
        found = find_correction(turned, LensRequest(source=source))
        upright = np.stack((1535 - POINTS[:, 1], POINTS[:, 0]), axis=-1)
        expected = made.lens.distort(POINTS)
        same(found.distort(upright), np.stack((1535 - expected[:, 1], expected[:, 0]), axis=-1))
        unknown = find_correction(shot((1536, 2048)), LensRequest(source=source))
        assert any("which side was up" in note for note in unknown.notes)

    def test_of_several_the_one_that_names_the_photo(self, tmp_path: Path) -> None:
        path = tmp_path / "r.json"
        one = calibration(b=-0.02, name="one.jpg", focal_mm=None)
        two = calibration(b=-0.04, name="two.jpg", focal_mm=None)
        saved(path, one, two)
        found = find_correction(shot(name="TWO.JPG"), LensRequest(source=str(path)))
        same(found.distort(POINTS), two.lens.distort(POINTS))
        first = find_correction(shot(name="x.jpg"), LensRequest(source=str(path)))
        same(first.distort(POINTS), one.lens.distort(POINTS))
        assert any("does not name this photo" in note for note in first.notes)

    def test_of_several_the_one_at_the_focal_length(self, tmp_path: Path) -> None:
        path = tmp_path / "r.json"
        one, two = calibration(b=-0.02, focal_mm=8.2), calibration(b=-0.04, focal_mm=12.0)
        saved(path, one, two)
        found = find_correction(shot(focal_mm=12.1), LensRequest(source=str(path)))
        same(found.distort(POINTS), two.lens.distort(POINTS))


PTO = """# hugin project file
#hugin_ptoversion 2
p f2 w3000 h1500 v360 n"TIFF_m c:LZW r:CROP"
i w2048 h1536 f0 v50 Ra0 r0 p0 y0 a0.01 b-0.05 c0.02 d12 e-8 g0 t0 n"left.jpg"
i w2048 h1536 f0 v=0 r0 p0 y30 a=0 b=0 c=0 d=0 e=0 g0 t0 n"right.jpg"
i w1536 h2048 f0 v40 r0 p0 y60 a0 b-0.01 c0 d0 e0 g0 t0 n"C:\\photos\\tall.jpg"
c n0 N1 x1 y2 X3 Y4 t0
"""


class TestProject:
    """The lens values of a stitched panorama."""

    @pytest.fixture
    def pto(self, tmp_path: Path) -> str:
        path = tmp_path / "pano.pto"
        path.write_text(PTO)
        return str(path)

    def test_the_photo_is_found_by_name(self, pto: str) -> None:
        found = find_correction(shot((1536, 2048), name="tall.jpg"), LensRequest(source=pto))
        same(found.distort(POINTS), ptlens((1536, 2048), b=-0.01).distort(POINTS))
        linked = find_correction(shot(name="right.jpg"), LensRequest(source=pto))
        values = {"a": 0.01, "b": -0.05, "c": 0.02, "d": 12.0, "e": -8.0}
        same(linked.distort(POINTS), ptlens(SIZE, **values).distort(POINTS))

    def test_else_the_first_image_counts_and_that_is_said(self, pto: str) -> None:
        found = find_correction(shot(name="new.jpg"), LensRequest(source=pto))
        assert "a = 0.01" in found.description
        assert any("does not name this photo" in note for note in found.notes)

    def test_pano_trafo_sends_points_to_the_same_place(self, tmp_path: Path, pto: str) -> None:
        trafo = program("pano_trafo")
        found = find_correction(shot(name="left.jpg"), LensRequest(source=pto))
        # A rectilinear panorama with the photo's own field of view shows the ideal picture.
        script = tmp_path / "same.pto"
        script.write_text(
            PTO.replace("p f2 w3000 h1500 v360", "p f0 w2048 h1536 v50").partition("i w1536")[0]
        )
        text = "".join(f"{x} {y}\n" for x, y in POINTS)
        theirs = [
            [float(v) for v in row.split()]
            for row in run([trafo, str(script), "0"], text).splitlines()
        ]
        same(found.undistort(POINTS), np.array(theirs), 2e-3)  # it stops so early

    def test_ptgui_keeps_its_values_in_the_dummy(self, tmp_path: Path) -> None:
        path = tmp_path / "pano.pts"
        path.write_text(
            "# ptGui project file\n#-fileversion 25\n#-dummyimage\n"
            "o w1 h1 y0 r0 p0 v52 a0.03 b-0.1 c0.05 f0 d4 e3 g0 t0\n"
            '#-imgfile 2048 1536 "x.jpg"\n'
            "o f0 y0 r0 p0 v=0 a=0 b=0 c=0 d=0 e=0 g=0 t=0\n"
        )
        found = find_correction(shot(name="x.jpg"), LensRequest(source=str(path)))
        expected = ptlens(SIZE, a=0.03, b=-0.1, c=0.05, d=4.0, e=3.0)
        same(found.distort(POINTS), expected.distort(POINTS))

    def test_a_c_crop_measures_in_what_it_leaves(self, tmp_path: Path) -> None:
        """The same rays: libpano's radius of half the cropped square, a scale apart."""
        path = tmp_path / "crop.pto"
        path.write_text(
            "# hugin project file\n"
            'i w2048 h1536 f0 v50 a0.01 b-0.05 c0.02 d0 e0 C256,1792,0,1536 n"x.jpg"\n'
            'i w2048 h1536 f0 v50 a0.01 b-0.05 c0.02 d0 e0 C-256,2304,-512,2048 n"y.jpg"\n'
        )
        same_circle = find_correction(shot(name="x.jpg"), LensRequest(source=str(path)))
        same(same_circle.distort(POINTS), ptlens(SIZE, a=0.01, b=-0.05, c=0.02).distort(POINTS))
        wider = find_correction(shot(name="y.jpg"), LensRequest(source=str(path)))
        r = (POINTS - [1023.5, 767.5]) / 1280
        length = np.hypot(*r.T)[:, None]
        observed = r * (0.01 * length**3 - 0.05 * length**2 + 0.02 * length + 1.02) * 1280
        back = wider.undistort(observed + np.array([1023.5, 767.5])) - [1023.5, 767.5]
        ratio = np.hypot(*back.T) / np.hypot(*(POINTS - [1023.5, 767.5]).T)
        assert np.ptp(ratio) < 1e-9

    def test_a_fisheye_is_told(self, tmp_path: Path) -> None:
        path = tmp_path / "fish.pto"
        path.write_text(PTO.replace("h1536 f0 v50", "h1536 f3 v50"))
        notes = find_correction(shot(name="left.jpg"), LensRequest(source=str(path))).notes
        assert any("full-frame fisheye" in note for note in notes)


PROFILE = """begin camera
menu_make: Nikon
menu_model: Coolpix 995
exif_make: NIKON
exif_model: E995
group: nikon995
multiplier: 4.843
end
begin camera
menu_make: Other
menu_model: One
exif_make: OTHER
exif_model: ONE
group: nikon995
multiplier: 6.0
end
begin lens
menu_lens: Standard
group: nikon995
multiplier: 4.843
cal_abc: 8.2 0 -0.019966 0
cal_abc: 10.1 0.001 -0.010931 0.002
end
begin lens
menu_lens: Fisheye converter
group: nikon995
multiplier: 4.843
converter_factor: 0.63
cal_abc: 8.2 0.0177 -0.0578 0
end
"""


class TestPTLens:
    """PTLens profiles."""

    @pytest.fixture
    def profile(self, tmp_path: Path) -> str:
        (tmp_path / "nikon.txt").write_text(PROFILE)
        index = tmp_path / "profile.txt"
        index.write_text("version: 4.2\nfile: nikon.txt\n")
        return str(index)

    def test_linear_between_focal_lengths(self, profile: str) -> None:
        found = find_correction(shot(focal_mm=9.15), LensRequest(source=profile))
        expected = ptlens(SIZE, a=0.0005, b=-0.0154485, c=0.001)
        same(found.distort(POINTS), expected.distort(POINTS))
        assert any("Fisheye converter" in note for note in found.notes) is False

    def test_the_converter_is_left_aside_and_said(self, profile: str) -> None:
        found = find_correction(shot(), LensRequest(source=profile))
        assert "Standard on Nikon Coolpix 995 at 8.2 mm" in found.description
        assert any("Fisheye converter" in note for note in found.notes)
        named = find_correction(shot(), LensRequest(source=profile, lens_name="Fisheye converter"))
        assert "a = 0.0177" in named.description

    def test_another_sensor_takes_powers_of_the_multipliers(self, profile: str) -> None:
        request = LensRequest(source=profile, camera="Other One", focal_mm=10.1)
        found = find_correction(shot(), request)
        k = 4.843 / 6.0
        expected = ptlens(SIZE, a=0.001 * k**3, b=-0.010931 * k**2, c=0.002 * k)
        same(found.distort(POINTS), expected.distort(POINTS))

    def test_out_of_range(self, profile: str) -> None:
        notes = find_correction(shot(focal_mm=10.9), LensRequest(source=profile)).notes
        assert any("corrected as at 10.1 mm" in note for note in notes)
        with pytest.raises(OptionError, match=r"out of the calibrated range of Standard"):
            find_correction(shot(focal_mm=12.0), LensRequest(source=profile))

    def test_unknown_camera(self, profile: str) -> None:
        unknown = PhotoFacts(SIZE, LensFacts(camera="X Y"), maker="X", model="Y")
        with pytest.raises(OptionError, match="the camera X Y is not in"):
            find_correction(unknown, LensRequest(source=profile))
        found = find_correction(
            unknown, LensRequest(source=profile, like="nikon e995", focal_mm=8.2)
        )
        assert any("X Y is treated like the Nikon Coolpix 995" in note for note in found.notes)


def test_hugin_lens_file(tmp_path: Path) -> None:
    path = tmp_path / "lens.ini"
    path.write_text(
        "[Lens]\nimage_width=2048\nimage_height=1536\ntype=0\nhfov=50\nhfov_link=1\ncrop=4.843\n"
        "a=0.01\na_link=1\nb=-0.05\nb_link=1\nc=0.02\nc_link=1\nd=3\ne=-2\ng=0\nt=0\n"
        "[EXIF]\nCameraMake=NIKON\nCameraModel=E995\nFocalLength=8.2\n"
    )
    found = find_correction(shot(), LensRequest(source=str(path)))
    expected = ptlens(SIZE, a=0.01, b=-0.05, c=0.02, d=3.0, e=-2.0)
    same(found.distort(POINTS), expected.distort(POINTS))
    with pytest.raises(OptionError, match=r"from the 8\.2 mm that .*lens.ini is calibrated at"):
        find_correction(shot(focal_mm=20.0), LensRequest(source=str(path)))


class TestStore:
    """The user's own calibrations."""

    def test_they_come_before_lensfun_s(self, tmp_path: Path) -> None:
        made = calibration(b=-0.123)
        written = store.add(saved(tmp_path / "r.json", made))
        assert written.is_relative_to(tmp_path / "data" / "plumbline")
        found = find_correction(shot(), LensRequest())
        assert "b = −0.123" in found.description
        same(found.distort(POINTS), made.lens.distort(POINTS))

    def test_another_focal_length_goes_to_lensfun_and_says_so(self, tmp_path: Path) -> None:
        store.add(saved(tmp_path / "r.json", calibration(b=-0.123)))
        found = find_correction(shot(focal_mm=18.4), LensRequest())
        assert "LensFun's database" in found.description
        assert any("your own calibrations of this camera, at 8.2 mm" in n for n in found.notes)

    def test_the_nearest_of_several(self, tmp_path: Path) -> None:
        for focal_mm, b in ((8.2, -0.12), (8.9, -0.11)):
            store.add(saved(tmp_path / "r.json", calibration(b=b, focal_mm=focal_mm)))
        assert "b = −0.11" in find_correction(shot(focal_mm=8.8), LensRequest()).description

    def test_which_of_several_lenses_is_asked(self, tmp_path: Path) -> None:
        for lens, focal_mm in (("Tele", 8.2), ("Wide", 8.4)):
            store.add(saved(tmp_path / "r.json", calibration(lens=lens, focal_mm=focal_mm)))
        with pytest.raises(OptionError, match="of several match: Tele, Wide") as error:
            find_correction(shot(), LensRequest())
        assert "--lens-name" in error.value.hint
        assert "Wide" in find_correction(shot(), LensRequest(lens_name="Wide")).description

    def test_none_is_replaced_silently(self, tmp_path: Path) -> None:
        source = saved(tmp_path / "r.json", calibration(b=-0.123))
        store.add(source)
        with pytest.raises(WriteError, match="already"):
            store.add(source)
        store.add(source, overwrite=True)

    def test_a_calibration_that_nothing_could_find_is_refused(self, tmp_path: Path) -> None:
        with pytest.raises(OptionError, match="does not name its camera"):
            store.add(saved(tmp_path / "r.json", calibration(camera="")))
        with pytest.raises(OptionError, match="does not give its focal length"):
            store.add(saved(tmp_path / "r.json", calibration(focal_mm=None)))

    def test_damaged_ones_are_left_aside_and_said(self, tmp_path: Path) -> None:
        folder = store.folder()
        folder.mkdir(parents=True)
        (folder / "bad.json").write_text("{")
        found = find_correction(shot(), LensRequest())
        assert any("of your own was left aside" in note for note in found.notes)

    def test_another_lens_of_the_camera_is_not_meant(self, tmp_path: Path) -> None:
        store.add(saved(tmp_path / "r.json", calibration(b=-0.123, lens="Tele")))
        assert "LensFun" in find_correction(shot(lens="Wide"), LensRequest()).description


def test_a_fit_without_a_result_is_used_nowhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    made = replace(calibration(b=-0.02), converged=False, reason="no minimum in 100 steps")
    path = saved(tmp_path / "r.json", made)
    sentence = "the fit did not converge: no minimum in 100 steps"
    for use in (
        lambda: find_correction(shot(), LensRequest(source=path)),
        lambda: store.add(path),
        lambda: export_file(path, "pto", None, None, {}),
        lambda: export_file(path, "json", None, None, {}),
        lambda: read_zoom_lens([path], "linear", 1, {}),
        lambda: correction_for(shot(), made),
    ):
        with pytest.raises(UnsettledError, match=sentence):
            use()
    store.folder().mkdir(parents=True)
    (store.folder() / "old.json").write_bytes(Path(path).read_bytes())
    found = find_correction(shot(), LensRequest())
    assert "LensFun" in found.description
    assert any(sentence in note for note in found.notes)


@pytest.mark.parametrize("crop", [1.5, None])
def test_a_project_of_another_focal_length_is_refused(tmp_path: Path, crop: float | None) -> None:
    """A field of view of 67.4 degrees on a crop factor of 1.5 is 18 mm, by the diagonal."""
    width, height = 3000, 2000
    diagonal_mm = float(np.hypot(36, 24)) / 1.5
    half = width / 2 / np.hypot(width, height) * diagonal_mm
    v = float(np.degrees(2 * np.arctan(half / 18)))
    path = tmp_path / "a.pto"
    path.write_text(
        f'# hugin project file\np f0 w{width} h{height} v{v:.6f} n"TIFF_m"\n'
        f'i w{width} h{height} f0 v{v:.6f} a0 b-0.02 c0 d0 e0 n"other.jpg"\n'
    )

    def photo_at(focal_mm: float) -> PhotoFacts:
        facts = LensFacts(camera="Nikon D7100", focal_mm=focal_mm, crop_factor=crop)
        return PhotoFacts((width, height), facts, maker="NIKON CORPORATION", model="NIKON D7100")

    request = LensRequest(source=str(path))
    assert find_correction(photo_at(18), request).size == (width, height)
    with pytest.raises(OptionError, match=r"taken at 105 mm, more than 10 % away from the 1[78]"):
        find_correction(photo_at(105), request)


def test_a_calibration_of_another_lens_is_refused(tmp_path: Path) -> None:
    made = calibration(b=-0.02, lens="AF-S DX Nikkor 18-55mm f/3.5-5.6G VR")
    request = LensRequest(source=saved(tmp_path / "r.json", made))

    def named(lens: str, range_mm: tuple[float, float] | None = None) -> PhotoFacts:
        facts = LensFacts(camera="NIKON E995", model=lens, focal_mm=8.2, crop_factor=4.843)
        return PhotoFacts((2048, 1536), facts, lens_range_mm=range_mm)

    with pytest.raises(OptionError, match=r"is of the lens .*18-55mm.*, the photo of .*50mm") as e:
        find_correction(named("AF-S Nikkor 50mm f/1.8G"), request)
    assert "--lens-name" in e.value.hint
    with pytest.raises(OptionError, match="the photo of one of 70 to 200 mm"):
        find_correction(named("", (70.0, 200.0)), request)
    other = find_correction(named("18.0-55.0 mm f/3.5-5.6"), request)
    assert any("taken as one" in note for note in other.notes)
    same = find_correction(named("AF-S DX Nikkor 18-55mm f/3.5-5.6G VR"), request)
    assert not any("taken as one" in note for note in same.notes)
    told = LensRequest(source=request.source, lens_name=made.observations.lenses[0].model)
    find_correction(named("AF-S Nikkor 50mm f/1.8G"), told)

"""The page: whole, self-contained, the same every time, and text is nothing but text."""

from __future__ import annotations

import hashlib
import re
import subprocess
import sys
from collections import Counter
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from lxml import html  # pyright: ignore[reportAttributeAccessIssue]

from plumbline.models import MODELS
from plumbline.report.figures import FIGURES
from plumbline.report.page.document import Assignment, Part, page_bytes
from plumbline.report.page.markup import document, table, tag
from plumbline.report.photos import find_photos
from plumbline.result.calibration import Calibration
from plumbline.result.comparison import Candidate, Comparison
from plumbline.trust.check import Check
from tests.report.made import BUILDING, SCRIPT, building, hostile, without_a_line

ROOT = Path(__file__).parents[3]


@cache
def page(made: Calibration, compared: Comparison | None = None) -> bytes:
    (found,) = find_photos([made], None)
    return page_bytes([Part(made, found, compared)], Assignment())


def parsed(content: bytes) -> Any:
    return html.fromstring(content.decode())


def text(element: Any) -> str:
    return " ".join(element.text_content().split())


@cache
def compared() -> Comparison:
    """Three models side by side, one of which failed."""
    made = building()
    return Comparison(
        (
            Candidate(
                f"ptlens b {SCRIPT}", ("poly3",), "ptlens", ("b",), made, "", 12.5, 0.5, 0.25
            ),
            Candidate("ptlens a, b, c", (), "ptlens", ("a", "b", "c"), made, "", 3.25, 0.4, 0.0),
            Candidate("division l1, l2", (), "division", ("l1", "l2"), None, "it did not settle"),
        ),
        best=1,
        recommended=0,
        reason=f"b alone is enough, {SCRIPT}",
        centre="the centre is left where it is",
    )


@pytest.mark.parametrize("robust", [False, True])
def test_text_from_files_does_nothing(robust: bool) -> None:
    content = page(hostile(robust=robust), compared())
    root = parsed(content)
    assert not root.xpath("//script")
    assert not root.xpath("//@*[starts-with(name(), 'on')]")
    assert b"<script" not in content.lower()
    assert text(root).count("<script>alert(1)</script>") > 10
    assert "\x00" not in content.decode()


def test_nothing_is_fetched() -> None:
    root = parsed(page(building(), compared()))
    for element in root.iter():
        for name, value in element.attrib.items():
            if name.rpartition("}")[2].rpartition(":")[2] in ("href", "src", "srcset", "data"):
                assert value.startswith(("#", "data:image/")), value[:80]
            assert not re.search(r"url\((?!#)", value)
    style = root.xpath("//style")
    assert len(style) == 1
    assert "url(" not in style[0].text
    assert "@import" not in style[0].text
    assert not root.xpath("//link | //iframe | //object | //embed | //base")


def test_every_reference_leads_to_one_element() -> None:
    content = page(building()).decode()
    ids = Counter(parsed(content.encode()).xpath("//@id"))
    assert ids
    assert max(ids.values()) == 1
    for name in re.findall(r'(?:href="#|url\(#)([^")]+)', content):
        assert name in ids


def test_the_same_input_gives_the_same_bytes() -> None:
    program = (
        "import sys\nfrom tests.report.page.test_document import page\n"
        "from tests.report.made import hostile"
        "\nsys.stdout.buffer.write(page(hostile(robust=True)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, capture_output=True, check=True
    )
    assert done.stdout == page(hostile(robust=True))


def test_it_says_who_made_it_near_its_head() -> None:
    assert b"made by plumbline" in page(building())[:1024]


def test_the_order_of_its_content() -> None:
    root = parsed(page(building(), compared()))
    titles = [text(title) for title in root.xpath("//h3")]
    assert titles == [
        "Coefficients",
        "Correlations",
        "Straightness of the lines",
        "Suspicious picks",
        "Checks",
        "Models compared",
        "Limits",
        "Notes",
        "How it was made",
        "Picks",
    ]
    captions = [text(caption) for caption in root.xpath("//figcaption")]
    assert [c.partition(".")[0] for c in captions] == [
        f"Figure {n}" for n in range(1, len(FIGURES) + 1)
    ]
    first = root.xpath("//section/*")[0]
    assert text(first).startswith("Barrel distortion: −6.38 % (−92.4 px) at the corner")
    quote = text(root.xpath("//*[@class='quote']")[0])
    assert quote.startswith("Verdict: usable: the correction is uncertain by at most")
    assert "all 11 checks passed" in quote


def rows(root: Any, title: str) -> list[list[str]]:
    found = root.xpath(f"//h3[.='{title}']/following-sibling::div[1]//tr")
    return [[text(cell) for cell in row] for row in found]


def test_the_tables_hold_what_was_fitted() -> None:
    made = building()
    root = parsed(page(made))
    coefficients = rows(root, "Coefficients")
    a = coefficients[1]
    assert a[:4] == ["a", "0.005925", "0", "± 0.001651"]
    low, high = made.intervals["a"]
    assert a[4] == f"{low:.6f} … {high:.6f}"
    assert coefficients[4][:3] == ["d", "0.000 px", "held"]
    correlations = rows(root, "Correlations")
    assert correlations[0] == ["", "a", "b", "c"]
    assert correlations[1] == ["a", "+1.000", "−0.993", "+0.965"]
    lines = rows(root, "Straightness of the lines")
    assert lines[1] == ["t3", "10", "6.69", "0.49", "0.77"]
    assert len(lines) == 1 + len(made.lines)


def test_every_suspect_is_listed_with_its_residual() -> None:
    for robust, fate in ((True, "left out"), (False, "kept; --robust would leave it out")):
        made = hostile(robust=robust)
        out = [each for each in made.suspects if each.left_out]
        assert len(out) >= 3
        listed = rows(parsed(page(made)), "Suspicious picks")[1:]
        assert len(listed) == len(made.suspects)
        for row, suspect in zip(listed, made.suspects, strict=True):
            assert suspect.sentence in row[0]
            assert row[1] == f"{suspect.residual_px:.2f}"
            assert row[3] == (fate if suspect.left_out else "kept")
    # The picks that were moved, by 9, 11 and 8 px.
    wrong = sorted(
        (each.line, each.picks) for each in hostile(robust=True).suspects if each.left_out
    )
    assert wrong == [(0, (3,)), (3, (5,)), (6, (2,))]


def test_checks_come_with_their_remedies() -> None:
    made = building()
    bad = Check("radius", False, "the picks end early", f"pick more {SCRIPT}")
    good = Check("points", True, "enough of them")
    doubtful = Check("corners", True, "two are bare", doubtful=True)
    made = replace(made)
    made.__dict__["checks"] = (good, doubtful, bad)
    listed = rows(parsed(page(made)), "Checks")
    assert listed[1] == ["points", "✓ good", "enough of them"]
    assert listed[2] == ["corners", "? doubtful", "two are bare"]
    assert listed[3] == ["radius", "✗ bad", f"the picks end early→ pick more {SCRIPT}"]


def test_doubtful_and_bad_checks_are_told_apart_by_colour_in_light_and_dark() -> None:
    made = replace(building())
    made.__dict__["checks"] = (Check("a", True, "b", doubtful=True), Check("c", False, "d", "e"))
    text = page(made).decode()
    assert '<span class="doubtful">? doubtful</span>' in text
    assert '<span class="bad">✗ bad</span>' in text
    names = [
        re.findall(rf"^\.{kind} {{ color: var\((.*?)\)", text, re.MULTILINE)
        for kind in ("doubtful", "bad")
    ]
    colours = [re.findall(rf"{name}: (#\w+);", text) for (name,) in names]
    assert all(len(light_and_dark) == 2 for light_and_dark in colours)
    assert not set(colours[0]) & set(colours[1])


def test_a_line_left_out_as_a_whole_has_no_straightness() -> None:
    lines = rows(parsed(page(without_a_line())), "Straightness of the lines")
    assert lines[5] == ["5", "0", "9", "left out", "", ""]
    assert lines[8][:3] == ["8", "8", "1"]
    assert float(lines[8][4]) < 0.5


def test_the_models_are_compared() -> None:
    root = parsed(page(building(), compared()))
    table = rows(root, "Models compared")
    assert table[0][:2] == ["model", "coefficients"]
    assert table[1][0] == f"ptlens b {SCRIPT}= poly3"
    assert table[1][1].startswith("a ")
    assert table[1][3:6] == ["+9.2", "0.500", "0.25"]
    assert table[3][1:3] == ["it did not settle", "no fit"]
    sentences = text(root.xpath("//h3[.='Models compared']/following-sibling::p[1]")[0])
    assert sentences.startswith(f"Recommended: ptlens b {SCRIPT}. b alone is enough")
    assert sentences.endswith(".")
    values = root.xpath("//h3[.='Models compared']/following::table[1]//tr[2]/td[2]/div/div")
    assert [text(each)[:2] for each in values] == ["a ", "b ", "c "]


def test_how_it_was_made() -> None:
    made = replace(building(), command="plumbline fit 'my building.pto'")
    root = parsed(page(made))
    terms = root.xpath("//dl/dt")
    told = {text(term): text(term.getnext()) for term in terms}
    assert told["command"] == "plumbline fit 'my building.pto'"
    assert hashlib.sha256(BUILDING.read_bytes()).hexdigest() in told["points"]
    photo = BUILDING.parent / "facade.jpg"
    assert hashlib.sha256(photo.read_bytes()).hexdigest() in told["photo"]
    assert "facade.jpg, 2256 × 1504 px" in told["photo"]
    assert "r_obs = r (a r³ + b r² + c r + 1 − a − b − c)" in told["model"]
    assert "Dersch" in told["model"]
    assert told["residuals"].endswith("(image)")


def test_an_expert_finds_who_what_and_when() -> None:
    made = building()
    (photo,) = made.observations.photos
    shot = replace(photo, taken="2021:06:12 10:24:31", serial="0730412345")
    made = replace(made, observations=replace(made.observations, photos=(shot,)))
    (found,) = find_photos([made], None)
    root = parsed(page_bytes([Part(made, found)], Assignment("2026/17", f"A. {SCRIPT}")))
    told = {text(term): text(term.getnext()) for term in root.xpath("//dl/dt")}
    assert told["Case"] == "2026/17"
    assert told["Examiner"] == f"A. {SCRIPT}"
    assert told["serial number"] == "0730412345"
    assert "taken 2021:06:12 10:24:31 (EXIF)" in told["photo"]
    assert told["camera"] == "Canon EOS 450D"
    limits = text(root.xpath("//h3[.='Limits']/following-sibling::ul")[0])
    assert "focused as for facade.jpg" in limits
    assert "the picks reach" in limits.casefold()


def test_every_pick_is_listed_and_nothing_is_said_twice() -> None:
    made = without_a_line()
    root = parsed(page(made))
    cells = root.xpath("//*[@class='picks']//tbody/tr")
    assert len(cells) == made.observations.n_points
    out = [row for row in cells if text(row).endswith("left out")]
    assert len(out) == sum(int((~kept).sum()) for kept in made.kept)
    notes = [text(note) for note in root.xpath("//h3[.='Notes']/following-sibling::ul[1]/li")]
    assert not {check.sentence for check in made.checks} & set(notes)


def test_a_model_that_fits_better_is_named_in_the_verdict() -> None:
    made = building()
    simple = Candidate("ptlens b", (), "ptlens", ("b",), made, "", 1.0, 0.5, 0.2)
    own = Candidate("ptlens a, b, c", (), "ptlens", ("a", "b", "c"), made, "", 9.0, 0.4, 0.0)
    root = parsed(page(made, Comparison((simple, own), 0, 0, "it is enough", quote="quote 9")))
    verdict = text(root.xpath("//*[@class='quote']")[0])
    assert "; ptlens b follows the picks better (AICc lower by 8)" in verdict
    assert "quote 9" not in text(root)  # it is not the error of the model that was fitted
    root = parsed(page(made, Comparison((simple, own), 1, 1, "it is enough", quote="quote 9")))
    assert "better" not in text(root.xpath("//*[@class='quote']")[0])
    assert "quote 9" in text(root)


def test_every_model_names_its_source() -> None:
    for model in MODELS.values():
        assert model.source


def test_a_page_without_the_photo_says_so() -> None:
    root = parsed(page(hostile()))
    assert "was not found and is not shown" in text(root)
    assert "The photo itself is not at hand" in text(root.xpath("//figcaption")[0])
    assert not root.xpath("//*[local-name()='image']")


def test_the_photo_is_a_jpeg_within_the_page() -> None:
    images = parsed(page(building())).xpath("//*[local-name()='image']")
    links = [v for image in images for k, v in image.attrib.items() if k.endswith("href")]
    assert len(links) == 2  # as photographed, and corrected
    assert all(link.startswith("data:image/jpeg;base64,") for link in links)


def test_several_lenses_get_a_section_each() -> None:
    made = [building(), hostile()]
    found = find_photos(made, None)
    root = parsed(page_bytes([Part(m, f) for m, f in zip(made, found, strict=True)], Assignment()))
    assert text(root.xpath("//h1")[0]) == "Lens calibration: 2 lenses"
    assert [text(t) for t in root.xpath("//section/h2")] == [
        "facade.jpg at 18 mm",
        f"{SCRIPT}.jpg",
    ]
    captions = root.xpath("//figcaption/b")
    assert [text(c) for c in captions] == [f"Figure {n}." for n in range(1, 2 * len(FIGURES) + 1)]


def test_markup_keeps_strings_text() -> None:
    made = document(tag("head"), tag("body", "a<b>&", tag("i", "<u>"), "\x1b[0m", None, id='"x>'))
    root = parsed(made)
    assert text(root) == "a<b>&<u>�[0m"
    assert root.xpath("//body/@id") == ['"x>']
    cells = parsed(document(tag("head"), tag("body", table(("<h>", "n"), [["<c>", "1"]]))))
    assert [text(c) for c in cells.xpath("//th | //td")] == ["<h>", "n", "<c>", "1"]

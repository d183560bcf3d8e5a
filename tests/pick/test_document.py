"""Documents: undoing and redoing without limit, and what is refused."""

from __future__ import annotations

import msgspec
import pytest
from hypothesis import given, strategies as st

from plumbline.errors import OptionError
from plumbline.observations.facts import LensFacts
from plumbline.pick import requests
from plumbline.pick.document import FORMAT, VERSION, Document, PhotoRecord, PickedLine, Proposal
from plumbline.pick.editing import Editor, Traced

EMPTY = Document(FORMAT, VERSION, (PhotoRecord("a.jpg", (600, 400)),))
FREE = Editor(None)

places = st.tuples(st.floats(0, 599), st.floats(0, 399))
draws = st.lists(places, min_size=1, max_size=5).map(
    lambda clicks: requests.Draw(0, tuple(clicks), snap=False)
)


def drawn(document: Document, *lines: tuple[tuple[float, float], ...]) -> Document:
    for clicks in lines:
        document = FREE.edited(document, requests.Draw(0, clicks, snap=False), None).document
    return document


@st.composite
def histories(draw: st.DrawFn) -> list[Document]:
    """Documents one action apart, of all kinds of actions."""
    found = [EMPTY]
    for _ in range(draw(st.integers(1, 12))):
        document = found[-1]
        kind = draw(st.sampled_from(["draw", "move", "extend", "remove", "click"]))
        request: requests.Request = draw(draws)
        if document.lines and kind != "draw":
            line = draw(st.sampled_from(document.lines))
            index = draw(st.integers(0, len(line.clicks) - 1))
            request = {
                "move": requests.Move(line.number, index, draw(places)),
                "extend": requests.Extend(line.number, draw(places)),
                "remove": requests.Remove(line.number),
                "click": requests.Remove(line.number, index),
            }[kind]
        found.append(FREE.edited(document, request, None).document)
    return found


@given(histories())
def test_undo_and_redo_walk_through_all_that_was(found: list[Document]) -> None:
    document = found[-1]
    for before in reversed(found[:-1]):
        document = FREE.edited(document, requests.Undo(), None).document
        assert document.lines == before.lines
    assert not document.done
    for after in found[1:]:
        document = FREE.edited(document, requests.Redo(), None).document
        assert document.lines == after.lines
    assert document == found[-1]


@given(histories())
def test_documents_survive_their_file(found: list[Document]) -> None:
    document = FREE.edited(found[-1], requests.Undo(), None).document
    again = msgspec.json.decode(msgspec.json.encode(document), type=Document)
    assert again == document
    assert not again.problem()


def test_a_new_action_ends_what_could_be_redone() -> None:
    document = drawn(EMPTY, ((1.0, 2.0),), ((3.0, 4.0),)).before_last()
    after = drawn(document, ((5.0, 6.0),))
    assert after.after_next() == after
    assert [line.number for line in after.lines] == [1, 3]  # numbers are given once


def test_nothing_to_undo_changes_nothing() -> None:
    assert EMPTY.before_last() == EMPTY
    assert EMPTY.after_next() == EMPTY


def test_a_click_goes_to_its_place_along_the_line() -> None:
    document = drawn(EMPTY, ((10.0, 10.0), (200.0, 20.0), (400.0, 10.0)))
    extended = FREE.edited(document, requests.Extend(1, (300.0, 17.0)), None).document
    assert [x for x, _ in extended.line(1).clicks] == [10, 200, 300, 400]
    extended = FREE.edited(document, requests.Extend(1, (5.0, 9.0)), None).document
    assert [x for x, _ in extended.line(1).clicks] == [5, 10, 200, 400]


@pytest.mark.parametrize(
    "request_",
    [
        requests.Draw(1, ((1.0, 1.0),), snap=False),
        requests.Draw(0, ((1.0, 400.0),), snap=False),
        requests.Draw(0, ((-1.0, 1.0),), snap=False),
        requests.Move(9, 0, (1.0, 1.0)),
        requests.Remove(9),
        requests.Accept((0,)),
        requests.Reject(0),
        requests.Set("nonsense", None, 1.0),
        requests.Set("ptlens", ("z",), 1.0),
        requests.Set("ptlens", (), 1.0),
    ],
)
def test_what_is_not_there_is_refused(request_: requests.Request) -> None:
    with pytest.raises(OptionError):
        FREE.edited(EMPTY, request_, None)


def traced(points: int, *, refusal: str = "", rivals: int = 0, doubt: str = "") -> Editor:
    def tracer(photo: int, clicks: object, lens: object, rival: int) -> Traced:
        if refusal:
            return Traced(refusal=refusal)
        samples = tuple((10.0 + x, 20.0 + rival) for x in range(points))
        return Traced(samples, (0.1,) * points, rivals, doubt=doubt)

    return Editor(tracer)


def test_two_clicks_trace_a_line() -> None:
    editor = traced(8, rivals=2)
    request = requests.Draw(0, ((10.0, 21.0), (17.0, 19.0)), snap=True)
    document = editor.edited(EMPTY, request, None).document
    line = document.line(1)
    assert line.snapped
    assert len(line.points) == len(line.errors) == 8
    assert line.clicks == request.clicks
    for step, rival in ((1, 1), (1, 2), (1, 0), (-1, 2)):
        document = editor.edited(document, requests.Rival(1, step), None).document
        assert document.line(1).rival == rival
        assert document.line(1).points[0] == (10.0, 20.0 + rival)
    loose = editor.edited(document, requests.Snap(1, on=False), None).document.line(1)
    assert not loose.snapped
    assert loose.points == loose.clicks == request.clicks


def test_a_refused_edge_changes_nothing_and_says_why() -> None:
    request = requests.Draw(0, ((10.0, 21.0), (17.0, 19.0)), snap=True)
    edited = traced(0, refusal="there is no edge").edited(EMPTY, request, None)
    assert edited.document is EMPTY
    assert edited.refusal == "there is no edge"


def test_an_edge_that_is_one_of_two_is_taken_with_a_word() -> None:
    request = requests.Draw(0, ((10.0, 21.0), (17.0, 19.0)), snap=True)
    edited = traced(8, rivals=1, doubt="another is as good").edited(EMPTY, request, None)
    assert edited.document.line(1).rivals == 1
    assert edited.doubt == "another is as good"
    assert not edited.refusal


def test_facts_of_the_lens_are_the_users() -> None:
    known = LensFacts(maker="Canon", crop_factor=1.6, crop_factor_error=0.02)
    document = msgspec.structs.replace(EMPTY, facts=known)
    for crop, error in ((1.6, 0.02), (1.61, None)):
        said = requests.Describe("Canon", "EF 50mm", "Canon EF", 50.0, crop)
        facts = FREE.edited(document, said, None).document.facts
        assert (facts.model, facts.mount, facts.focal_mm) == ("EF 50mm", "Canon EF", 50.0)
        assert (facts.crop_factor, facts.crop_factor_error) == (crop, error)


def test_a_traced_line_with_one_click_left_is_deleted() -> None:
    editor = traced(8)
    request = requests.Draw(0, ((10.0, 21.0), (17.0, 19.0)), snap=True)
    document = editor.edited(EMPTY, request, None).document
    assert not editor.edited(document, requests.Remove(1, 0), None).document.lines


def test_proposals_are_taken_rejected_and_come_back() -> None:
    found = tuple(
        Proposal(n, 0, tuple((float(x), 50.0 * n) for x in (1, 200, 400))) for n in (1, 2, 3)
    )
    editor = Editor(None, found)
    assert editor.proposed(EMPTY) == list(found)
    document = editor.edited(EMPTY, requests.Reject(1), None).document
    document = editor.edited(document, requests.Accept((2, 3)), None).document
    assert [line.points for line in document.lines] == [each.points for each in found[1:]]
    assert not editor.proposed(document)
    assert editor.proposed(document.before_last()) == list(found[1:])
    assert editor.proposed(document.before_last().before_last()) == list(found)
    with pytest.raises(OptionError, match="before"):
        editor.edited(document, requests.Accept((2,)), None)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"format": "other"}, "no picks"),
        ({"version": 2}, "version 2"),
        ({"photos": ()}, "no photo"),
        ({"lines": (PickedLine(1, 3, (), ((1, 1),)),)}, "photo that it does not name"),
        ({"lines": (PickedLine(1, 0, (), ((1, 1e9),)),)}, "outside the photo"),
        ({"lines": (PickedLine(1, 0, (), ((float("nan"), 1),)),)}, "outside the photo"),
        ({"lines": (PickedLine(1, 0, (), ()), PickedLine(1, 0, (), ()))}, "numbered twice"),
    ],
)
def test_damage_is_named(change: dict[str, object], said: str) -> None:
    assert said in msgspec.structs.replace(EMPTY, **change).problem()

"""Picks on disk: read back, never over another file, one program at a time."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import msgspec
import pytest

from plumbline.errors import PlumblineError, ReadError, WriteError
from plumbline.pick.document import FORMAT, VERSION, Document, PhotoRecord
from plumbline.pick.saving import Keeper, picks_beside

DOCUMENT = Document(FORMAT, VERSION, (PhotoRecord("a.jpg", (600, 400)),))


def test_they_lie_beside_the_photo() -> None:
    assert picks_beside("photos/facade.v2.jpg") == Path("photos/facade.v2.plumbline.json")


def test_there_and_back(tmp_path: Path) -> None:
    keeper = Keeper(tmp_path / "a.plumbline.json")
    assert keeper.read() is None
    for document in (DOCUMENT, msgspec.structs.replace(DOCUMENT, next_number=7)):
        keeper.write(document)
        assert keeper.read() == document
    keeper.close()
    assert list(tmp_path.iterdir()) == [keeper.path]


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"{}",
        b'{"format": "other"}',
        b"\xff\xfe",
        b"[" * 100_000,
        msgspec.json.encode(DOCUMENT)[:-9],
        msgspec.json.encode(msgspec.structs.replace(DOCUMENT, version=99)),
        b'{"format": "plumbline picks", "version": 1, "photos": [], "more": 1}',
    ],
)
def test_other_files_and_damaged_ones_are_refused_and_left(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "a.plumbline.json"
    path.write_bytes(content)
    keeper = Keeper(path)
    with pytest.raises(ReadError) as caught:
        keeper.read()
    assert caught.value.hint
    assert path.read_bytes() == content
    keeper.close()


def test_one_program_at_a_time(tmp_path: Path) -> None:
    path = tmp_path / "a.plumbline.json"
    keeper = Keeper(path)
    with pytest.raises(WriteError, match="open in another"):
        Keeper(path)
    keeper.close()
    Keeper(path).close()


def test_a_killed_program_leaves_no_lock(tmp_path: Path) -> None:
    path = tmp_path / "a.plumbline.json"
    program = (
        "import os, sys; from pathlib import Path; from plumbline.pick.saving import Keeper; "
        f"keeper = Keeper(Path({str(path)!r})); os.kill(os.getpid(), 9)"
    )
    done = subprocess.run([sys.executable, "-c", program], check=False, timeout=60)
    assert done.returncode == -9
    Keeper(path).close()


def test_what_another_program_wrote_is_not_overwritten(tmp_path: Path) -> None:
    keeper = Keeper(tmp_path / "a.plumbline.json")
    keeper.write(DOCUMENT)
    keeper.path.write_text("mine")
    with pytest.raises(WriteError, match="another program changed"):
        keeper.write(DOCUMENT)
    assert keeper.path.read_text() == "mine"
    keeper.path.unlink()
    keeper.write(DOCUMENT)  # what was removed is saved again
    assert keeper.read() == DOCUMENT
    keeper.close()


def test_a_full_disk_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    keeper = Keeper(tmp_path / "a.plumbline.json")
    keeper.write(DOCUMENT)
    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(PlumblineError, match="No space left") as caught:
        keeper.write(msgspec.structs.replace(DOCUMENT, next_number=9))
    assert "kept on this page" in caught.value.hint
    monkeypatch.undo()
    assert keeper.read() == DOCUMENT
    assert list(tmp_path.iterdir()) == [keeper.path]
    keeper.close()

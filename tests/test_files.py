"""Files: read whole, written atomically, never lost."""

from __future__ import annotations

import os
import threading
from pathlib import Path

import pytest

from plumbline.errors import ReadError, WriteError, printable
from plumbline.files import read_bytes, refuse_to_clobber, write_atomically

FITTED = b'# hugin project file\ni w4 h3 a0.012345678901234567 b0 n"x"\n'


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_bytes_come_as_they_are(folder: Path) -> None:
    content = bytes(range(256)) + b"\r\n\xef\xbb\xbf"
    (folder / "x").write_bytes(content)
    assert read_bytes("x") == content
    assert read_bytes(folder / "x") == content


def test_what_is_no_file_is_refused_with_a_remedy(folder: Path) -> None:
    (folder / "folder").mkdir()
    os.mkfifo(folder / "pipe")
    (folder / "loop").symlink_to("loop")
    (folder / "dangling").symlink_to("nowhere")
    (folder / "file").touch()
    for name, sentence in {
        "nothing.pto": "nothing.pto: there is no such file",
        "folder": "folder: this is a folder, not a file",
        "pipe": "pipe: this is a pipe or a device, not a file",
        "/dev/zero": "/dev/zero: this is a pipe or a device, not a file",
        "loop": "loop: the file cannot be read: Too many levels of symbolic links",
        "dangling": "dangling: there is no such file",
        "file/x": "file/x: the file cannot be read: Not a directory",
        "x" * 300: "x" * 300 + ": the file cannot be read: File name too long",
        "a\0b": "a\0b: the file cannot be read: ",
    }.items():
        with pytest.raises(ReadError) as caught:
            read_bytes(name)
        assert caught.value.message.startswith(sentence)
        assert caught.value.hint


def test_a_file_that_may_not_be_read(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "x").touch()

    def denied(_: Path) -> bytes:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "read_bytes", denied)
    with pytest.raises(ReadError, match=r"^x: reading this file is not permitted$"):
        read_bytes("x")


def test_absurdly_large_files_are_not_read(folder: Path) -> None:
    with (folder / "big").open("wb") as file:
        file.truncate(2**31 + 1)
    with pytest.raises(ReadError, match="larger than 2 GiB"):
        read_bytes("big")


# --- what may be overwritten ----------------------------------------------------------------


def test_a_new_file_may_be_written(folder: Path) -> None:
    refuse_to_clobber(folder / "new.pto", ["a.pto"], overwrite=False)


@pytest.mark.parametrize("overwrite", [False, True])
def test_the_input_is_never_overwritten_under_whatever_name(folder: Path, overwrite: bool) -> None:
    source = folder / "a.pto"
    source.write_bytes(FITTED)
    (folder / "sub").mkdir()
    (folder / "link.pto").symlink_to(source)
    (folder / "hard.pto").hardlink_to(source)
    for name in ("a.pto", "sub/../a.pto", "link.pto", "hard.pto", str(source)):
        with pytest.raises(WriteError, match="never overwritten") as caught:
            refuse_to_clobber(Path(name), ["other.pto", "a.pto"], overwrite=overwrite)
        assert caught.value.hint


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("x.pto", b"# hugin project file\n# made by plumbline 0.1\n"),
        ("x.pto", FITTED),
        ("x.pto", FITTED.replace(b"\n", b"\r\n")),
        ("x.pto", b"i\tw4\td-1.000000000000000001"),
        ("x.xml", b"<lensdatabase>\n<!-- made by plumbline 0.1; -->"),
        ("x.json", b'{\n  "format": "plumbline calibration",\n'),
        ("x.npz", bytes(3000) + b"made by plumbline 0.1"),
        ("x.tif", bytes(3000) + b"made by plumbline 0.1\0" + bytes(99)),
    ],
)
def test_earlier_outputs_are_replaced(folder: Path, name: str, content: bytes) -> None:
    (folder / name).write_bytes(content)
    refuse_to_clobber(Path(name), [], overwrite=False)


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("x.pto", b""),
        ("x.pto", b'# hugin project file\ni w4 h3 a0.0373655144771111 b-0.11 n"x"\n'),
        ("x.pto", b"i w4 h3 v0.012345678901234567 a0\n"),
        ("x.pto", b"c n0 N0 x1 a0.012345678901234567 y3\n"),
        ("x.xml", b"<lensdatabase version='1'></lensdatabase>"),
        ("x.xml", b"<a/>" * 1000 + b"<!-- made by plumbline 0.1; -->"),
        ("x.json", b'{"shapes": []}'),
        ("x.tif", b"made by plumbline 0.1" + bytes(3000)),
        ("x.json", b'{"notes": "' + b"x" * 2000 + b'", "format": "plumbline calibration"}'),
    ],
)
def test_files_of_others_are_kept_unless_told(folder: Path, name: str, content: bytes) -> None:
    (folder / name).write_bytes(content)
    with pytest.raises(WriteError, match="was not written by plumbline") as caught:
        refuse_to_clobber(Path(name), [], overwrite=False)
    assert "--overwrite" in caught.value.hint
    refuse_to_clobber(Path(name), [], overwrite=True)


@pytest.mark.parametrize("overwrite", [False, True])
def test_what_is_no_file_is_never_replaced(folder: Path, overwrite: bool) -> None:
    (folder / "folder.pto").mkdir()
    os.mkfifo(folder / "pipe.pto")
    for name in ("folder.pto", "pipe.pto", "/dev/null"):
        with pytest.raises(WriteError, match="is not a regular file"):
            refuse_to_clobber(Path(name), [], overwrite=overwrite)
    with pytest.raises(WriteError, match="cannot be written: File name too long"):
        refuse_to_clobber(Path("x" * 300), [], overwrite=overwrite)


# --- atomic ---------------------------------------------------------------------------------


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_files_are_written_with_the_usual_permissions(folder: Path) -> None:
    mask = os.umask(0o027)
    try:
        write_atomically({Path("new"): b"1", folder / "other": b"2"})
    finally:
        os.umask(mask)
    assert (folder / "new").read_bytes() == b"1"
    assert (folder / "new").stat().st_mode & 0o777 == 0o640
    assert names(folder) == ["new", "other"]


def test_permissions_of_a_replaced_file_stay(folder: Path) -> None:
    (folder / "old").write_bytes(b"0")
    (folder / "old").chmod(0o604)
    write_atomically({Path("old"): b"1"})
    assert (folder / "old").read_bytes() == b"1"
    assert (folder / "old").stat().st_mode & 0o777 == 0o604


def test_the_umask_of_other_threads_is_left_alone(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def touched(_: int) -> int:
        raise AssertionError("the umask belongs to the whole process")

    monkeypatch.setattr(os, "umask", touched)
    names_of = [folder / str(index) for index in range(8)]
    threads = [threading.Thread(target=write_atomically, args=({n: b"1"},)) for n in names_of]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    monkeypatch.undo()
    (folder / "plain").touch()
    usual = (folder / "plain").stat().st_mode
    assert [name.stat().st_mode for name in names_of] == [usual] * 8


def test_permissions_that_cannot_be_kept_leave_the_old_file(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def denied(*_: object, **__: object) -> None:
        raise PermissionError(1, "Operation not permitted")

    (folder / "old").write_bytes(b"0")
    monkeypatch.setattr(Path, "chmod", denied)
    with pytest.raises(WriteError, match="Operation not permitted"):
        write_atomically({Path("old"): b"1"})
    assert names(folder) == ["old"]
    assert (folder / "old").read_bytes() == b"0"


def test_names_may_be_as_long_as_the_system_allows(folder: Path) -> None:
    write_atomically({Path("x" * 255): b"1"})
    assert names(folder) == ["x" * 255]


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("none/b", "none/b: the folder does not exist"),
        ("a/b", "a/b: the file cannot be written: Not a directory"),
    ],
)
def test_a_folder_that_is_not_there_leaves_every_file_as_it_was(
    folder: Path, name: str, sentence: str
) -> None:
    (folder / "a").write_bytes(b"0")
    with pytest.raises(WriteError) as caught:
        write_atomically({Path("a"): b"1", Path("new"): b"2", Path(name): b"3"})
    assert caught.value.message == sentence
    assert caught.value.hint
    assert names(folder) == ["a"]
    assert (folder / "a").read_bytes() == b"0"


def test_a_folder_that_is_there_but_takes_no_files_is_not_said_to_be_missing() -> None:
    if not Path("/proc").is_dir():
        pytest.skip("there is no /proc, a folder that takes no new files")
    with pytest.raises(
        WriteError, match=r"^/proc/x\.json: the folder takes no new files"
    ) as caught:
        write_atomically({Path("/proc/x.json"): b"1"})
    assert "another place" in caught.value.hint


@pytest.mark.parametrize("failing", ["fsync", "open", "replace"])
def test_nothing_is_left_behind_by_a_failure(
    folder: Path, monkeypatch: pytest.MonkeyPatch, failing: str
) -> None:
    def full(*_: object, **__: object) -> None:
        raise PermissionError(28, "No space left on device")

    homes = {"fsync": os, "open": os, "replace": Path}
    monkeypatch.setattr(homes[failing], failing, full)
    with pytest.raises(
        WriteError, match=r"^a: the file cannot be written: No space left on device"
    ):
        write_atomically({Path("a"): b"1", Path("b"): b"2"})
    assert names(folder) == []


def test_an_interrupt_leaves_nothing_behind(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(_: int) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "fsync", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_atomically({Path("a"): b"1"})
    assert names(folder) == []


def test_text_of_strangers_is_made_harmless() -> None:
    assert printable("a\nb\x1b[31m\r\t\x00\x9b\u202e\udc80ü[red]") == "a�b�[31m������ü[red]"

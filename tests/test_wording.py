"""Signs that an encoding lacks."""

from __future__ import annotations

import ast
import codecs
import re
import subprocess
import sys
import unicodedata
from pathlib import Path

import pytest

import plumbline
from plumbline.wording import spelt

codecs.register_error("spelt", spelt)
BUILDING = Path(__file__).parents[1] / "sample_projects" / "building" / "building.pto"


@pytest.mark.parametrize("encoding", ["cp1252", "cp437", "cp850", "ascii", "cp932"])
def test_the_marks_of_a_check_stay_apart(encoding: str) -> None:
    marks = ["✓", "?", "✗", "σ̂", "→", "•", "±", "−", "²", "Δ"]
    written = [mark.encode(encoding, "spelt").decode(encoding) for mark in marks]
    assert len(set(written)) == len(marks)
    assert "?" not in "".join(written[:1] + written[2:])


def test_every_sign_that_is_printed_has_a_spelling() -> None:
    signs: set[str] = set()
    for path in Path(plumbline.__file__).parent.rglob("*.py"):
        tree = ast.parse(path.read_text("utf-8"))
        docstrings = {
            id(node.value)
            for node in ast.walk(tree)
            if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        }
        for node in ast.walk(tree):
            if isinstance(node, ast.Constant) and id(node) not in docstrings:
                signs |= set(re.findall(r"[^\x00-\x7f]", str(node.value)))
    assert "✓" in signs
    unspelt = {sign for sign in signs if sign.encode("ascii", "spelt").startswith(b"\\")}
    # Letters, halves of broken ones, and the byte-order mark are not signs.
    assert {unicodedata.category(sign)[0] for sign in unspelt} <= {"L", "C"}


def test_letters_of_other_scripts_are_escaped() -> None:
    assert "Größe 写真".encode("cp1252", "spelt") == b"Gr\xf6\xdfe \\u5199\\u771f"
    with pytest.raises(UnicodeDecodeError):
        b"\xff".decode("utf-8", "spelt")


@pytest.mark.parametrize("encoding", ["cp1252", "utf-8"])
def test_a_check_in_a_console_of_windows(encoding: str, tmp_path: Path) -> None:
    (tmp_path / "b.pto").write_bytes(BUILDING.read_bytes())
    done = subprocess.run(
        [sys.executable, "-m", "plumbline", "check", "b.pto"],
        cwd=tmp_path,
        capture_output=True,
        check=False,
        env={"PYTHONIOENCODING": encoding, "PYTHONUTF8": "0", "PYTHONPATH": ":".join(sys.path)},
    )
    text = done.stdout.decode(encoding)
    marks = [line.split()[0] for line in text.splitlines() if not line.startswith(" ")]
    known = ("✓", "✗", "?") if encoding == "utf-8" else ("OK", "BAD", "?")
    assert set(marks) <= set(known)
    assert known[0] in marks

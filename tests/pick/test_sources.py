"""The sources of the page: small, nothing foreign, checked by tsc and eslint if these are there."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "plumbline" / "pick" / "page"
TOOLS = Path(__file__).parent / "page" / "node_modules" / ".bin"
SCRIPTS = sorted(PAGE.glob("*.js"))


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.name)
def test_a_script_can_be_held_in_the_head(path: Path) -> None:
    text = path.read_text("utf-8")
    assert len(text.splitlines()) <= 250
    assert text.startswith(("/** @file", "/**\n * @file"))


@pytest.mark.parametrize("path", sorted(PAGE.iterdir()), ids=lambda path: path.name)
def test_nothing_comes_from_elsewhere(path: Path) -> None:
    text = path.read_text("utf-8").replace("http://www.w3.org/2000/svg", "")
    assert not re.search(r"https?:|innerHTML|insertAdjacentHTML|document\.write|\beval\b", text)


def test_scripts_import_in_no_circle() -> None:
    used = {
        path.name: set(re.findall(r'^import .* from "\./([\w.]+)";', path.read_text("utf-8"), re.M))
        for path in SCRIPTS
    }
    while free := [name for name, others in used.items() if not others & set(used)]:
        for name in free:
            del used[name]
    assert not used


@pytest.mark.parametrize(
    "command",
    [
        ["tsc", "-p", "tests/pick/page"],
        ["eslint", "--config", "tests/pick/page/eslint.config.js", "plumbline/pick/page"],
    ],
    ids=["types", "style"],
)
def test_types_and_style(command: list[str]) -> None:
    program = TOOLS / command[0]
    if not program.exists():
        pytest.skip(f"{command[0]} is not installed (npm install in tests/pick/page)")
    done = subprocess.run(
        [program, *command[1:]], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr

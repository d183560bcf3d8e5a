"""Keep the README's outputs true: `python -m tests.readme` runs its commands and fills them in.

A fenced block after `<!-- output: COMMAND -->` holds what COMMAND prints, run in a copy of
`sample_projects/building`; with `<!-- output in FOLDER: COMMAND -->` in another sample's.
"""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
README = ROOT / "README.md"
_BLOCK = re.compile(
    r"(<!-- output(?: in (?P<folder>\w+))?: (?P<command>.+?) -->\n```\w*\n)(?P<text>.*?)(```\n)",
    re.DOTALL,
)


def output(command: str, folder: str) -> str:
    """What a `plumbline` command prints in a fresh copy of a sample project."""
    program, *arguments = shlex.split(command)
    assert program == "plumbline"
    with tempfile.TemporaryDirectory() as scratch:
        work = Path(scratch) / folder
        shutil.copytree(ROOT / "sample_projects" / folder, work)
        done = subprocess.run(
            [sys.executable, "-m", "plumbline", *arguments],
            cwd=work,
            capture_output=True,
            text=True,
            timeout=200,
            check=True,
        )
    return "".join(line.rstrip() + "\n" for line in done.stdout.splitlines())


def blocks(text: str) -> list[tuple[str, str, str]]:
    """Command, folder and shown output of every checked block."""
    return [
        (match["command"], match["folder"] or "building", match["text"])
        for match in _BLOCK.finditer(text)
    ]


def filled(text: str) -> str:
    """The README with every checked block made anew."""
    return _BLOCK.sub(lambda m: m[1] + output(m["command"], m["folder"] or "building") + m[5], text)


if __name__ == "__main__":
    README.write_text(filled(README.read_text()))

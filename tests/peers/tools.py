"""Find and run the programs that plumbline is compared with."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Sequence

import pytest


def program(*names: str) -> str:
    """The first of these programs that is installed; the test is skipped if none is."""
    for name in names:
        found = shutil.which(name)
        if found:
            return found
    pytest.skip(f"{names[0]} is not installed, so there is no peer to compare with")


def run(command: Sequence[str], given: str = "", seconds: float = 60) -> str:
    """Standard output of a program that must succeed."""
    done = subprocess.run(
        command, input=given, capture_output=True, text=True, timeout=seconds, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout

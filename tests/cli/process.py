"""The command line as a process, with a data folder of its own."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path


def plumbline(*arguments: str | Path, home: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "plumbline", *map(str, arguments)],
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
        env=os.environ | {"XDG_DATA_HOME": str(home / "data"), "COLUMNS": "120"},
    )

"""Commands run in this process."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from plumbline.cli import main
from tests.cli.process import Result, Run


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """Run the command in this process, in an empty folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "unraisablehook", sys.unraisablehook)
    monkeypatch.setenv("COLUMNS", "100")
    monkeypatch.setattr(sys, "warnoptions", ["error"])  # the command would ignore warnings

    def call(*words: object) -> Result:
        monkeypatch.setattr(sys, "argv", ["plumbline", *map(str, words)])
        capsys.readouterr()
        with pytest.raises(SystemExit) as ended:
            main()
        out, err = capsys.readouterr()
        code = ended.value.code
        assert isinstance(code, int)
        return Result(code, out, err)

    return call

"""The README's commands, outputs and examples, run."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from plumbline.cli import VERBS
from plumbline.formats.known import POINT_FORMATS
from plumbline.models import MODELS
from plumbline.result.schema import ResultRecord
from tests.readme import README, ROOT, blocks, output

TEXT = README.read_text()


@pytest.mark.parametrize(("command", "folder", "shown"), blocks(TEXT))
def test_an_output_is_what_the_command_prints(command: str, folder: str, shown: str) -> None:
    assert shown == output(command, folder), "run: python -m tests.readme"


def test_python_examples_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    work = tmp_path / "building"
    shutil.copytree(ROOT / "sample_projects" / "building", work)
    monkeypatch.chdir(work)
    examples = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)
    assert examples
    for example in examples:
        exec(compile(example, "README.md", "exec"), {})
    assert (work / "mine.pto").exists()


def test_every_verb_model_format_and_result_name_is_documented() -> None:
    for verb in VERBS:
        assert f"plumbline {verb}" in TEXT
    for model in MODELS:
        assert f"`{model}" in TEXT
    for name in POINT_FORMATS:
        assert f"`{name}`" in TEXT
    for name in ResultRecord.__struct_fields__:
        assert f"`{name}`" in TEXT, f"the JSON's {name} is not documented"


def test_links_lead_somewhere() -> None:
    for target in re.findall(r"\]\((?!https?:)([^)#]+)\)", TEXT):
        assert (ROOT / target).exists(), target
    for target in re.findall(r'src="([^"]+)"', TEXT):
        assert (ROOT / target).exists(), target


def test_ci_runs_the_tests_as_the_readme_says() -> None:
    commands = re.findall(r"```sh\n(.*?)```", TEXT, re.DOTALL)
    assert len(commands) >= 2
    script = (ROOT / ".ci" / "run").read_text()
    tests = next(command for command in commands if "pytest" in command)
    assert tests.strip() in script

"""The house: who may import whom, what loads when, what is public, how long a module grows."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import plumbline

PACKAGE = Path(plumbline.__file__).parent

FLOORS = [
    ("errors", "_version", "wording", "student"),
    ("files",),
    ("frame", "facts", "picks", "observations"),
    ("models",),
    ("lens", "finding", "ideal", "displacement", "straightness"),
    ("linearised", "suspect", "trust", "checks", "resampling"),
    ("next_line", "trust_checks", "notes", "calibration", "comparison"),
    ("result_json", "result_reading", "consistency"),
    ("fit",),
    ("formats",),
    ("lenses",),
    ("photos", "reading", "lensfun_writing", "writing"),
    ("imaging",),
    ("edges",),
    ("report",),
    ("cli",),
]
"""From the ground up: a module imports from its own floor and from those below it."""

FACES = ("__init__", "__main__")
"""The package's face and its entry point stand outside the floors."""

HEIGHT = {name: height for height, names in enumerate(FLOORS) for name in names}

MODULES = sorted(PACKAGE.rglob("*.py"))


def name_of(path: Path) -> str:
    return ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts)


every_module = pytest.mark.parametrize("path", MODULES, ids=map(name_of, MODULES))


def imports(path: Path) -> Iterator[str]:
    """Full names of all modules imported anywhere in a file, nested imports included."""
    package = name_of(path).split(".") if path.stem == "__init__" else name_of(path).split(".")[:-1]
    package = package[:-1] if path.stem == "__init__" else package
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) + 1 - node.level] if node.level else []
            base = ".".join([*above, *([node.module] if node.module else [])])
            if base == "plumbline":
                yield from (f"plumbline.{alias.name}" for alias in node.names)
            else:
                yield base


def floor_of(path: Path) -> str:
    first = path.relative_to(PACKAGE).parts[0]
    return first.removesuffix(".py")


def test_every_module_has_its_floor() -> None:
    found = {floor_of(path) for path in MODULES}
    assert found - set(FACES) <= set(HEIGHT)


@every_module
def test_imports_run_downwards_only(path: Path) -> None:
    floor = floor_of(path)
    if floor in FACES:
        return
    used = {name.split(".")[1] for name in imports(path) if name.startswith("plumbline.")}
    assert "plumbline" not in set(imports(path)), "import from the module that has the name"
    above = {name for name in used if HEIGHT[name] > HEIGHT[floor]}
    assert not above, f"{floor} imports upwards: {sorted(above)}"


@every_module
def test_only_the_fit_knows_jax(path: Path) -> None:
    heavy = {name.split(".")[0] for name in imports(path)} & {
        "jax",
        "jaxlib",
        "equinox",
        "optimistix",
    }
    assert not heavy or floor_of(path) == "fit"


@every_module
def test_no_module_grows_too_long(path: Path) -> None:
    assert len(path.read_text("utf-8").splitlines()) <= 300


def loaded_by(program: str) -> set[str]:
    """Top-level modules that a program has loaded by its end, in a process of its own."""
    ending = "\nimport sys\nprint('LOADED', *sorted({n.split('.')[0] for n in sys.modules}))"
    done = subprocess.run(
        [sys.executable, "-c", program + ending], capture_output=True, text=True, check=True
    )
    return set(done.stdout.rpartition("LOADED")[2].split())


HELP = """
import sys
sys.argv = ["plumbline", "--help"]
from plumbline.cli import main
try:
    main()
except SystemExit as end:
    assert not end.code
"""


@pytest.mark.parametrize(
    "program",
    ["import plumbline", "import plumbline; dir(plumbline); plumbline.__version__", HELP],
    ids=["import", "dir", "help"],
)
def test_numpy_and_jax_wait_until_needed(program: str) -> None:
    loaded = loaded_by(program)
    assert "plumbline" in loaded
    assert not loaded & {"numpy", "jax", "scipy", "lxml", "PIL", "rich"}


@pytest.mark.parametrize(
    "program",
    [
        "import plumbline.models, plumbline.models.inverse",
        "import plumbline.lens, plumbline.finding, plumbline.calibration",
        """
import plumbline
zero = dict.fromkeys("abcde", 0.0)
lens = plumbline.Lens(plumbline.get_model("ptlens"), plumbline.Frame(30, 20), zero | {"b": -0.02})
lens.distort(lens.undistort([[1.0, 2.0]]))
""",
    ],
    ids=["models", "lens", "correcting a point"],
)
def test_correcting_loads_no_jax(program: str) -> None:
    loaded = loaded_by(program)
    assert "numpy" in loaded
    assert not loaded & {"jax", "jaxlib", "optimistix", "equinox"}


def test_the_public_names() -> None:
    assert plumbline.__all__ == [
        "FORMATS",
        "MODELS",
        "Calibration",
        "Candidate",
        "Check",
        "CollapsedFitError",
        "Comparison",
        "Corrected",
        "DegenerateLinesError",
        "FoldedError",
        "Frame",
        "Lens",
        "LensFacts",
        "Line",
        "Observations",
        "OptionError",
        "Outcome",
        "Photo",
        "PlumblineError",
        "ReadError",
        "Snapped",
        "Suspect",
        "UnsettledError",
        "UnsupportedModelError",
        "WriteError",
        "__version__",
        "bootstrap",
        "calibrate",
        "calibrate_many",
        "compare",
        "correct",
        "correct_array",
        "correct_many",
        "get_model",
        "join",
        "read",
        "read_calibration",
        "read_calibrations",
        "snap",
        "write",
        "write_points",
    ]


def test_the_public_names_exist() -> None:
    for name in plumbline.__all__:
        assert getattr(plumbline, name) is not None
    assert dir(plumbline) == sorted(plumbline.__all__)
    with pytest.raises(AttributeError, match="nonsense"):
        _ = plumbline.nonsense  # pyright: ignore[reportAttributeAccessIssue]


def test_the_errors_are_a_tree() -> None:
    def subclasses(error: type[Exception]) -> set[type[Exception]]:
        return {error}.union(*(subclasses(each) for each in error.__subclasses__()))

    for name in plumbline.__all__:
        if name.endswith("Error"):
            assert getattr(plumbline, name) in subclasses(plumbline.PlumblineError)
    assert issubclass(plumbline.OptionError, ValueError)
    assert issubclass(plumbline.UnsupportedModelError, plumbline.OptionError)
    assert issubclass(plumbline.CollapsedFitError, plumbline.DegenerateLinesError)

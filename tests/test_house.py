"""The house: who may import whom, what loads when, what is public, how long a module grows."""

from __future__ import annotations

import ast
import importlib
import re
import subprocess
import sys
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path

import pytest

import plumbline

PACKAGE = Path(plumbline.__file__).parent

FLOORS = (
    "errors wording _version frame",
    "files models observations",
    "geometry photos",
    "formats trust",
    "reading result",
    "fit lenses",
    "writing imaging boards edges pairs ground",
    "report rectified",
    "pick",
    "cli",
)
"""From the ground up: a room imports from the floors below its own."""

LATE = {("plumbline.result.calibration", "plumbline.report.notebook")}
"""Who reaches upwards, and for what: a calibration shows itself by what stands above it, which is
loaded when it is asked for."""

FACES = ("__init__", "__main__")
"""The package's face and its entry point stand outside the floors."""

HEIGHT = {name: height for height, names in enumerate(FLOORS) for name in names.split()}

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


def room_of(path: Path) -> str:
    first = path.relative_to(PACKAGE).parts[0]
    return first.removesuffix(".py")


def test_the_house_is_the_tree() -> None:
    rooms = {
        each.name.removesuffix(".py")
        for each in PACKAGE.iterdir()
        if each.suffix == ".py" or (each / "__init__.py").is_file()
    }
    assert rooms - set(FACES) == set(HEIGHT)
    assert len(FLOORS) <= 10


def test_contributors_read_of_every_room_from_the_top_down() -> None:
    text = (PACKAGE / "CONTRIBUTING.md").read_text("utf-8")
    drawn = text.split("```")[1].strip().splitlines()
    rooms = [room for line in drawn for room in re.split(" {3,}", line)[0].split()]
    assert set(rooms) == set(HEIGHT)
    assert [HEIGHT[room] for room in rooms] == sorted(HEIGHT.values(), reverse=True)


@every_module
def test_rooms_import_from_floors_below_only(path: Path) -> None:
    room = room_of(path)
    if room in FACES:
        return
    own = {name for name in imports(path) if (name_of(path), name) not in LATE}
    used = {name.split(".")[1] for name in own if name.startswith("plumbline.")}
    assert "plumbline" not in set(imports(path)), "import from the module that has the name"
    above = {name for name in used - {room} if HEIGHT[name] >= HEIGHT[room]}
    assert not above, f"{room} imports from its own floor or from above: {sorted(above)}"


def circles(modules: Mapping[str, Collection[str]]) -> set[str]:
    """Modules that import one another in a circle, whatever the imports are hidden behind."""
    left = {name: set(used) & set(modules) - {name} for name, used in modules.items()}
    while free := [name for name, used in left.items() if not used & set(left)]:
        for name in free:
            del left[name]
    return set(left)


def modules_used(path: Path) -> set[str]:
    """Full names of the package's own modules that a file imports."""
    names = {name_of(each) for each in MODULES}
    wanted: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            inner = {f"{node.module}.{alias.name}" for alias in node.names}
            modules = {each for each in inner if {each, f"{each}.__init__"} & names}
            wanted |= modules or {node.module}
        elif isinstance(node, ast.Import):
            wanted |= {alias.name for alias in node.names}
    return (wanted | {f"{each}.__init__" for each in wanted}) & names


@pytest.mark.parametrize("room", sorted(set(HEIGHT)))
def test_no_circle_inside_a_room(room: str) -> None:
    inside = {name_of(path): modules_used(path) for path in MODULES if room_of(path) == room}
    assert not circles(inside)


def test_circles_are_seen() -> None:
    assert circles({"a": {"b"}, "b": {"c"}, "c": {"b"}, "d": set()}) == {"a", "b", "c"}
    assert not circles({"a": {"b", "c"}, "b": {"c"}, "c": set()})


@every_module
def test_only_the_fit_knows_jax(path: Path) -> None:
    heavy = {name.split(".")[0] for name in imports(path)} & {
        "jax",
        "jaxlib",
        "equinox",
        "optimistix",
    }
    assert not heavy or name_of(path).startswith("plumbline.fit.program.")


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


@pytest.mark.parametrize(("module", "above"), LATE)
def test_what_reaches_upwards_does_so_late(module: str, above: str) -> None:
    program = f"import sys, {module}\nassert {above!r} not in sys.modules"
    assert "plumbline" in loaded_by(program)


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
        "import plumbline.geometry.lens, plumbline.geometry.finding, plumbline.result.calibration",
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


def test_the_public_names_are_those_of_the_table() -> None:
    homes = plumbline._HOMES  # pyright: ignore[reportPrivateUsage]
    named = [name for names in homes.values() for name in names]
    assert len(set(named)) == len(named)
    assert plumbline.__all__ == sorted([*named, "__version__"])
    for home, names in homes.items():
        for name in names:
            assert getattr(plumbline, name) is getattr(importlib.import_module(home), name)


def test_type_checkers_see_the_same_names() -> None:
    tree = ast.parse((PACKAGE / "__init__.py").read_text("utf-8"))
    (block,) = [node for node in tree.body if isinstance(node, ast.If)]
    seen = {
        (node.module, alias.name)
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    homes = plumbline._HOMES  # pyright: ignore[reportPrivateUsage]
    assert seen == {(home, name) for home, names in homes.items() for name in names}


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


def calls(path: Path) -> set[str]:
    """Names of the functions and methods that a module calls."""
    called = [
        n.func for n in ast.walk(ast.parse(path.read_text("utf-8"))) if isinstance(n, ast.Call)
    ]
    return {getattr(each, "attr", getattr(each, "id", "")) for each in called}


def test_there_is_no_second_mapping() -> None:
    """Who solves a polynomial backwards, or looks for its fold, asks the model."""
    inverting = {name_of(path) for path in MODULES if calls(path) & {"invert", "first_fold"}}
    assert inverting == {"plumbline.models.base", "plumbline.models.inverse"}
    solving = {"brentq", "newton", "fsolve", "root_scalar"}
    assert not {name_of(path) for path in MODULES if calls(path) & solving}

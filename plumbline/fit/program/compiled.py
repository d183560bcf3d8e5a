"""Compiled programs: made once for a model and a shape, and kept on disk.

A fit takes milliseconds; tracing its program takes half a second and compiling it a few. The
traced program is therefore kept in the user's cache folder (as `jax.export` writes it), and what
XLA compiles from it in JAX's own persistent cache beside it. Nothing depends on either: a cache
that is absent, broken, stale or cannot be written is done without, and the program is made anew.
`PLUMBLINE_CACHE_DIR` names another folder. A process whose JAX has a compilation cache already
keeps that; another's is set to this folder, for all that it compiles from then on.
"""

from __future__ import annotations

import contextlib
import hashlib
import math
import os
import warnings
from collections.abc import Callable, Sequence
from functools import cache, partial
from importlib.metadata import version
from pathlib import Path
from threading import Lock
from typing import Any, NamedTuple

import jax
import numpy as np
from jax import export
from platformdirs import user_cache_path

from plumbline.errors import PlumblineError, WriteError
from plumbline.files import write_atomically
from plumbline.fit.program.blocks import Block
from plumbline.fit.program.task import EMPTY_TASK, FitTask, Residuals, Solution
from plumbline.models import CENTRE
from plumbline.models.base import Model

_DISTRIBUTIONS = ("jax", "jaxlib", "optimistix", "equinox", "lineax")
PATTERNS = ("*.program", "jit_*-cache", "jit_*-atime")
"""What the files of the cache are called: traced programs, and what JAX keeps."""

_BROKEN = "persistent compilation cache"
_DIGEST_BYTES = 32
"""Length of a SHA-256."""
_FEW_POINTS = 8192
"""Up to so many points XLA optimises less: compiling then costs more than it saves; chosen, the
benchmark `speed` times both sides of it."""
_QUICK: dict[str, str | bool] = {"xla_backend_optimization_level": "0"}
"""Optimising takes a second or two longer, and saves a millisecond a fit of few points."""

Shapes = tuple[tuple[tuple[int, ...], str], ...]


class Fit(NamedTuple):
    """What a program is made for, beside shapes.

    Attributes:
        model: The distortion model.
        centre: Whether the distortion centre may be free.
    """

    model: Model
    centre: bool


for _tuple in (Block, Residuals, FitTask, Solution):
    export.register_namedtuple_serialization(_tuple, serialized_name=f"plumbline.{_tuple.__name__}")


@cache
def _making(_: object) -> Lock:
    """Two threads that want one program make it once."""
    return Lock()


def program(model: Model, task: FitTask, batch: int | None) -> Callable[[FitTask], Solution]:
    """The compiled fit for tasks like this one.

    Args:
        model: The distortion model.
        task: A task of the shape; with a leading axis of `batch` problems unless that is None.
        batch: How many problems the program takes at once; None for one without that axis.

    Call it, and its result, with 64-bit numbers enabled (`jax.enable_x64`).

    Raises:
        PlumblineError: this process was forked from one that has fitted.
    """
    _refuse_forked()
    shapes = tuple((leaf.shape, str(leaf.dtype)) for leaf in jax.tree.leaves(task))
    fit = Fit(model, bool(np.any(task.free[..., -len(CENTRE) :])))
    with _making((fit, shapes, batch)):
        return _program(fit, shapes, batch)


@cache
def _first_process() -> int:
    """The process that fitted first; a fork inherits the answer, and none of JAX's threads."""
    return os.getpid()


def _refuse_forked() -> None:
    """Refuse what would wait for ever for threads that are not there."""
    if _first_process() != os.getpid():
        raise PlumblineError(
            "this process was forked from one that has fitted, and JAX's threads stayed behind",
            hint='start processes with multiprocessing.get_context("spawn"), or fork before the '
            "first fit",
        )


@cache
def _program(fit: Fit, shapes: Shapes, batch: int | None) -> Callable[[FitTask], Solution]:
    folder = usable_folder()
    name = f"{_key(fit, shapes, batch)}.program"
    exported = None
    if folder is not None:
        _keep_compiled(folder)
        exported = _loaded(folder / name)
    if exported is None:
        exported = _exported(fit, shapes, batch)
        if folder is not None:
            _save(folder / name, exported)
    lowered = jax.jit(exported.call).lower(_task_of(shapes))
    points = math.prod(shapes[1][0])  # the weights of the block
    return _compiled(lowered, _QUICK if batch is None and points <= _FEW_POINTS else None, folder)


def _compiled(lowered: Any, options: dict[str, str | bool] | None, folder: Path | None) -> Any:
    """Compile, or take what JAX kept; broken entries are thrown away instead of complained of."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        program = lowered.compile(options)
    broken = [each for each in told if _BROKEN in str(each.message)]
    if broken and folder is not None:
        clear(folder, PATTERNS[1:])
    for each in told:
        if each not in broken:
            warnings.warn_explicit(each.message, each.category, each.filename, each.lineno)
    return program


def kept(folder: Path, patterns: Sequence[str] = PATTERNS) -> list[Path]:
    """The files that plumbline and JAX keep in a cache folder."""
    return sorted(path for pattern in patterns for path in folder.glob(pattern) if path.is_file())


def clear(folder: Path, patterns: Sequence[str] = PATTERNS) -> int:
    """Throw kept programs away.

    Returns:
        How many files went.
    """
    gone = 0
    for path in kept(folder, patterns):
        with contextlib.suppress(OSError):
            path.unlink()
            gone += 1
    return gone


def _task_of(shapes: Shapes) -> FitTask:
    leaves = [jax.ShapeDtypeStruct(shape, dtype) for shape, dtype in shapes]
    return jax.tree.unflatten(jax.tree.structure(EMPTY_TASK), leaves)


def _exported(fit: Fit, shapes: Shapes, batch: int | None) -> export.Exported:
    from plumbline.fit.program.minimise import minimise

    one = partial(minimise, *fit)
    return export.export(jax.jit(one if batch is None else jax.vmap(one)))(_task_of(shapes))


def cache_folder() -> Path:
    """Where programs are kept."""
    chosen = os.environ.get("PLUMBLINE_CACHE_DIR")
    return Path(chosen) if chosen else user_cache_path("plumbline", appauthor=False)


def usable_folder() -> Path | None:
    """The cache folder, made if need be; None if it cannot be written."""
    folder = cache_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return None
    return folder if os.access(folder, os.W_OK | os.X_OK) else None


def _keep_compiled(folder: Path) -> None:
    """Let JAX keep what it compiles there, unless the user has it kept elsewhere."""
    if jax.config.values["jax_compilation_cache_dir"] is None:
        jax.config.update("jax_compilation_cache_dir", str(folder))
        jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.1)


def _key(fit: Fit, shapes: Any, batch: int | None) -> str:
    """Stands for everything that the traced program depends on."""
    versions = [version(name) for name in _DISTRIBUTIONS]
    purpose = fit.model.label, fit.centre, shapes, batch
    parts = (purpose, versions, jax.default_backend(), _sources())
    return hashlib.sha256(repr(parts).encode()).hexdigest()


@cache
def _sources() -> str:
    """A digest of the code that is traced: this room, the models and the frame."""
    package = Path(__file__).parents[2]
    rooms = (package / "fit" / "program").glob("*.py"), (package / "models").glob("*.py")
    files = sorted([*rooms[0], *rooms[1], package / "frame.py"])
    return hashlib.sha256(b"\0".join(file.read_bytes() for file in files)).hexdigest()


def _save(path: Path, exported: export.Exported) -> None:
    content = bytes(exported.serialize())
    with contextlib.suppress(WriteError):
        write_atomically({path: hashlib.sha256(content).digest() + content})


def _loaded(path: Path) -> export.Exported | None:
    """A kept program, if it is there and whole."""
    try:
        kept = path.read_bytes()
    except OSError:
        return None
    digest, content = kept[:_DIGEST_BYTES], kept[_DIGEST_BYTES:]
    if hashlib.sha256(content).digest() != digest:
        return None
    return export.deserialize(bytearray(content))

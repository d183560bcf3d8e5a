"""Calibrate many lenses: in compiled batches here, or spread over the workers of an executor."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Executor, Future, ThreadPoolExecutor
from typing import NamedTuple, TypeAlias

from plumbline.errors import PlumblineError, or_error, refuse_other_type
from plumbline.fit.options import as_names
from plumbline.fit.problem import Problem, only_lens, prepare_many
from plumbline.fit.program.blocks import shape_of
from plumbline.fit.program.solve import BATCH, launch
from plumbline.fit.program.task import Solution
from plumbline.fit.single import finished
from plumbline.models import get_model
from plumbline.observations import Observations
from plumbline.result.calibration import Calibration
from plumbline.trust.assessment import ResidualKind

_CHUNK = 4 * BATCH
"""Problems that are prepared, fitted, screened and finished in one go."""

_AHEAD = 2
"""How many of these are prepared while JAX fits those before and a thread finishes others."""

_IN_FLIGHT = 64
"""How many of these an executor holds at a time: chosen, more than most clusters have workers, and
few enough that the picks of an archive are not all copied at once."""

Outcome: TypeAlias = Calibration | PlumblineError
"""What became of one lens."""


class _How(NamedTuple):
    """How the lenses are to be fitted, see `calibrate`."""

    model: str
    free: tuple[str, ...] | None
    hold: tuple[str, ...]
    residual: ResidualKind
    robust: bool


def calibrate_many(
    observations: Iterable[Observations],
    model: str = "ptlens",
    *,
    free: Iterable[str] | None = None,
    hold: Iterable[str] = (),
    residual: ResidualKind = "image",
    robust: bool = False,
    executor: Executor | None = None,
) -> list[Outcome]:
    """Calibrate many lenses at once, in compiled batches of problems of like size.

    Args:
        observations: Each the photos and lines of one lens.
        model: As for `calibrate`, but not "auto".
        free: As for `calibrate`.
        hold: As for `calibrate`.
        residual: As for `calibrate`.
        robust: As for `calibrate`.
        executor: Where to do the work: any `concurrent.futures.Executor`, such as the
            `get_executor()` of a Dask client. In this process by default, which uses every
            core. The processes of a pool must not be forked from one that has fitted: give
            `ProcessPoolExecutor` the context `multiprocessing.get_context("spawn")`.

    Returns:
        For each lens, in the same order, the calibration that `calibrate` gives, or the error
        that it raises: one lens that fails stops no other.

    Raises:
        OptionError: the model or the kind of residual is unknown.

    Example:
        >>> import plumbline
        >>> plumbline.calibrate_many([])
        []
    """
    get_model(model)
    refuse_other_type(observations, Iterable, "a list of Observations", "give one for each lens")
    lenses = list(observations)
    chosen = None if free is None else as_names(free, "free")
    how = _How(model, chosen, as_names(hold, "hold"), residual, robust)
    found: dict[int, Outcome] = {}
    batches: dict[tuple[int, int], list[int]] = {}
    for index, each in enumerate(lenses):
        facts = or_error(lambda each=each: only_lens(each))
        if isinstance(facts, PlumblineError):
            found[index] = facts
        else:
            batches.setdefault(shape_of(each), []).append(index)
    chunks = [
        members[first : first + _CHUNK]
        for members in batches.values()
        for first in range(0, len(members), _CHUNK)
    ]
    work = ([lenses[index] for index in chunk] for chunk in chunks)
    outcomes = _here(work, how) if executor is None else _spread(work, how, executor)
    for chunk, some in zip(chunks, outcomes, strict=True):
        found |= zip(chunk, some, strict=True)
    return [found[index] for index in range(len(lenses))]


def _here(work: Iterable[list[Observations]], how: _How) -> Iterator[list[Outcome]]:
    """Outcomes of all chunks: prepared, fitted and finished side by side."""
    running: deque[Future[list[Outcome]]] = deque()
    with ThreadPoolExecutor(1) as pool:
        for some in work:
            running.append(pool.submit(_begun(some, how)))
            if len(running) > _AHEAD:
                yield running.popleft().result()
        for last in running:
            yield last.result()


def _begun(some: Sequence[Observations], how: _How) -> Callable[[], list[Outcome]]:
    """Begin to fit a chunk; what is returned waits for the solutions and finishes them."""
    model = get_model(how.model)
    ready = prepare_many(some, model, how.free, how.hold, None, how.residual)
    problems = [each for each in ready if not isinstance(each, PlumblineError)]
    solutions = launch(model, [problem.task for problem in problems])

    def outcomes() -> list[Outcome]:
        finished = iter(_finished(problems, solutions(), robust=how.robust))
        return [each if isinstance(each, PlumblineError) else next(finished) for each in ready]

    return outcomes


def _finished(
    problems: Sequence[Problem], solutions: Sequence[Solution], *, robust: bool
) -> list[Outcome]:
    return finished(problems, solutions, robust=robust) if problems else []


def _spread(
    work: Iterable[list[Observations]], how: _How, executor: Executor
) -> Iterator[list[Outcome]]:
    """Outcomes of all chunks from the workers of an executor."""
    running: deque[tuple[int, Future[list[Outcome]]]] = deque()
    try:
        for some in work:
            running.append((len(some), _submitted(executor, some, how)))
            if len(running) >= _IN_FLIGHT:
                yield _result(*running.popleft())
        while running:
            yield _result(*running.popleft())
    finally:
        for _, future in running:
            future.cancel()


def _submitted(executor: Executor, some: list[Observations], how: _How) -> Future[list[Outcome]]:
    try:
        return executor.submit(_fitted, some, how)
    except BrokenExecutor as error:  # a worker died, and its pool with it
        lost: Future[list[Outcome]] = Future()
        lost.set_exception(error)
        return lost


def _fitted(some: Sequence[Observations], how: _How) -> list[Outcome]:
    """One chunk, in a worker."""
    return _begun(some, how)()


def _result(n_lenses: int, future: Future[list[Outcome]]) -> list[Outcome]:
    try:
        return future.result()
    except PlumblineError as error:
        return [error] * n_lenses
    except Exception as error:  # whatever an executor raises for work that it lost
        lost = f"the worker that fitted it failed: {type(error).__name__}: {error}"
        return [PlumblineError(lost.rstrip(": ")) for _ in range(n_lenses)]

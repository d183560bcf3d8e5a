"""Many lenses at once: each as alone, in its place, failures too, on any executor."""

from __future__ import annotations

import multiprocessing
import subprocess
import sys
from collections.abc import Generator
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from functools import partial
from typing import Any

import numpy as np
import pytest

import plumbline
from plumbline import Calibration, Observations, PlumblineError, calibrate, calibrate_many
from plumbline.errors import or_error
from plumbline.fit import many
from tests import truth
from tests.fit.test_calibrate import ACTION_CAMERAS, MILD, picked, radiating
from tests.truth import TrueLens

SIZE = (3000, 2250)


def some() -> list[Any]:
    """Lenses of two shapes; the second, third and fifth cannot be fitted."""
    lens = TrueLens("ptlens", MILD)
    return [
        picked(lens, noise_px=0.4),
        Observations.from_arrays(radiating(), SIZE),
        picked(lens, projection="fisheye"),
        Observations.from_arrays(lens.lines(8, noise_px=0.4), lens.size),
        "building.pto",
        picked(TrueLens("ptlens", ACTION_CAMERAS[0]), noise_px=0.4),
    ]


def test_many_are_as_one_by_one_and_in_order() -> None:
    lenses = [
        TrueLens("ptlens", ACTION_CAMERAS[0]),
        TrueLens("ptlens", MILD, (1920, 1080)),
        TrueLens("ptlens", {"a": 0.01, "b": 0.03, "c": 0.0}, (1200, 1600)),
    ]
    observed = [picked(lens, noise_px=0.4, seed=i) for i, lens in enumerate(lenses)]
    few = Observations.from_arrays(lenses[1].lines(8, noise_px=0.4), lenses[1].size)  # 16 rows
    observed.insert(1, few)
    together = calibrate_many(iter(observed))
    for made, obs in zip(together, observed, strict=True):
        assert isinstance(made, Calibration)
        assert made.observations is obs
        alone = calibrate(obs)
        grid = truth.grid_px(made.lens.frame.size)
        apart = np.abs(made.lens.undistort(grid) - alone.lens.undistort(grid))
        assert np.max(apart) < 1e-9
        for one, other in zip(made.residuals_px, alone.residuals_px, strict=True):
            np.testing.assert_allclose(one, other, rtol=0, atol=1e-9)
        np.testing.assert_allclose(made.covariance, alone.covariance, rtol=1e-6)
        assert (made.free, made.dof, made.converged) == (alone.free, alone.dof, alone.converged)


def test_no_lens_of_many_is_no_calibration() -> None:
    assert calibrate_many([]) == []


@pytest.mark.parametrize("robust", [False, True], ids=["plain", "robust"])
def test_a_failure_stands_in_its_place_and_stops_no_other(*, robust: bool) -> None:
    lenses = some()
    for made, observed in zip(calibrate_many(lenses, robust=robust), lenses, strict=True):
        alone = or_error(partial(calibrate, observed, robust=robust))
        assert type(made) is type(alone)
        if isinstance(alone, PlumblineError) or isinstance(made, PlumblineError):
            assert str(made) == str(alone)
            assert getattr(made, "__traceback__", None) is None
        else:
            for name, value in alone.coefficients.items():
                assert made.coefficients[name] == pytest.approx(value, abs=1e-9)


def test_arguments_that_concern_all_are_refused_at_once() -> None:
    lens = [picked(TrueLens("ptlens", MILD))]
    with pytest.raises(plumbline.UnsupportedModelError):
        calibrate_many(lens, "nonsense")
    with pytest.raises(plumbline.OptionError, match="residual"):
        calibrate_many(lens, residual="nonsense")  # pyright: ignore[reportArgumentType]
    with pytest.raises(plumbline.OptionError, match="list of Observations"):
        calibrate_many(3)  # pyright: ignore[reportArgumentType]


@contextmanager
def spawned() -> Generator[Executor]:
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        yield pool


@contextmanager
def of_dask() -> Generator[Executor]:
    """A cluster's executor, its worker in this process."""
    distributed = pytest.importorskip("distributed", reason="Dask is not installed")
    with (
        distributed.Client(
            n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None
        ) as client,
        client.get_executor() as executor,
    ):
        yield executor


@pytest.mark.parametrize("workers", [spawned, of_dask])
@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::ResourceWarning")
def test_any_executor_does_the_work(workers: Any) -> None:
    here = calibrate_many(some())
    with workers() as executor:
        there = calibrate_many(some(), executor=executor)
    for one, other in zip(here, there, strict=True):
        assert type(one) is type(other)
        if isinstance(one, Calibration) and isinstance(other, Calibration):
            assert one.coefficients == pytest.approx(other.coefficients, abs=1e-12)


class Losing(Executor):
    """An executor that loses every second piece of work, and breaks at the fifth."""

    def __init__(self) -> None:
        self._taken = 0

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        self._taken += 1
        if self._taken >= 5:
            raise BrokenExecutor
        future: Future[Any] = Future()
        if self._taken % 2:
            future.set_result(fn(*args, **kwargs))
        else:
            future.set_exception(BrokenExecutor("a worker died"))
        return future


def test_work_that_an_executor_loses_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(many, "_CHUNK", 1)
    lens = picked(TrueLens("ptlens", MILD), noise_px=0.4)
    made = calibrate_many([lens] * 6, executor=Losing())
    assert [isinstance(each, Calibration) for each in made] == [True, False, True] + 3 * [False]
    assert str(made[1]) == "the worker that fitted it failed: BrokenExecutor: a worker died"
    assert str(made[5]) == "the worker that fitted it failed: BrokenExecutor"


FORKED = """
import os, sys, warnings
import plumbline
warnings.simplefilter("ignore")
lines = [[[x, y + 1e-5 * (x - 320) ** 2 * (y - 240) / 24] for x in range(20, 640, 60)]
         for y in range(20, 480, 40)]
picks = plumbline.Observations.from_arrays(lines, size=(640, 480))
if sys.argv[1] == "after":
    plumbline.calibrate(picks, free=("b",))
child = os.fork()
if not child:
    try:
        print(f"b = {plumbline.calibrate(picks, free=('b',)).coefficients['b']:.2g}", flush=True)
    except plumbline.PlumblineError as error:
        print(error, error.hint, flush=True)
    os._exit(0)
os.waitpid(child, 0)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="other systems start processes anew")
@pytest.mark.parametrize(("when", "said"), [("before", "b = "), ("after", "forked")])
def test_a_fork_of_a_process_that_has_fitted_is_refused(when: str, said: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", FORKED, when], capture_output=True, text=True, timeout=60, check=True
    )
    assert said in done.stdout
    assert ("spawn" in done.stdout) is (when == "after")

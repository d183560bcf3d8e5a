"""The residual and its derivative against an independent computation in NumPy."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache as remembered

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from plumbline.fit.program.blocks import Block, Packed, pack
from plumbline.fit.program.residual import residuals
from plumbline.fit.program.task import Residuals
from plumbline.geometry.lines import fit_lines
from plumbline.models import MODELS, get_model
from plumbline.models.inverse import REACH
from plumbline.observations import Line, Observations, Photo
from plumbline.trust.straightness import straightness_before
from tests import truth
from tests.truth import TrueLens

Array = truth.Array


def _across(points: Array) -> Array:
    lines = fit_lines(points, np.array([len(points)]), np.ones(len(points)))
    return lines.place(points, np.zeros(len(points), dtype=np.int64))[1]


NAMES = (*MODELS, "radial:1,2,3", "radial:2,4")
FOCAL_PX = 2400.0

STRONG: dict[str, Mapping[str, float]] = {
    "ptlens": {"a": 0.0213, "b": -0.0864, "c": 0.0321},
    "poly3": {"k1": -0.05},
    "poly5": {"k1": -0.07, "k2": 0.012},
    "radial": {"a2": 0.11, "a4": -0.02, "a6": 0.004},
    "brown": {"k1": 0.09, "k2": 0.02, "k3": -0.003, "p1": 0.004, "p2": -0.003},
    "division": {"l1": -0.12, "l2": 0.01},
    "opencv": {"k1": -0.21, "k2": 0.07, "p1": 0.003, "p2": -0.002, "k3": -0.01},
    "acm": {"k1": -0.21, "k2": 0.07, "k3": -0.01, "k4": 0.003, "k5": -0.002},
    "radial:1,2,3": {"a1": 0.02, "a2": 0.08, "a3": -0.01},
    "radial:2,4": {"a2": -0.06, "a4": 0.02},
}

every_model = pytest.mark.parametrize("name", NAMES)

Kernel = Callable[[jax.Array, Block, jax.Array, jax.Array], tuple[Residuals, Residuals]]


@remembered
def program(name: str) -> Kernel:
    """Residuals and their derivatives by the coefficients, compiled once a model and shape."""
    model = get_model(name)

    @jax.jit
    def both(
        c: jax.Array, block: Block, unit_px: jax.Array, reach: jax.Array
    ) -> tuple[Residuals, Residuals]:
        def twice(c: jax.Array) -> tuple[Residuals, Residuals]:
            at = residuals(model, c, block, unit_px, reach)
            return at, at

        derivative, value = jax.jacfwd(twice, has_aux=True)(c)
        return value, derivative

    return both


def computed(lens: TrueLens, c: Array, block: Block) -> tuple[Residuals, Residuals]:
    """Residuals and derivatives by the code under test, as NumPy arrays."""
    with jax.enable_x64(True):
        points = jax.tree.map(jnp.asarray, block)
        unit, reach = jnp.asarray(lens.unit_px), jnp.asarray(REACH * lens.corner)
        return jax.tree.map(np.asarray, program(lens.name)(jnp.asarray(c), points, unit, reach))


def packed_for(lens: TrueLens, lines: list[Array]) -> Packed:
    picked = tuple(Line(points, 0, str(number)) for number, points in enumerate(lines))
    return pack([Observations((Photo(lens.size),), picked)], [lens.unit_px])[0]


def normalised(lens: TrueLens, lines: list[Array]) -> list[Array]:
    middle = (np.array(lens.size) - 1) / 2
    return [(points - middle) / lens.unit_px for points in lines]


def vector(lens: TrueLens) -> Array:
    """The model's coefficients, and the centre in normalised units."""
    c = lens.all_coefficients
    model = [c[name] for name in get_model(lens.name).coefficients]
    return np.array([*model, c["d"] / lens.unit_px, c["e"] / lens.unit_px])


def wavering(seed: int = 3) -> list[Array]:
    """16 lines of 12 picks that no lens makes quite straight."""
    shown = TrueLens("division", {"l1": -0.1})
    return shown.lines(noise_px=3.0, seed=seed)


def straightening(name: str, **centre: float) -> TrueLens:
    return TrueLens(name, {**STRONG[name], **centre}, focal_px=FOCAL_PX)


@every_model
@pytest.mark.parametrize("centre", [{}, {"d": 31.0, "e": -22.0}])
def test_residuals_agree_with_svd_and_numerical_derivatives(
    name: str, centre: dict[str, float]
) -> None:
    lens, lines = straightening(name, **centre), wavering()
    packed = packed_for(lens, lines)
    value = computed(lens, vector(lens), packed.block)[0]
    for kind, in_photo in (("corrected", False), ("image", True)):
        ours = np.split(packed.unpack(getattr(value, kind)), np.cumsum(packed.sizes)[:-1])
        theirs = truth.distances_px(lens, lines, in_photo=in_photo)
        assert max(float(np.max(np.abs(each))) for each in theirs) > 2
        for one, other in zip(ours, theirs, strict=True):
            sign = 1.0 if one @ other > 0 else -1.0
            np.testing.assert_allclose(sign * one, other, rtol=1e-8, atol=1e-7)
    assert np.all(value.excess == 0)


@every_model
def test_determinant_is_the_local_area(name: str) -> None:
    lens, lines, h = straightening(name, d=10.0), wavering(), 0.05
    packed = packed_for(lens, lines)
    value = computed(lens, vector(lens), packed.block)[0]
    points = np.concatenate(lines)
    right, down = np.array([h, 0.0]), np.array([0.0, h])
    x = (lens.undistort(points + right) - lens.undistort(points - right)) / (2 * h)
    y = (lens.undistort(points + down) - lens.undistort(points - down)) / (2 * h)
    area = x[:, 0] * y[:, 1] - x[:, 1] * y[:, 0]
    np.testing.assert_allclose(packed.unpack(value.determinant), area, rtol=1e-6)


@every_model
@pytest.mark.parametrize("share", [1.0, 1e-9, 0.0], ids=["strong", "nearly zero", "zero"])
def test_jacobian_agrees_with_central_differences(name: str, share: float) -> None:
    """In all coefficients and the centre, fourth order."""
    lens, lines = straightening(name, d=31.0, e=-22.0), wavering()
    block = packed_for(lens, lines).block
    c, h = share * vector(lens), 1e-4
    derivative = computed(lens, c, block)[1]
    kernel = np.array([1.0, -8.0, 8.0, -1.0]) / 12 / h
    for index in range(len(c)):
        around = [
            computed(lens, c + k * h * np.eye(len(c))[index], block)[0] for k in (-2, -1, 1, 2)
        ]
        for kind in ("image", "corrected"):
            difference = np.tensordot(kernel, np.array([getattr(at, kind) for at in around]), 1)
            ours = getattr(derivative, kind)[..., index]
            size = np.max(np.abs(difference))
            # Without distortion the centre does not matter.
            assert size > 1.0 or (share < 1 and index >= len(c) - 2)
            np.testing.assert_allclose(ours, difference, rtol=0, atol=1e-6 * size + 1e-5)


@every_model
def test_padding_and_empty_rows_are_zero_and_never_nan(name: str) -> None:
    lens, lines = straightening(name), wavering()
    padded = [*lines[:5], *[points[:3] for points in lines[5:]]]  # 21 of 32 rows used, or fewer
    block = _like(packed_for(lens, padded).block, 32)
    nothing = block.weight == 0
    assert 100 < np.count_nonzero(nothing) < block.weight.size
    for c in (vector(lens), np.zeros(len(vector(lens)))):
        for at in computed(lens, c, block):
            for values in at:
                assert np.all(np.isfinite(values))
        value, derivative = computed(lens, c, block)
        for kind in ("image", "corrected", "excess"):
            assert np.all(getattr(value, kind)[nothing] == 0)
            assert np.all(getattr(derivative, kind)[nothing] == 0)


def _like(block: Block, rows: int) -> Block:
    """The same points in more rows."""
    more = rows - block.weight.shape[0]
    last = np.full(more, rows - 1, dtype=np.int32)
    used = np.where(block.weight.any(axis=1), block.row_line, rows - 1).astype(np.int32)
    return Block(
        np.concatenate((block.xy, np.zeros((more, *block.xy.shape[1:])))),
        np.concatenate((block.weight, np.zeros((more, block.weight.shape[1])))),
        np.concatenate((used, last)),
    )


def test_the_size_of_the_bucket_changes_nothing() -> None:
    lens, lines = straightening("ptlens"), wavering()
    packed = packed_for(lens, lines)
    assert packed.shape == (32, 8)
    usual = computed(lens, vector(lens), packed.block)
    larger = computed(lens, vector(lens), _like(packed.block, 64))
    for one, other in zip(usual, larger, strict=True):
        for kind in ("image", "corrected"):
            a, b = packed.unpack(getattr(one, kind)), getattr(other, kind)[:32]
            np.testing.assert_allclose(a, packed.unpack(b), rtol=0, atol=1e-9)


def test_the_width_of_the_bucket_changes_nothing() -> None:
    """Points of one line over several rows, or all in one, as they come to fall."""
    lens, lines = straightening("ptlens"), wavering()
    packed = packed_for(lens, lines)
    points = normalised(lens, lines)
    wide = Block(
        np.array([np.vstack((each, np.zeros((20, 2)))) for each in points]),
        np.array([np.repeat([1.0, 0.0], [12, 20])] * 16),
        np.arange(16, dtype=np.int32),
    )
    usual, other = (computed(lens, vector(lens), block)[0] for block in (packed.block, wide))
    for kind in ("image", "corrected"):
        expected = getattr(other, kind)[:, :12].ravel()
        np.testing.assert_allclose(packed.unpack(getattr(usual, kind)), expected, rtol=0, atol=1e-9)


def test_every_point_comes_back_from_its_cell() -> None:
    rng = np.random.default_rng(0)
    lens = straightening("ptlens")
    lines = [rng.uniform(0, 1000, (n, 2)) for n in (3, 8, 9, 16, 17, 4)]
    packed = packed_for(lens, lines)
    assert packed.block.weight.sum() == sum(len(line) for line in lines)
    points = np.concatenate(normalised(lens, lines))
    np.testing.assert_allclose(packed.unpack(packed.block.xy), points, rtol=0, atol=1e-15)
    numbers = np.repeat(np.arange(6), [len(line) for line in lines])
    of_cell = np.broadcast_to(packed.block.row_line[:, None], packed.block.weight.shape)
    np.testing.assert_array_equal(packed.unpack(of_cell), numbers)
    rows, width = packed.shape
    assert rows & (rows - 1) == 0
    assert width & (width - 1) == 0


DIRECTIONS = {
    "level": (1.0, 0.0),
    "upright": (0.0, 1.0),
    "diagonal": (1.0, 1.0),
    "other diagonal": (1.0, -1.0),
    "nearly level": (1.0, 1e-9),
    "nearly upright": (1e-9, 1.0),
    "backwards": (-1.0, 0.0),
}


@pytest.mark.parametrize("direction", DIRECTIONS.values(), ids=DIRECTIONS)
def test_directions_of_lines_are_all_alike(direction: tuple[float, float]) -> None:
    """Picks off a line by known amounts stay off it by them, whichever way it runs."""
    along = np.array(direction) / np.hypot(*direction)
    across = np.array([-along[1], along[0]])
    # Off by a pattern free of offset and slope, so that the best line is the line itself.
    t = np.arange(-5.5, 6)
    off = 0.5 * (t**2 - np.mean(t**2))
    points = np.array([1499.5, 1124.5]) + 150 * t[:, None] * along + off[:, None] * across
    lens = TrueLens("ptlens", {})
    lines = [points + np.array([3.0 * i, 2.0 * i]) for i in range(16)]
    packed = packed_for(lens, lines)
    value, derivative = computed(lens, vector(lens), packed.block)
    for kind in ("image", "corrected"):
        found = packed.unpack(getattr(value, kind)).reshape(16, 12)
        for each in found:
            sign = 1.0 if each @ off > 0 else -1.0
            np.testing.assert_allclose(sign * each, off, rtol=0, atol=1e-8)
    for values in (*value, *derivative):
        assert np.all(np.isfinite(values))


def test_points_without_a_direction_give_no_nan() -> None:
    """A square of picks lies along no line better than along another."""
    square = np.array([[0.0, 0.0], [100.0, 0.0], [100.0, 100.0], [0.0, 100.0]])
    lens = TrueLens("ptlens", {})
    lines = [np.tile(square, (3, 1)) + 40.0 * i for i in range(16)]
    value, derivative = computed(lens, vector(lens), packed_for(lens, lines).block)
    for values in (*value, *derivative):
        assert np.all(np.isfinite(values))
    assert 50.0 - 1e-9 <= np.max(np.abs(value.corrected)) <= 50.0 * np.sqrt(2) + 1e-9


def test_picks_beyond_the_fold_are_told_and_pushed_back() -> None:
    b = -0.3
    lens, lines = TrueLens("ptlens", {"b": b}), TrueLens("ptlens", {}).lines()
    packed = packed_for(lens, lines)
    value, derivative = computed(lens, vector(lens), packed.block)
    farthest = 2 / 3 * (1 - b) * np.sqrt((b - 1) / (3 * b))
    r = np.hypot(*np.concatenate(normalised(lens, lines)).T)
    excess = packed.unpack(value.excess)
    assert np.count_nonzero(r > farthest + 0.01) > 20
    # The fold is looked for on a grid here, so the excess is known to that.
    np.testing.assert_allclose(excess, np.maximum(r - farthest, 0), rtol=0, atol=0.01)
    for values in (*value, *derivative):
        assert np.all(np.isfinite(values))


def test_straightness_before_is_the_distance_from_a_straight_line() -> None:
    lines = wavering()
    for points in lines:
        centred = points - points.mean(axis=0)
        singular = np.linalg.svd(centred)[1]
        found = _across(points)
        assert np.sum(found**2) == pytest.approx(singular[1] ** 2, rel=1e-9)
        assert abs(found.sum()) < 1e-9
    along = np.linspace(0, 100, 5)
    assert np.max(np.abs(_across(np.stack((0 * along, along), -1)))) < 1e-12
    # Four pixels along x are four, however wide they are.
    upright = np.array([[100.0, 10.0], [104.0, 60.0], [104.0, 110.0], [100.0, 160.0]])
    wide = Observations.from_arrays([upright], (300, 200), pixel_aspect=1.5)
    np.testing.assert_allclose(np.abs(straightness_before(wide)[0]), 2.0, rtol=1e-12)

"""Eight numbers side by side do what numbers do, lane by lane."""

import numpy as np
import pytest
from numba import njit
from numba.core.errors import TypingError

from stickslip.compiling.compilation import compiled
from stickslip.compiling.vectors import aligned_zeros, broadcast, clipped, flush_to_zero, LANES, load, store

EDGES = np.array([-np.inf, -1.5, -0.0, 5e-324, 0.5, 1.0, np.nextafter(1.0, 2.0), np.nan])


@compiled
def arithmetic(left, right, out):
    one, other = load(left, 0), load(right, 0)
    store(out, 0, one + other)
    store(out, 8, one - other)
    store(out, 16, one * other)
    store(out, 24, one / other)
    store(out, 32, clipped(one))
    store(out, 40, flush_to_zero(one, 0.5))
    store(out, 48, broadcast(left[3]))


def test_each_lane_has_the_bits_of_its_number():
    left, right, out = np.random.default_rng(0).normal(size=8), np.arange(-3.0, 5.0), np.full((7, 8), np.nan)
    arithmetic(left, right, out)
    with np.errstate(divide="ignore"):
        expected = [left + right, left - right, left * right, left / right]
    np.testing.assert_array_equal(out[:4], expected)
    np.testing.assert_array_equal(out[4], np.clip(left, 0, 1))
    np.testing.assert_array_equal(out[5], np.where(np.abs(left) > 0.5, left, 0))
    np.testing.assert_array_equal(out[6], np.full(8, left[3]))


def test_lanes_at_the_edges():
    out = np.empty((7, 8))
    arithmetic(EDGES, np.ones(8), out)
    # What is no number is clipped to the lower end, and flushed.
    np.testing.assert_array_equal(out[4], [0, 0, 0, 5e-324, 0.5, 1, 1, 0])
    np.testing.assert_array_equal(out[5], [-np.inf, -1.5, 0, 0, 0, 1, EDGES[6], 0])
    arithmetic(np.array([-0.5, 0.5, np.nextafter(0.5, 1), -np.nextafter(0.5, 1), np.inf, 0, 0, 0]), np.ones(8), out)
    np.testing.assert_array_equal(out[5, :5], [0, 0, np.nextafter(0.5, 1), -np.nextafter(0.5, 1), np.inf])


@compiled
def moved(array, source, target):
    store(array, target, load(array, source))


def test_loads_and_stores_begin_anywhere_and_touch_eight_neighbours():
    """In a slice that begins at no multiple of a vector, over all axes."""
    for begin in range(3):
        room = np.arange(43.0)
        array = room[begin : begin + 40].reshape(2, 4, 5)
        expected = room.copy()
        expected[begin + 21 : begin + 29] = room[begin + 3 : begin + 11]
        moved(array, 3, 21)
        np.testing.assert_array_equal(room, expected)


@pytest.mark.parametrize(
    "array",
    [np.zeros((8, 8)).T, np.zeros(16)[::2], np.zeros(8, np.float32), np.zeros(8, np.int64)],
    ids=["turned", "with gaps", "single", "whole"],
)
def test_other_arrays_are_refused(array):
    @njit
    def reads(array):
        return store(np.zeros(8), 0, load(array, 0))

    @njit
    def writes(array):
        store(array, 0, broadcast(1.0))

    for kernel in (reads, writes):
        with pytest.raises(TypingError):
            kernel(array)


@pytest.mark.parametrize("shape", [(3,), (8,), (2, 3, 8), (1, 1)])
def test_aligned_zeros_begin_a_line_of_the_cache(shape):
    arrays = [aligned_zeros(*shape) for _ in range(20)]
    for array in arrays:
        assert array.shape == shape
        assert array.dtype == np.float64
        assert array.flags.c_contiguous
        assert not array.any()
        assert array.ctypes.data % (8 * LANES) == 0
        array[:] = 1
    assert not aligned_zeros(*shape).any()

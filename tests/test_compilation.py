"""Kernels compile with or without a place for their cache."""

import pytest

import stickslip.compilation
from stickslip.compilation import compiled


def halve(x):
    return x / 2.0


def invert(x):
    return 1.0 / x


def test_a_kernel_gives_what_the_function_gives():
    assert compiled(halve)(3.0) == 1.5


def test_division_by_zero_is_numpys():
    assert compiled(invert)(0.0) == float("inf")


@pytest.mark.parametrize("writable", [True, False])
def test_a_place_for_the_cache_is_used_where_there_is_one(monkeypatch, writable):
    asked = []

    def njit(**options):
        asked.append(options.get("cache", False))
        if options.get("cache") and not writable:
            raise RuntimeError("cannot cache function: no locator available")
        return lambda kernel: kernel

    monkeypatch.setattr(stickslip.compilation, "njit", njit)
    assert compiled(halve)(3.0) == 1.5
    assert asked == ([True] if writable else [True, False])

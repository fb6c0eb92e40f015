"""Numbers drawn in compiled code are those that Python would draw."""

import numpy as np
import pytest

from stickslip.compiling.compilation import compiled
from stickslip.compiling.generators import next_uniform, whereabouts


@compiled
def drawn(function, state, out):
    for i in range(len(out)):
        out[i] = next_uniform(function, state)


@pytest.mark.parametrize("kind", [np.random.PCG64, np.random.MT19937, np.random.Philox])
def test_both_draw_from_one_stream(kind):
    generator, judge = np.random.Generator(kind(5)), np.random.Generator(kind(5))
    other = np.random.Generator(kind(6))
    function, state = (np.uint64(each) for each in whereabouts(generator))
    assert whereabouts(other)[1] != state
    out = np.empty(5)
    for _ in range(3):
        drawn(function, state, out)
        np.testing.assert_array_equal(out, judge.random(5))
        assert generator.random() == judge.random()
        assert generator.integers(0, 9) == judge.integers(0, 9)

"""The front that is shipped is that of the benchmark's results."""

import json
from pathlib import Path

import front as benchmark
import numpy as np
import pytest

from stickslip.explore.front import edge_of, front_at

SHIPPED = Path(__file__).parents[2] / "explore" / "front.json"


def test_it_is_what_the_benchmark_kept():
    results = json.loads(benchmark.RESULTS.read_text(encoding="utf-8"))
    assert json.loads(SHIPPED.read_text(encoding="utf-8")) == benchmark.shipped(benchmark.made_of(results))


@pytest.mark.parametrize(("dither", "nearest"), [(0.0, 0.05), (0.1, 0.1), (0.12, 0.1), (0.3, 0.25), (0.5, 0.25)])
def test_the_nearest_is_taken(dither, nearest):
    found, front = front_at(dither)
    assert found == nearest
    assert max(each["speed"] for each in front["policies"]) <= front["limit"] + 0.01


def test_the_edge_is_a_staircase_over_all_words():
    _, front = front_at(0.1)
    speeds, memories = edge_of(front)
    assert (np.diff(speeds) >= 0).all()
    assert (np.diff(memories) <= 0).all()
    for each in [*front["open loop"], *front["held"]]:
        assert memories[speeds >= each["speed"]].max() >= each["memory"]

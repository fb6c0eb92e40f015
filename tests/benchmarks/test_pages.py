"""The tables of the docs are those of the results that are kept, and are made of them as they say."""

import importlib
import json
import sys
from types import ModuleType

import pytest
import remeasured
from measuring import refreshed


def kept(script):
    return json.loads(script.RESULTS.read_text(encoding="utf-8"))


def of_memory_reward(script, results):
    targets = results["targets"]
    return {
        "reward": script.table(results["cases"]),
        "adversaries": script.adversaries(results["greedy"]),
        "targets": script.target_table(targets["cases"]),
        "target adversaries": script.adversaries(targets["greedy"]),
    }


def of_reservoir_speed(script, results):
    return {"speed": script.markdown({(row.pop("task"), row.pop("features")): row for row in results["rows"]})}


def of_readout_penalty(script, results):
    records = {
        name: [script.Record(each["task"], each["reservoir"], each["seed"], each["value"], {}) for each in every]
        for name, every in results["scores"].items()
    }
    return {"penalty": script.markdown(script.changes(**records))}


TABLES = {
    "claims": lambda script, results: script.tables(results),
    "condition_cost": lambda script, results: {"condition": script.table(results["ratios"])},
    "edge": lambda script, results: script.tables(results),
    "encodings": lambda script, results: {"encodings": script.markdown(results["rows"])},
    "explore": lambda script, results: {"answers": script.table(results["milliseconds"])},
    "exponents": lambda script, results: script.tables(results),
    "extremes": lambda script, results: {"extremes": script.table(results)},
    "front": lambda script, results: script.tables(results),
    "front_targets": lambda script, results: script.tables(results),
    "identification": lambda script, results: script.tables(results),
    "lyapunov_cost": lambda script, results: {"lanes": script.table(results["ratios"])},
    "map_speed": lambda script, results: script.tables(results),
    "memory_reward": of_memory_reward,
    "peers": lambda script, results: {
        "peers": script.goals_table(results["at equal error"]),
        "calls": script.calls_table(results["one hold"]),
    },
    "readout_penalty": of_readout_penalty,
    "reservoir_speed": of_reservoir_speed,
    "robustness": lambda script, results: script.tables(results["found"]),
    "scenes": lambda script, results: {
        "scenes": script.scene_table(results["scenes"]),
        "agreements": script.agreement_table(results["disagreements"]),
    },
    "size_and_start": lambda script, results: script.tables(results),
    "solver_choice": lambda script, results: {"choice": script.choice_table(results)},
    "vector_speed": lambda script, results: script.tables(results),
}


@pytest.fixture
def script(request, monkeypatch):
    """A benchmark, whether or not its peers are installed."""
    for name in ("reservoirpy", "reservoirpy.jax", "reservoirpy.jax.nodes", "reservoirpy.nodes"):
        monkeypatch.setitem(sys.modules, name, ModuleType(name))
    return remeasured._encodings() if request.param == "encodings" else importlib.import_module(request.param)


@pytest.mark.parametrize(("script", "tables"), TABLES.items(), indirect=["script"], ids=TABLES)
def test_the_tables_are_those_of_the_results(script, tables):
    page = script.PAGE.read_text(encoding="utf-8")
    made = tables(script, kept(script))
    assert made
    assert refreshed(page, made) == page

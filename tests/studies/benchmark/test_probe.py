"""Probes tell tasks, measures and reservoirs apart, and are the same again."""

from dataclasses import replace

import numpy as np

from stickslip.studies.benchmark.probe import probes, reservoir_probe, task_probe
from stickslip.tasks import BodyReservoir, EchoState, known_reservoirs, MEASURES, TASKS


def test_probes_are_the_same_again_and_tell_series_tasks_apart():
    found = {name: task_probe(task) for name, task in TASKS.items()}
    assert found == {name: task_probe(task) for name, task in TASKS.items()}
    assert len(set(found.values())) == len(TASKS)


def test_a_reservoir_that_changed_has_another_probe():
    for reservoir in known_reservoirs(6).values():
        assert reservoir_probe(reservoir) == reservoir_probe(reservoir)
    assert reservoir_probe(BodyReservoir()) != reservoir_probe(BodyReservoir({"duffing": 0.51}))
    tuned = EchoState(6, tune=True)
    assert len(reservoir_probe(tuned)) == 1 + len(tuned.candidates)
    assert reservoir_probe(tuned) != reservoir_probe(replace(tuned, leak=0.99))


def test_what_is_stored_names_task_and_reservoir():
    stored = probes({"echo index": MEASURES["echo index"]}, {"line": known_reservoirs(6)["delay line"]})
    assert stored["tasks"]["echo index"]["made of"].startswith("EchoIndex(metric=Metric(name='index', solve=_echo_")
    assert stored["reservoirs"]["line"]["made of"] == "DelayLine(features=6)"


def test_probes_are_these_measurements():
    """Kept pages were made by them: 700 bits or samples of seed 0, 60 washed out, and 40 samples of a series."""
    small = BodyReservoir(hold=1.0, virtual_nodes=2)
    for name in ("memory capacity", "NARMA-2 NRMSE"):
        expected = TASKS[name].attempt(small, length=700, seed=0, washout=60).score
        assert task_probe(TASKS[name]) == float(f"{expected:.6g}")
    series = np.random.default_rng(0).random(40)
    tuned = EchoState(6, tune=True)
    sizes = [float(f"{np.abs(each(series, 0)).mean():.6g}") for each in (tuned, *tuned.candidates)]
    assert reservoir_probe(tuned) == sizes

"""Reservoirs by name: every argument has the effect that it promises, judged by `simulate` and the network itself."""

from dataclasses import replace

import numpy as np
import pytest

from stickslip.crawler import Actuator, Groups, Scene, simulate
from stickslip.reservoir import EchoStateNetwork
from stickslip.tasks import (
    body_states,
    BodyReservoir,
    crawler_states,
    DelayLine,
    EchoState,
    encode,
    known_reservoirs,
    RESERVOIRS,
)

SERIES = np.random.default_rng(0).random(24)
USUAL = {
    "groups": None,
    "scene": None,
    "hold": 0.5,
    "encoding": "pulse_width",
    "holds_per_sample": 1,
    "virtual_nodes": 4,
    "readings": ("deformation", "velocity", "pressure"),
    "tolerance": 1e-9,
}
CHANGES = [
    {"groups": {"duffing": 2.0, "kinetic_friction": 0.05}},
    {"groups": "linear"},
    {"scene": {"slope": 0.1}},
    {"scene": Scene(anchored=True)},
    {"scene": {"segments": 2, "tube_mass": 0.4}},
    {"hold": 1.3},
    {"encoding": "threshold"},
    {"encoding": "sigma_delta", "holds_per_sample": 4},
    {"holds_per_sample": 2},
    {"holds_per_sample": 3, "virtual_nodes": 6},
    {"virtual_nodes": 1},
    {"readings": ("foot_velocity", "pressure")},
    {"readings": "velocity"},
    {"tolerance": 1e-3},
]


def read_by_hand(groups, scene, hold, encoding, holds_per_sample, virtual_nodes, readings, tolerance):
    """States of :data:`SERIES` from a run that is read 60 times a hold, of which the wanted readings are picked."""
    scene = Scene.of(scene)
    valve = encode(SERIES, encoding, holds_per_sample)
    motion = simulate(
        groups,
        valve,
        hold,
        scene=scene,
        tolerance=tolerance,
        samples_per_hold=virtual_nodes // np.gcd(virtual_nodes, holds_per_sample),
    )
    columns = []
    for reading in [readings] if isinstance(readings, str) else readings:
        chain = scene.segments > 1 and reading in ("deformation", "velocity")
        for signal in getattr(motion, f"segment_{reading}") if chain else [getattr(motion, reading)]:
            in_sample = len(signal) // len(SERIES)
            columns += [
                signal[(node + 1) * in_sample // virtual_nodes - 1 :: in_sample] for node in range(virtual_nodes)
            ]
    return np.column_stack(columns)


def test_a_body_by_default_is_the_usual_crawler_read_four_times():
    assert BodyReservoir() == BodyReservoir(**USUAL)
    np.testing.assert_array_equal(BodyReservoir()(SERIES), read_by_hand(**USUAL))


@pytest.mark.parametrize("change", CHANGES, ids=lambda change: "-".join(change))
def test_every_argument_of_a_body_is_heard(change):
    body = BodyReservoir(**change)
    states = body(SERIES, seed=3)
    np.testing.assert_array_equal(states, read_by_hand(**{**USUAL, **change}))
    usual = BodyReservoir()(SERIES)
    assert states.shape != usual.shape or (states != usual).any()
    assert body.features == states.shape[1] == len(body.feature_names)


def test_names_of_features_go_reading_by_reading():
    chain = BodyReservoir(
        scene={"segments": 2, "tube_mass": 0.4}, readings=("velocity", "foot_velocity"), virtual_nodes=2
    )
    assert chain.feature_names == [
        "velocity0_0", "velocity0_1", "velocity1_0", "velocity1_1", "foot_velocity_0", "foot_velocity_1"
    ]  # fmt: skip


def test_a_body_of_other_numbers():
    body = BodyReservoir({"duffing": 1.0}, {"ratchet": False}, virtual_nodes=2)
    assert body.varied({}) == body
    assert body.varied({"slope": 0.1, "hold": 0.25, "deborah": 0.7}) == BodyReservoir(
        {"duffing": 1.0, "deborah": 0.7}, {"ratchet": False, "slope": 0.1}, hold=0.25, virtual_nodes=2
    )
    assert body.varied({"amplitude": 2.0}).groups.duffing == 4.0
    with pytest.raises(ValueError, match="numbers has no 'wheels'"):
        body.varied({"wheels": 4})


def test_a_hold_in_seconds_is_that_of_the_actuator():
    actuator = Actuator.ecoflex()
    body = BodyReservoir(actuator, hold="20 ms")
    assert body.hold == pytest.approx(0.02 / actuator.scales.time, rel=1e-12)
    assert body == BodyReservoir(actuator, hold=body.hold)


CRAWLER_CHANGES = [change for change in CHANGES if set(change) <= {"groups", "scene", "hold", "tolerance"}]


@pytest.mark.parametrize("change", [{}, {"virtual_nodes": 2}, *CRAWLER_CHANGES], ids=lambda change: "-".join(change))
def test_crawler_states_are_those_of_a_body(change):
    np.testing.assert_array_equal(crawler_states(SERIES, **change), BodyReservoir(**change)(SERIES))


def test_a_motion_is_laid_out_by_hand():
    motion = simulate(Groups(), SERIES[:3], 0.5, samples_per_hold=2)
    row = [*motion.deformation[2:4], *motion.velocity[2:4], *motion.pressure[2:4]]
    np.testing.assert_array_equal(body_states(motion)[1], row)
    assert body_states(motion).shape == (3, 6)


@pytest.mark.parametrize("change", CHANGES[:8], ids=lambda change: "-".join(change))
def test_a_body_on_other_grounds_is_otherwise_the_same(change):
    """Only friction is the ground's; the other groups, the scene and the reading are the body's own."""
    body = BodyReservoir(**change)
    grounds = [(0.45, 0.1), (0.2, 0.2)]
    for states, (static, kinetic) in zip(body.on_grounds(SERIES, grounds), grounds, strict=True):
        groups = replace(body.groups, static_friction=static, kinetic_friction=kinetic)
        np.testing.assert_array_equal(states, replace(body, groups=groups)(SERIES))


@pytest.mark.parametrize("change", CHANGES, ids=lambda change: "-".join(change))
def test_a_body_is_stepped_on_with_all_its_arguments(change):
    body = BodyReservoir(**change)
    step = body.stepper(SERIES[:10])
    np.testing.assert_allclose([step(value) for value in SERIES[10:14]], body(SERIES)[10:14], rtol=0, atol=1e-7)


NETWORK = {"spectral_radius": 0.9, "input_scaling": 0.1, "leak": 1.0, "topology": "random"}
NETWORK_CHANGES = [
    {},
    {"spectral_radius": 0.5},
    {"input_scaling": 0.7},
    {"leak": 0.4},
    {"topology": "cycle"},
    {"topology": "orthogonal"},
]


@pytest.mark.parametrize("change", NETWORK_CHANGES, ids=str)
@pytest.mark.parametrize("centred", [False, True])
def test_every_argument_of_a_network_is_heard(change, centred):
    heard = 2 * SERIES - 1 if centred else SERIES
    for seed in (0, 5):
        expected = EchoStateNetwork(7, seed=seed, **{**NETWORK, **change}).states(heard)
        found = EchoState(7, centred=centred, **change)
        np.testing.assert_array_equal(found(SERIES, seed), expected)
        step = found.stepper(SERIES[:20], seed)
        np.testing.assert_allclose([step(float(value)) for value in SERIES[20:]], expected[20:], atol=1e-12)
    assert (expected != EchoState(7)(SERIES, 0)).any()


def test_a_network_is_tuned_over_this_grid():
    candidates = EchoState(5, tune=True, leak=0.8, topology="cycle").candidates
    grid = [(each.spectral_radius, each.input_scaling, each.centred) for each in candidates]
    assert grid == [
        (radius, scaling, centred)
        for radius in (0.5, 0.7, 0.9, 0.99)
        for scaling in (0.01, 0.05, 0.2, 1.0)
        for centred in (False, True)
    ]
    assert all(
        each == EchoState(5, *at[:2], leak=0.8, topology="cycle", centred=at[2])
        for each, at in zip(candidates, grid, strict=True)
    )
    assert EchoState(5) == EchoState(5, 0.9, 0.1, False, 1.0, "random", False)


def test_a_delay_line_holds_the_latest_sample_first():
    expected = np.column_stack([np.concatenate([np.zeros(lag), SERIES[: 24 - lag]]) for lag in range(3)])
    np.testing.assert_array_equal(DelayLine(3)(SERIES), expected)
    step = DelayLine(3).stepper(SERIES[:5])
    np.testing.assert_array_equal([step(value) for value in SERIES[5:8]], expected[5:8])


def test_the_known_reservoirs_one_by_one():
    body = {"groups": {"deborah": 0.7, "radial_coupling": 0.4}, "hold": 0.8, "tolerance": 1e-8}
    crawler = BodyReservoir(virtual_nodes=4, **body)
    anchored = replace(crawler, scene=Scene(anchored=True))
    chain = replace(crawler, scene=Scene(segments=4, tube_mass=0.3), virtual_nodes=1)
    known = known_reservoirs(12, segments=4, **body)
    assert known == {
        "crawler": crawler,
        "anchored": anchored,
        "linear": replace(anchored, groups=Groups(deborah=0.7, radial_coupling=0.0, duffing=0.0)),
        "pressure only": replace(anchored, readings=("pressure",), virtual_nodes=12),
        "chain of 4": chain,
        "delay line": DelayLine(12),
        "echo-state network": EchoState(12, tune=True),
        "cycle reservoir": EchoState(12, tune=True, topology="cycle"),
        "orthogonal network": EchoState(12, tune=True, topology="orthogonal"),
    }
    assert list(known) == [*list(known_reservoirs(12))[:4], "chain of 4", *list(RESERVOIRS)[5:]]
    assert known_reservoirs(24)["chain of 3"].virtual_nodes == 3  # of 7 readings, 21 fit into 24
    assert known_reservoirs() == known_reservoirs(12, segments=3) == RESERVOIRS
    assert known_reservoirs(3)["crawler"].features == 3


def test_a_scene_is_every_bodys_and_a_tube_keeps_its_mass():
    known = known_reservoirs(6, scene={"slope": 0.2, "tube_mass": 0.7})
    assert known["crawler"].scene == Scene(slope=0.2, tube_mass=0.7)
    assert known["linear"].scene == Scene(slope=0.2, tube_mass=0.7, anchored=True)
    assert known["chain of 3"].scene == Scene(slope=0.2, tube_mass=0.7, segments=3)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: known_reservoirs(0), "features must be a whole number >= 3, got 0"),
        (lambda: DelayLine(0), "features must be a whole number >= 1, got 0"),
        (lambda: BodyReservoir(hold=-1), r"hold must be in \(0, inf\), got -1"),
        (lambda: BodyReservoir(holds_per_sample=0), "holds_per_sample must be a whole number >= 1, got 0"),
        (lambda: BodyReservoir(encoding="morse"), "encoding must be one of .* got 'morse'"),
        (lambda: BodyReservoir(readings=()), r"readings must hold at least one reading and none twice, got \[\]"),
        (lambda: BodyReservoir(tolerance=0.5), r"tolerance must be in \[1e-15, 1e-2\], got 0.5"),
        (lambda: crawler_states([0.0, 1.5]), r"valve must be in \[0, 1\], got 1.5 at index 1"),
        (lambda: EchoState(3)([0.0, np.nan], 0), "series must be finite"),
    ],
)
def test_bad_input(call, message):
    with pytest.raises(ValueError, match=message):
        call()

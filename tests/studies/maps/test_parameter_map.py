"""Maps: each cell is what its crawler comes to alone, and a map that was broken off is the one that was not."""

import json
import os
import signal
import subprocess
import sys
import time
import warnings

import numpy as np
import pytest
import scipy.stats
import xarray as xr
import zarr

from stickslip import Actuator, Groups, lyapunov_spectrum, memory_capacity, simulate
from stickslip.reservoir import information_processing_capacity
from stickslip.studies.maps import in_si, Inputs, mapping, over_seeds, parameter_map
from stickslip.studies.maps.cells import FINISHED, GAVE_UP, NO_SUCH_BODY
from stickslip.studies.maps.store import MapStore
from stickslip.tasks import body_states, dithered, innovation

SHORT = {"holds": 160, "washout": 40, "delays": 4}
X, Y = "duffing=0.5,2", "deborah=0.3:1.2:3:log"


def test_each_cell_is_what_its_crawler_comes_to_alone():
    measures = ["memory", "parity", "speed", "work", "slips"]
    found = parameter_map(X, Y, measures=measures, seeds=[3, 8], hold=1.0, **SHORT)
    assert found["memory"].dims == ("deborah", "duffing", "seed")
    assert (found["status"] == FINISHED).all()
    for i, deborah in enumerate((0.3, 0.6, 1.2)):
        for j, duffing in enumerate((0.5, 2.0)):
            for k, seed in enumerate((3, 8)):
                valve = dithered(np.zeros(160, int), 0.5, seed)
                groups = Groups(duffing=duffing, deborah=float(found.deborah[i]))
                assert float(found.deborah[i]) == pytest.approx(deborah, rel=1e-14)
                motion = simulate(groups, valve, 1.0, tolerance=1e-6, samples_per_hold=4)
                states, flips = body_states(motion), valve - 0.5
                cell = found.isel(deborah=i, duffing=j, seed=k)
                memory = memory_capacity(states, flips, 4, washout=40)
                assert float(cell.memory) == memory.corrected
                assert np.array_equal(cell.memory_profile, memory.profile)
                pairs = flips * np.concatenate([[0.0], flips[:-1]])
                assert float(cell.parity_2) == memory_capacity(states, pairs, 4, washout=41).corrected
                assert float(cell.speed) == motion.foot[-1] / 160.0
                assert float(cell.work) == motion.work / 160
                assert float(cell.slips) == motion.slips / 160


def test_capacity_tells_degrees_and_rank():
    found = parameter_map("hold=0.5,1", measures="capacity", virtual_nodes=1, holds=700, seeds=[2])
    valve = dithered(np.zeros(700, int), 0.5, 2)
    states = body_states(simulate(Groups(), valve, 1.0, tolerance=1e-6))
    alone = information_processing_capacity(states, valve - 0.5, delays=(40, 30, 20))
    assert found.capacity.sel(hold=1.0, seed=2).values.tolist() == list(alone.by_degree().values())
    assert float(found["rank"].sel(hold=1.0, seed=2)) == alone.rank == 3


def test_exponents_are_those_of_each_crawler_alone():
    found = parameter_map(X, measures="lyapunov", seeds=[4, 5], scene={"anchored": True}, tolerance=1e-9, **SHORT)
    valve = dithered(np.zeros(160, int), 0.5, 5)
    alone = lyapunov_spectrum({"duffing": 2.0}, valve, 0.5, scene={"anchored": True}, washout=40)
    cell = found.sel(duffing=2.0, seed=5)
    assert [float(cell.lyapunov), float(cell.lyapunov_2)] == alone.exponents.tolist()
    assert float(cell.lyapunov_standard_error) == alone.standard_error[0]


def test_exponents_of_a_chain_are_the_first_two_of_all_its_stretches_and_rates():
    chain = {"segments": 2, "tube_mass": 0.3, "anchored": True}
    found = parameter_map(
        "damping_ratio=0.05,0.2", measures=["lyapunov", "start"], scene=chain, tolerance=1e-9, **SHORT
    )
    valve = dithered(np.zeros(160, int), 0.5, 0)
    alone = lyapunov_spectrum({"damping_ratio": 0.2}, valve, 0.5, scene=chain, washout=40)
    cell = found.sel(damping_ratio=0.2, seed=0)
    assert [float(cell.lyapunov), float(cell.lyapunov_2)] == alone.exponents.tolist()
    assert float(cell.start_difference) < 1e-3 < float(found.start_difference.sel(damping_ratio=0.05, seed=0))


def test_two_starts_come_together_as_fast_as_a_linear_body_forgets():
    linear = {"duffing": 0.0, "radial_coupling": 0.0, "damping_ratio": 0.05, "deborah": 0.1}
    found = parameter_map(
        ("damping_ratio", [0.0, 0.05, 0.1]), measures="start", groups=linear, scene={"anchored": True}, **SHORT
    )
    kept = found.start_difference.values[:, 0]
    assert 0.1 < kept[0] < 10.0
    # Over the last 16 of 160 holds, changes shrink as exp(-Pi2 t / (1 - r)).
    assert kept[1] == pytest.approx(np.exp(-0.05 * 76.0 / 0.7), rel=0.5)
    assert kept[2] == pytest.approx(np.exp(-0.1 * 76.0 / 0.7), rel=0.7)


def test_scene_hold_and_dither_vary_too_and_a_chain_is_read_segment_by_segment():
    word = np.resize([0, 1, 1], 160)
    found = parameter_map("slope=0,0.05", "dither=0.1,0.5", inputs="word:011", measures=["memory", "speed"], **SHORT)
    valve = dithered(word, 0.1, 0)
    motion = simulate(Groups(), valve, 0.5, scene={"slope": 0.05}, tolerance=1e-6, samples_per_hold=4)
    cell = found.sel(slope=0.05, dither=0.1, seed=0)
    assert float(cell.speed) == motion.foot[-1] / 80.0
    memory = memory_capacity(body_states(motion), innovation(valve, word, 0.1), 4, washout=40)
    assert float(cell.memory) == memory.corrected

    chain = {"segments": 2, "tube_mass": 0.3, "anchored": True}
    found = parameter_map("hold=0.5,1", scene=chain, virtual_nodes=1, inputs=Inputs("1", 0.4), **SHORT)
    command = np.ones(160, int)
    valve = dithered(command, 0.4, 0)
    motion = simulate(Groups(), valve, 1.0, scene=chain, tolerance=1e-6)
    states = np.vstack([motion.segment_deformation, motion.segment_velocity, motion.pressure]).T
    memory = memory_capacity(states, innovation(valve, command, 0.4), 4, washout=40)
    assert float(found.memory.sel(hold=1.0, seed=0)) == memory.corrected


def test_what_has_no_body_or_does_not_stay_is_left_out_and_said():
    found = parameter_map("kinetic_friction=0.1,0.3", "static_friction=0.2,0.4", measures="speed", **SHORT)
    assert found.status.values.tolist() == [[FINISHED, NO_SUCH_BODY], [FINISHED, FINISHED]]
    assert np.isnan(found.speed.values[..., 0]).tolist() == [[False, True], [False, False]]
    many = {"measures": "speed", "groups": {"duffing": 0.0}, "hold": 30.0, "seeds": 2, "holds": 20}
    found = parameter_map("radial_coupling=0.5,5,0.7", **many)
    assert found.status.values.tolist() == [FINISHED, FINISHED, GAVE_UP]
    alone = simulate({"duffing": 0.0, "radial_coupling": 0.7}, dithered([0] * 20, 0.5, 1), 30.0, tolerance=1e-6)
    assert float(found.speed.sel(radial_coupling=0.7, seed=1)) == alone.foot[-1] / 600.0
    assert np.isnan(found.speed.sel(radial_coupling=5.0)).all()


class Stop(Exception):
    """What breaks a map off."""


def broken_off(after, **asked):
    def stop(done, of):
        if done >= after:
            raise Stop

    with pytest.raises(Stop):
        parameter_map(X, Y, on_progress=stop, **asked)


def test_a_map_that_was_broken_off_is_the_one_that_was_not_and_nothing_is_done_twice(tmp_path, monkeypatch):
    asked = {"measures": ["memory", "work"], "seeds": 2, **SHORT}
    whole = parameter_map(X, Y, **asked)
    store = tmp_path / "runs" / "map.zarr"
    broken_off(2, store=store, **asked)
    monkeypatch.setattr(mapping, "as_done", counted(mapping.as_done, jobs := []))
    told = []
    found = parameter_map(X, Y, store=store, on_progress=lambda *of: told.append(of), **asked)
    assert told == [(2, 6), (4, 6), (6, 6)]
    assert [job.block.row for job in jobs] == [1, 2]
    xr.testing.assert_identical(found, whole)
    xr.testing.assert_identical(parameter_map(X, Y, store=store, **asked), whole)
    assert len(jobs) == 2
    assert [file.name for file in store.parent.iterdir()] == ["map.zarr"]
    with warnings.catch_warnings(action="error"):
        opened = xr.open_zarr(store)
    assert opened.memory.attrs == {"long_name": "memory capacity", "units": "1", "valid_min": 0.0}
    assert opened.deborah.attrs == {"long_name": "deborah", "units": "1", "symbol": "Pi4"}


def counted(as_done, jobs):
    def done(work, asked, **sharing):
        jobs.extend(asked)
        return as_done(work, asked, **sharing)

    return done


def test_half_a_block_is_done_again(tmp_path, monkeypatch):
    """A process that is killed between the variables of a block leaves some of them behind."""
    store = tmp_path / "map.zarr"
    asked = {"measures": ["work", "speed"], **SHORT}
    whole = parameter_map(X, Y, store=store, **asked)
    group = zarr.open_group(store, mode="r+")
    group["status"][1] = 0
    group["speed"][1] = 7.0
    xr.testing.assert_identical(parameter_map(X, Y, store=store, **asked), whole)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"seeds": 2}, r"seeds must be \[0\] to go on with the map in .*map.zarr, got \[0, 1\]"),
        ({"hold": 0.25}, "hold must be 0.5 to go on with the map in .*map.zarr, got 0.25"),
        ({"groups": {"foot_mass_fraction": 0.4}}, "groups.foot_mass_fraction must be 0.3 .*, got 0.4"),
        ({"measures": "work"}, r"measures must be \['speed'\] .*, got \['work'\]$"),
        ({"inputs": "bernoulli:0.2"}, "inputs.dither must be 0.5 .*, got 0.2"),
    ],
)
def test_a_store_of_another_map_is_refused(tmp_path_factory, changed, message):
    store = tmp_path_factory.getbasetemp() / "other" / "map.zarr"
    asked = {"measures": "speed", **SHORT}
    first = parameter_map(X, store=store, **asked)
    with pytest.raises(ValueError, match=message):
        parameter_map(X, store=store, **{**asked, **changed})
    xr.testing.assert_identical(parameter_map(X, store=store, **asked), first)


def test_a_measure_that_has_changed_since_is_told(tmp_path, monkeypatch):
    asked = {"measures": "speed", "store": tmp_path / "map.zarr", **SHORT}
    parameter_map(X, **asked)
    read = mapping.measured
    monkeypatch.setattr(mapping, "measured", lambda job: {name: 2 * each for name, each in read(job).items()})
    with pytest.raises(ValueError, match=r"probe\.speed must be .* to go on with the map"):
        parameter_map(X, **asked)


def test_a_store_that_is_no_map_is_refused(tmp_path):
    (tmp_path / "notes.txt").write_text("mine", encoding="utf-8")
    with pytest.raises(ValueError, match=r"store must be a map or not be there yet, got .* with something else"):
        parameter_map(X, measures="speed", store=tmp_path, **SHORT)
    (tmp_path / "zarr.json").write_text(json.dumps({"attributes": {}}), encoding="utf-8")
    with pytest.raises(ValueError, match="store must be a map or not be there yet"):
        parameter_map(X, measures="speed", store=tmp_path, **SHORT)
    assert (tmp_path / "notes.txt").read_text(encoding="utf-8") == "mine"


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"y": "duffing=1,2"}, "x and y must vary two numbers, got duffing twice"),
        ({"measures": "wisdom"}, r"measures has no 'wisdom'; allowed are \['memory'"),
        ({"measures": []}, r"measures must name one measure at least and none twice, got \[\]"),
        ({"measures": ["work", "work"]}, "measures must name one measure at least and none twice"),
        ({"inputs": "word:01"}, "inputs must be flipped with a dither above 0, or there is no message for memory"),
        ({"y": "dither=0,0.1"}, "inputs must be flipped with a dither above 0"),
        ({"holds": 100}, "holds must be at least 2[0-9]{2} for memory of 12 features after a washout of 200, got 100"),
        ({"seeds": 0}, "seeds must be a whole number >= 1, got 0"),
        ({"seeds": []}, "seeds must hold one at least and none twice"),
        ({"seeds": [1, 1]}, "seeds must hold one at least and none twice"),
        ({"seeds": [-1]}, "seeds must be a whole number >= 0, got -1"),
        ({"washout": -1}, "washout must be a whole number >= 0, got -1"),
        ({"delays": 0}, "delays must be a whole number >= 1, got 0"),
        ({"processes": 0}, "processes must be a whole number >= 1, got 0"),
    ],
)
def test_what_cannot_be_mapped_is_refused_in_one_sentence(tmp_path, asked, message):
    with pytest.raises(ValueError, match=message):
        parameter_map(X, store=tmp_path / "map.zarr", **asked)
    assert not (tmp_path / "map.zarr").exists()


def test_intervals_are_students_and_seeds_are_all_they_take():
    values = np.random.default_rng(0).normal(1.0, 2.0, (3, 2, 5))
    found = xr.Dataset(
        {"speed": (("y", "x", "seed"), values, {"units": "z_c / t_c"}), "status": (("y", "x"), np.ones((3, 2)))}
    )
    means = over_seeds(found, 0.9)
    errors = scipy.stats.sem(values, axis=-1)
    low, high = scipy.stats.t.interval(0.9, 4, values.mean(axis=-1), errors)
    np.testing.assert_allclose(means.speed, values.mean(axis=-1), rtol=1e-13)
    np.testing.assert_allclose(means.speed_error, errors, rtol=1e-12)
    np.testing.assert_allclose([means.speed_low, means.speed_high], [low, high], rtol=1e-10)
    assert means.speed_low.attrs["units"] == "z_c / t_c"
    assert means.status.equals(found.status)
    found.speed.attrs["valid_min"] = 0.0
    assert float(over_seeds(found, 0.9).speed_low.min()) == 0.0 > low.min()
    one = over_seeds(found.isel(seed=[0]))
    assert np.array_equal(one.speed, values[..., 0])
    assert np.isnan(one.speed_low).all()


def test_a_map_in_si_is_in_the_units_of_its_actuator():
    actuator = Actuator.ecoflex()
    found = parameter_map("hold=0.5,1", measures=["speed", "work"], groups=actuator, **SHORT)
    told, scales = in_si(found, actuator), actuator.scales
    np.testing.assert_allclose(told.hold, np.array([0.5, 1.0]) * scales.time, rtol=1e-15)
    motion = simulate(actuator, dithered([0] * 160, 0.5, 0), 1.0, tolerance=1e-6, samples_per_hold=4).in_si(actuator)
    assert float(told.speed[1, 0]) == pytest.approx(motion.foot[-1] / motion.time[-1], rel=1e-12)
    assert float(told.work[1, 0]) == pytest.approx(motion.work / 160, rel=1e-12)
    assert (told.hold.attrs["units"], told.speed.attrs["units"], told.work.attrs["units"]) == ("s", "m / s", "J")
    assert found.hold.values.tolist() == [0.5, 1.0]


@pytest.mark.slow
def test_other_processes_find_the_same(tmp_path):
    asked = {"measures": ["memory", "slips"], **SHORT}
    xr.testing.assert_identical(parameter_map(X, Y, processes=2, **asked), parameter_map(X, Y, **asked))


@pytest.mark.slow  # Dask tries for seconds, and fails otherwise in a process that was forked
def test_a_cluster_that_is_not_there_is_told_in_one_sentence(tmp_path):
    pytest.importorskip("distributed")
    import dask

    with (
        dask.config.set({"distributed.comm.timeouts.connect": "200ms"}),
        pytest.raises(ConnectionError, match=r"^dask must be a cluster that stays, got one that went away \(.*\) "),
    ):
        parameter_map(X, Y, measures="speed", dask="tcp://127.0.0.1:9", store=tmp_path / "map.zarr", **SHORT)
    found = parameter_map(X, Y, measures="speed", store=tmp_path / "map.zarr", **SHORT)
    assert (found.status == FINISHED).all()


LONG = {"measures": ["memory", "work"], "seeds": 2, "holds": 2000}
AXES = "duffing=0:20:4", "deborah=0.3:1.2:8:log"
MAPPED = f"import sys; from stickslip import parameter_map; parameter_map(*{AXES}, **{LONG}, store=sys.argv[1])"


@pytest.mark.slow
def test_a_map_that_was_killed_again_and_again_is_the_one_that_was_not(tmp_path):
    whole = parameter_map(*AXES, **LONG)
    store, kills = tmp_path / "map.zarr", 0
    for patience in np.random.default_rng(0).uniform(0.0, 0.1, 20):
        begun = finished(store)
        process = subprocess.Popen([sys.executable, "-c", MAPPED, str(store)])
        until = time.monotonic() + 100
        while process.poll() is None and finished(store) == begun:
            assert time.monotonic() < until
        time.sleep(float(patience))
        kills += process.poll() is None
        process.kill()
        if process.wait() == 0:
            break
        assert finished(store) > begun
    assert kills > 1
    xr.testing.assert_identical(parameter_map(*AXES, store=store, **LONG), whole)


def finished(store):
    """Blocks that are in a store."""
    return len(list((store / "status" / "c").rglob("0")))


@pytest.mark.slow
def test_a_cluster_of_two_does_each_cell_once_though_one_is_killed(tmp_path, monkeypatch):
    distributed = pytest.importorskip("distributed")
    asked = {"measures": ["memory", "work"], "seeds": 4}
    axes = "duffing=0:20:4", "deborah=0.3:1.2:12:log"
    whole = parameter_map(*axes, **asked)
    kept, killed = [], []
    keep = MapStore.keep
    monkeypatch.setattr(MapStore, "keep", lambda self, block, found: kept.append(block) or keep(self, block, found))
    here = distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    with here as cluster, distributed.Client(cluster) as client:
        workers = sorted(client.run(os.getpid).values())

        def kill(done, of):
            if done >= of // 3 and not killed:
                os.kill(workers[0], signal.SIGKILL)
                killed.append(workers[0])

        found = parameter_map(*axes, dask=client, store=tmp_path / "map.zarr", on_progress=kill, **asked)
    assert killed
    assert len(kept) == len(set(kept)) == 12
    xr.testing.assert_identical(found, whole)


@pytest.mark.slow
def test_a_cluster_that_goes_away_leaves_what_it_has_finished(tmp_path):
    distributed = pytest.importorskip("distributed")
    asked = {"measures": "memory", "seeds": 4, "store": tmp_path / "map.zarr"}
    axes = "duffing=0:20:4", "deborah=0.3:1.2:12:log"
    cluster = distributed.LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None)

    def end(done, of):
        if done >= of // 3:
            cluster.close()

    begun = time.monotonic()
    with pytest.raises(
        ConnectionError, match=r"after \d+ of 48 cells; they are kept in .*map.zarr: ask again to go on"
    ):
        parameter_map(*axes, dask=cluster.scheduler_address, on_progress=end, **asked)
    assert time.monotonic() - begun < 120
    told = []
    found = parameter_map(*axes, on_progress=lambda *of: told.append(of), **asked)
    assert told[0][0] >= 16
    assert (found.status == FINISHED).all()

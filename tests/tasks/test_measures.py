import warnings

import numpy as np
import pytest

from stickslip.reservoir import echo_state_property, information_processing_capacity
from stickslip.tasks import DelayLine, EchoState, random_bits, RESERVOIRS
from stickslip.tasks.measures import EchoIndex, InformationCapacityOfBits, KernelRank, MEASURES

RUN = {"length": 1500, "seed": 0, "washout": 100}


def test_a_delay_line_holds_as_many_bits_as_taps_and_nothing_else():
    found = InformationCapacityOfBits().attempt(DelayLine(4), **RUN)
    assert found.score == pytest.approx(4)
    assert found.details["rank"] == 4
    assert found.details["by degree"] == {"1": pytest.approx(4), "2": 0, "3": 0}


def test_a_parity_is_of_degree_2():
    def product(bits, _):
        signs = 2 * bits - 1
        return (signs * np.roll(signs, 3))[:, None]

    found = InformationCapacityOfBits().attempt(product, **RUN)
    # The basis is that of bits as biased as these came out.
    assert found.score == pytest.approx(1, abs=0.01)
    assert found.details["by degree"]["2"] > 0.99


def test_information_is_looked_for_at_these_delays_and_degrees():
    states = DelayLine(3)(bits := random_bits(1500, 0).astype(float))
    expected = information_processing_capacity(states, bits, max_degree=3, delays=(40, 30, 20), washout=100)
    found = InformationCapacityOfBits().attempt(DelayLine(3), **RUN)
    assert (found.score, found.details["rank"]) == (expected.total, expected.rank)
    assert found.details["by degree"] == {str(degree): each for degree, each in expected.by_degree().items()}
    assert InformationCapacityOfBits().attempt(DelayLine(3), **{**RUN, "washout": 300}).score != found.score


class Heard:
    """A reservoir that keeps what it hears, of as many features as asked for."""

    def __init__(self, features):
        self.features, self.series, self.seeds = features, [], []

    def __call__(self, series, seed):
        self.series.append(series)
        self.seeds.append(seed)
        return np.random.default_rng(len(self.series)).random((len(series), self.features))


@pytest.mark.parametrize(("which", "kinds"), [("kernel", 2), ("generalisation", 6)])
def test_the_streams_of_the_ranks(which, kinds):
    """Twice as many as features and two more of each kind; the similar ones share their last 10 of 100 bits."""
    reservoir = Heard(3)
    KernelRank(which).attempt(reservoir, length=1, seed=9, washout=7)
    _, *rest = reservoir.series
    assert len(rest) == kinds * 8
    assert {len(stream) for stream in reservoir.series} == {100}
    assert set(np.concatenate(rest).tolist()) == {0.0, 1.0}
    assert set(reservoir.seeds) == {9}
    for kind in range(kinds):
        streams = np.array(rest[8 * kind : 8 * kind + 8])
        same = (streams == streams[0]).all(axis=0)
        assert same[-10:].all() == (kind > 0)
        assert not same[:-10].all()
        assert not same[-11] or not same[-12] or not same[-13]
    endings = {tuple(rest[8 * kind][-10:]) for kind in range(1, kinds)}
    assert len(endings) == kinds - 1


@pytest.mark.parametrize(("share", "rank"), [(5e-3, 2), (6e-4, 1)])
def test_directions_below_a_thousandth_of_the_largest_do_not_count(share, rank):
    """A bit, and the bit with a share of the one before it: of the singular values one is about half that share."""

    def states(bits, _):
        signs = 2 * bits - 1
        return np.stack([signs, signs + share * np.roll(signs, 1)], axis=1)

    found = KernelRank("kernel").attempt(states, **{**RUN, "seed": 1})
    assert (found.score, found.details) == (rank, {"threshold": 1e-3})
    assert KernelRank("generalisation").attempt(states, **RUN).details == {"threshold": 1e-3}
    assert KernelRank() == KernelRank("kernel")


def test_the_starts_of_the_echo_index_differ_in_the_washout_alone():
    reservoir = Heard(2)
    EchoIndex().attempt(reservoir, length=40, seed=2, washout=15)
    streams = np.array(reservoir.series)
    assert streams.shape == (5, 40)
    np.testing.assert_array_equal(streams[:, :15], np.random.default_rng([2, 40]).integers(0, 2, (5, 15)))
    np.testing.assert_array_equal(streams[:, 15:], np.tile(random_bits(40, 2)[15:], (5, 1)))


def test_the_echo_index_is_measured_from_the_last_sample_that_differs():
    def starts_apart(bits, _):
        return np.cumsum(bits)[:, None]

    starts = np.random.default_rng([2, 40]).integers(0, 2, (5, 15)).sum(axis=1)
    states = starts[:, None] + np.concatenate([[0], np.cumsum(random_bits(40, 2)[15:])])
    with pytest.warns(UserWarning, match="no Lyapunov exponent"):
        expected = echo_state_property(states[:, :, None].astype(float))
    found = EchoIndex().attempt(starts_apart, length=40, seed=2, washout=15)
    assert found.score == expected.echo_index > 1
    assert found.details == {"exponent": None, "consistency": expected.consistency}


def test_measures_by_name_and_which_way_is_better():
    assert {name: (m.metric.name, m.metric.more_is_better, m.metric.chance) for name, m in MEASURES.items()} == {
        "information capacity": ("capacity", True, 0.0),
        "kernel rank above 0.001": ("rank", True, 0.0),
        "generalisation rank above 0.001": ("rank", False, 0.0),
        "echo index": ("index", False, 1.0),
    }
    assert MEASURES["kernel rank above 0.001"] == KernelRank("kernel")
    assert MEASURES["generalisation rank above 0.001"] == KernelRank("generalisation")


def test_what_has_no_exponent_does_not_warn():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        EchoIndex().attempt(DelayLine(4), **RUN)


def test_a_delay_line_tells_all_its_taps_apart_and_ignores_none_that_differ():
    """Of 14 taps the last 10 bits are shared by the similar streams: 4 are left to tell apart."""
    assert KernelRank("kernel").attempt(DelayLine(14), **RUN).score == 14
    assert KernelRank("generalisation").attempt(DelayLine(14), **RUN).score == 4
    assert KernelRank("generalisation").attempt(DelayLine(6), **RUN).score == 0


def test_a_network_that_contracts_forgets_and_one_that_counts_does_not():
    network = EchoIndex().attempt(EchoState(8, 0.5, 0.5), **RUN)
    assert network.score == 1
    assert network.details["exponent"] == pytest.approx(np.log(0.5), abs=0.4)
    assert network.details["consistency"] > 0.99
    counter = EchoIndex().attempt(lambda bits, _: np.cumsum(bits)[:, None], **RUN)
    assert counter.score > 1
    assert EchoIndex().attempt(DelayLine(4), **RUN).details["exponent"] is None


def test_a_measure_is_of_the_reservoir_as_it_is():
    """What has candidates to tune is not tuned."""
    network = RESERVOIRS["echo-state network"]
    plain = EchoState(network.features)
    assert network.candidates
    for measure in MEASURES.values():
        assert measure.attempt(network, **RUN) == measure.attempt(plain, **RUN)


def test_bad_input():
    with pytest.raises(ValueError, match=r"which has no 'rank'; allowed are \['kernel', 'generalisation'\]"):
        KernelRank("rank")
    with pytest.raises(ValueError, match="washout must be a whole number >= 1, got 0"):
        EchoIndex().attempt(DelayLine(3), length=500, seed=0, washout=0)
    with pytest.raises(ValueError, match="length must be a whole number >= 102, got 101"):
        EchoIndex().attempt(DelayLine(3), length=101, seed=0, washout=100)
    with pytest.raises(ValueError, match="seed must be a whole number >= 0, got -1"):
        KernelRank().attempt(DelayLine(3), **{**RUN, "seed": -1})

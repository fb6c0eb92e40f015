import numpy as np
import pytest

from stickslip.tasks import DelayLine, EchoState, RESERVOIRS
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
    with pytest.raises(ValueError, match="length must be a whole number >= 102, got 100"):
        EchoIndex().attempt(DelayLine(3), length=100, seed=0, washout=100)

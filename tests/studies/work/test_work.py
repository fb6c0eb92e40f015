"""Work over ensembles: against closed forms, and what its verdict follows."""

from dataclasses import replace

import numpy as np
import pytest
from legible import assert_legible
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from stickslip import Groups
from stickslip.crawler import State
from stickslip.studies.claims import work as claims
from stickslip.studies.claims.claim import Number
from stickslip.studies.work.ensembles import boltzmann_starts, far_starts, random_valves, works_of
from stickslip.studies.work.figure import plot_work
from stickslip.studies.work.jarzynski import average, gaussian_average
from stickslip.studies.work.smooth import smooth_works
from stickslip.studies.work.split import Split, split
from stickslip.studies.work.study import BETAS, Case, CASES, compare, COUNTS, Size, Spread, spread_of, Study

SMALL = Size(inputs=8, starts=3, holds=100, washout=100, paired=9, cycles=2, thermal=2)
LINEAR = Groups(duffing=0.0, radial_coupling=0.0, damping_ratio=0.05)
ANCHORED = {"anchored": True}


def exact_work(groups, valve, hold, start):
    """Of a linear anchored body: int p v dt, the exponential of the equations for all products of two states."""
    payload, lag = 1.0 - groups.foot_mass_fraction, groups.deborah
    work, state = 0.0, np.array([*start, 1.0])
    for bit in valve:
        rates = np.zeros((4, 4))
        rates[0, 1] = 1.0
        rates[1, :3] = -1.0 / payload, -2.0 * groups.damping_ratio / payload, 1.0 / payload
        rates[2, 2:] = -1.0 / lag, bit / lag
        products = np.zeros((17, 17))
        products[:16, :16] = np.kron(rates, np.eye(4)) + np.kron(np.eye(4), rates)
        products[16, 2 * 4 + 1] = 1.0  # p v
        work += (expm(products * hold) @ np.append(np.kron(state, state), 0.0))[16]
        state = expm(rates * hold) @ state
    return work


def test_the_work_of_a_linear_body_is_that_of_its_propagator():
    valves, starts = random_valves(2, 12), [State(0.1, -0.2, 0.3), State()]
    told = works_of(LINEAR, valves, starts, hold=0.5, scene=ANCHORED)
    exact = [[exact_work(LINEAR, valve, 0.5, start[:3]) for start in starts] for valve in valves]
    np.testing.assert_allclose(told.work, exact, rtol=1e-9)
    after = works_of(LINEAR, valves, starts, hold=0.5, scene=ANCHORED, washout=5)
    before = [[exact_work(LINEAR, valve[:5], 0.5, start[:3]) for start in starts] for valve in valves]
    np.testing.assert_allclose(after.work, np.array(exact) - before, rtol=1e-8, atol=1e-12)


SLIDING = Groups(static_friction=0.2)


def test_smooth_friction_is_what_its_equations_say():
    """Energies as a general solver has them, of a start and of what follows a washout."""
    body, valve, start, hold, width = SLIDING, random_valves(1, 8), State(0.3, -0.2, 0.4), 0.5, 0.2

    def rates(time, state):
        z, v, foot, p, *_ = state
        friction = 0.2 * np.tanh(foot / width)
        force = p * (1.0 + 0.2 * z) - z - 0.5 * z**3 - 0.1 * v
        opened = valve[0, min(int(time / hold), 7)]
        of_foot = (-force - friction) / 0.3
        return [
            v,
            force / 0.7 - of_foot,
            of_foot,
            2.0 * (opened - p),
            p * (1.0 + 0.2 * z) * v,
            0.1 * v**2,
            friction * foot,
        ]

    assert (body.duffing, body.radial_coupling, body.damping_ratio, body.deborah) == (0.5, 0.2, 0.05, 0.5)
    state, every = np.array([0.3, -0.2, 0.0, 0.4, 0.0, 0.0, 0.0]), []
    for place in range(8):
        ends = hold * place, hold * (place + 1) - 1e-12
        state = solve_ivp(rates, ends, state, method="DOP853", rtol=1e-10, atol=1e-12).y[:, -1]
        every.append(state[4:])
    told = smooth_works(body, valve, [start, State()], hold=hold, width=width)
    assert (told.work[0, 0], told.viscous[0, 0], told.friction[0, 0]) == pytest.approx(every[-1], abs=1e-5)
    assert told.residual < 1e-5
    after = smooth_works(body, valve, [start], hold=hold, width=width, washout=3)
    assert (after.work[0, 0], after.friction[0, 0]) == pytest.approx((every[-1] - every[2])[[0, 2]], abs=1e-5)
    np.testing.assert_allclose(after.work, after.stored + after.viscous + after.friction, atol=1e-5)


def test_friction_that_is_made_less_smooth_comes_to_that_of_a_foot_that_may_slide_back():
    valves = random_valves(3, 30)
    true = works_of(SLIDING, valves, [State()], hold=0.5, scene={"ratchet": False}).work
    off = [np.abs(smooth_works(SLIDING, valves, [State()], hold=0.5, width=w).work - true).max() for w in (0.1, 0.02)]
    assert off[1] < 0.4 * off[0]
    assert off[1] < 0.02 * true.max()
    assert spread_of(CASES["slides back on smooth friction"], replace(SMALL, holds=20, washout=20)).parts.share < 1e-2


def test_the_balance_closes_and_losses_are_losses():
    told = works_of(Groups(), random_valves(4, 30), far_starts(2), hold=0.5)
    assert told.residual < 1e-7
    np.testing.assert_allclose(told.work, told.stored + told.viscous + told.friction, atol=1e-6)
    assert (told.viscous > 0.0).all()
    assert (told.friction > 0.0).all()


def test_normal_work_has_the_average_that_is_known():
    beta, mean, variance = 1.5, 0.7, 0.25
    works = np.random.default_rng(0).normal(mean, variance**0.5, 40_000)
    told = average(works, beta)
    exact = gaussian_average(mean, variance, beta)
    assert told.interval[0] < exact < told.interval[1]
    assert told.error == pytest.approx(exact * (np.expm1(beta**2 * variance) / works.size) ** 0.5, rel=0.05)
    assert told.free_energy == pytest.approx(mean - 0.5 * beta * variance, abs=0.02)
    assert told.dissipated == pytest.approx(0.5 * beta * variance, abs=0.02)
    assert told.samples == pytest.approx(works.size * np.exp(-(beta**2) * variance), rel=0.05)


def test_few_runs_take_the_free_energy_too_high_by_the_bias():
    works = np.random.default_rng(0).normal(0.0, 1.0, (1500, 50))
    told = [average(each, 0.5) for each in works]
    off = np.mean([each.free_energy for each in told]) - (-0.25)
    assert off == pytest.approx(np.mean([each.bias for each in told]), rel=0.2)


def test_dissipation_is_never_negative_whatever_the_numbers():
    for works in (np.array([-3.0, 5.0]), np.array([30.0, -30.0, 0.0]), np.full(4, -2.0)):
        assert average(works, 7.0).dissipated >= -1e-12


def test_a_linear_body_that_conserves_energy_obeys_bochkov_and_kuzovlev_exactly():
    """Its work is a number and a linear function of the start: <W> = beta Var(W) / 2."""
    body, valves = replace(LINEAR, damping_ratio=0.0), np.array([[1, 0, 1, 1, 0, 0]])
    rest, far, moving = works_of(body, valves, [State(), State(1.0), State(0.0, 1.0)], hold=0.5, scene=ANCHORED).work[0]
    for beta in (0.5, 3.0):
        variance = ((far - rest) ** 2 + (moving - rest) ** 2 / 0.7) / beta
        assert gaussian_average(rest, variance, beta) == pytest.approx(1.0, rel=1e-8)


def test_a_stiffening_body_that_conserves_energy_obeys_it_too():
    body, valves = Groups(damping_ratio=0.0), np.array([[1, 0, 1]])
    starts = boltzmann_starts(body, 1.0, 400, 0)
    told = average(works_of(body, valves, starts, hold=0.5, scene=ANCHORED).work[0], 1.0)
    assert told.interval[0] < 1.0 < told.interval[1]
    assert told.error < 0.1


def test_starts_are_as_boltzmann_has_them():
    """Of a linear body both energies have the mean 1 / (2 beta); of a stiffening one <z H'(z)> = 1 / beta."""
    z, v = np.array([start[:2] for start in boltzmann_starts(LINEAR, 2.0, 20_000, 0)]).T
    assert np.mean(z**2) == pytest.approx(0.5, rel=0.05)
    assert 0.7 * np.mean(v**2) == pytest.approx(0.5, rel=0.05)
    z = np.array([start.deformation for start in boltzmann_starts(Groups(duffing=5.0), 2.0, 20_000, 0)])
    assert np.mean(z**2 + 5.0 * z**4) == pytest.approx(0.5, rel=0.05)


def test_variance_is_split_into_what_made_it():
    random = np.random.default_rng(0)
    works = 3.0 * random.standard_normal((800, 1)) + random.standard_normal((800, 5))
    told = split(works)
    assert told.of_inputs == pytest.approx(9.0, rel=0.15)
    assert told.of_starts == pytest.approx(1.0, rel=0.1)
    assert told.low < 0.1 < told.high
    only_inputs = split(np.repeat(random.standard_normal((20, 1)), 4, axis=1))
    assert (only_inputs.share, only_inputs.low, only_inputs.high) == (0.0, 0.0, 0.0)
    assert split(np.tile(random.standard_normal((1, 6)), (20, 1))).share == 1.0


def test_on_the_ground_inputs_spread_the_work_and_starts_do_not():
    told = spread_of(Case(Groups()), SMALL)
    assert told.parts.high < 1e-4
    ratio, low, high = told.relative
    assert 0.01 < low < ratio < high < 0.4
    works = works_of(Groups(), random_valves(9, 200), [State()], hold=0.5, washout=100).work[:, 0] / 100
    np.testing.assert_allclose(told.by_input, works, rtol=1e-5)
    assert (told.mean_work[0], told.deviation) == pytest.approx((works.mean(), works.std(ddof=1)), rel=1e-4)
    assert told.viscous + told.friction == pytest.approx(1.0, abs=0.05)
    assert spread_of(CASES["anchored and chaotic"], SMALL).parts.share > 0.3


def spread(share=1e-12, relative=0.01, noise=0.0):
    """Of a hundred inputs, the same in all but for the noise."""
    part = Split(1.0, share, share, 0.8 * share, 1.2 * share)
    by_input = 1.0 + relative * np.linspace(-1.0, 1.0, 100) + noise * np.random.default_rng(0).normal(size=100)
    return Spread(0.1 * by_input, part, 0.4, 0.6, 1e-9)


@pytest.mark.parametrize(
    ("changes", "verdict"),
    [
        ({}, "overturned"),
        ({"as it is": spread(share=0.05)}, "not reproduced"),
        ({"lag made fast": spread(relative=0.005, noise=0.005)}, "not reproduced"),
        ({"nearly undamped and stiff": spread(share=0.4)}, "reproduced in part"),
        ({"lag made fast": spread(relative=0.001)}, "reproduced in part"),
        ({"as it is": spread(share=0.5)}, "reproduced in part"),
        ({"as it is": spread(share=0.5), "lag made fast": spread(relative=0.001)}, "reproduced"),
    ],
)
def test_the_verdict_follows_the_spread(changes, verdict):
    assert claims.verdict({name: spread() for name in CASES} | changes) == verdict


def test_bodies_are_compared_under_the_same_inputs():
    ratio, low, high = compare(spread(relative=0.02), spread(relative=0.01))
    assert ratio == pytest.approx(2.0)
    assert (low, high) == pytest.approx((2.0, 2.0), rel=0.05)  # what either does under an input is that of the other
    ratio, low, high = compare(spread(noise=0.005), spread())
    assert low < ratio < high


def study():
    works = np.random.default_rng(0).normal(1.0, 0.2, 100)
    found = {beta: average(works, beta) for beta in BETAS}
    by_count = {(beta, count): average(works[:count], beta) for beta in BETAS for count in COUNTS if count <= 100}
    return Study({name: spread() for name in CASES}, works, 0.3, 1e-10, found, by_count, found, found)


def test_the_claim_says_its_numbers():
    told = claims.claim(claims.Work(study(), spread()))
    assert (told.name, told.verdict) == ("C10", "overturned")
    assert told.sentence.startswith(
        "Under random bits the work varies by 0.6% of its mean: a lag made fast leaves 1 [1"
    )
    assert told.sentence.endswith(
        "starts make nothing of the variance; so the lag does not, and stick-slip chaos does not."
    )
    assert "The balance of energy closes." in told.remark
    free = told.numbers["free energy by the average, beta = 1, 100 runs"]
    assert free.low < free.value < free.high
    work = told.numbers["work a hold (P_max A_0 z_c), anchored"]
    assert (work.value, work.high - work.low) == pytest.approx((0.1, 4 * 0.1 * 0.01 / 3**0.5 / 10), rel=0.05)
    assert told.numbers["taken by the ground, lag made fast"] == Number(0.6)
    bad = replace(study(), residual=1e-3)
    assert "The balance of energy does not close." in claims.claim(claims.Work(bad, spread())).remark


@pytest.mark.parametrize(
    ("fast", "said"),
    [
        (spread(relative=0.001), "so the lag adds to it,"),
        (spread(relative=0.005, noise=0.005), "so the lag cannot be told to,"),
        (spread(), "so the lag does not,"),
    ],
)
def test_what_is_said_of_the_lag_follows_its_interval(fast, said):
    spreads = {name: spread() for name in CASES} | {"lag made fast": fast}
    assert said in claims.claim(claims.Work(replace(study(), spreads=spreads), spread())).sentence


def test_the_figure_shows_bodies_and_averages():
    figure = plot_work(study())
    assert_legible(figure)
    left, middle, right = figure.axes
    assert [text.get_text() for text in left.get_yticklabels()] == list(CASES)
    assert len(middle.get_lines()) >= 6
    assert [text.get_text() for text in right.get_legend().get_texts()] == ["10", "30", "100"]

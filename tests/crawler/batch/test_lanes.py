"""A batch in lanes against the same crawlers one by one: every number, to the last bit."""

import numpy as np
import pytest
from cases import crawlers, HUNT
from hypothesis import given
from hypothesis import strategies as st
from lane_batches import alone, Batch, in_lanes, SAMPLES, taylor

from stickslip.compiling.vectors import LANES
from stickslip.crawler import Groups, Scene
from stickslip.crawler.model.columns import Share
from stickslip.crawler.model.state import Body
from stickslip.crawler.solvers import SOLVERS
from stickslip.crawler.steps.options import DIVERGED, FINISHED, OUT_OF_STEPS, TAYLOR
from stickslip.crawler.steps.taylor import order_for


def spread(rng, low, high):
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def random_members(rng, n):
    """Crawlers and scenes from all over the ranges, each its own."""
    members = []
    for _ in range(n):
        static = float(rng.choice([0.0, rng.uniform(0.0, 1.0), spread(rng, 1e-3, 1.0)]))
        groups = Groups(
            duffing=float(rng.choice([0.0, spread(rng, 1e-2, 1e3)])),
            damping_ratio=float(rng.choice([0.0, spread(rng, 1e-2, 5.0)])),
            deborah=spread(rng, 0.01, 10.0),
            radial_coupling=float(rng.uniform(0.0, 0.9)),
            foot_mass_fraction=float(rng.uniform(0.05, 0.95)),
            static_friction=static,
            kinetic_friction=static * float(rng.choice([0.0, 1.0, rng.uniform()])),
        )
        slope = float(rng.choice([0.0, rng.uniform(-0.3, 0.3)]))
        members.append(
            (groups, Scene(anchored=bool(rng.random() < 0.2), ratchet=bool(rng.random() < 0.5), slope=slope))
        )
    return members


class Guarded(Batch):
    """Around each array that is written lies memory that is not to be touched."""

    def __init__(self, members):
        super().__init__(members)
        self.wholes = []
        for name in ("bodies", "samples", "statuses", "elapsed"):
            array = getattr(self, name)
            whole = np.full((len(array) + 2, *array.shape[1:]), 77, array.dtype)
            whole[1:-1] = array
            setattr(self, name, whole[1:-1])
            self.wholes.append(whole)

    def advance(self, *arguments):
        super().advance(*arguments)
        self.check()

    def check(self):
        for whole in self.wholes:
            assert (whole[[0, -1]] == 77).all()


scenes = st.builds(Scene, anchored=st.booleans(), ratchet=st.booleans(), slope=st.sampled_from([0.0, 0.1, -0.2]))
bodies = st.tuples(
    st.floats(-1.0, 1.0),
    st.floats(-1.0, 1.0),
    st.floats(0.0, 1.0),
    st.sampled_from([0.0, 0.3]),
    st.sampled_from([0, 1, -1]),
)


@HUNT
@given(
    members=st.lists(st.tuples(crawlers, scenes, bodies), min_size=1, max_size=2 * LANES + 3),
    valves=st.lists(st.integers(0, 1), min_size=3, max_size=3),
    hold=st.floats(0.05, 3.0),
    tolerance=st.sampled_from([1e-3, 1e-6, 1e-9, 1e-15]),
)
def test_any_crawlers_in_any_motion(members, valves, hold, tolerance):
    columns = []
    for _, scene, (z, v, p, speed, motion) in members:
        motion = 0 if scene.anchored or (scene.ratchet and motion < 0) else motion
        columns.append([z, v, p, 0.0, motion * speed, motion, 0])
    batch = Batch([member[:2] for member in members], np.transpose(columns))
    for k in range(6):
        batch.advance([valves[(i + k) % 3] for i in range(len(members))], hold, taylor(tolerance))


@pytest.mark.parametrize("order", TAYLOR)
@pytest.mark.parametrize("seed", range(3))
def test_crawlers_from_anywhere_in_the_ranges(order, seed):
    rng = np.random.default_rng([order, seed])
    tolerance = {8: 1e-3, 12: 1e-6, 16: 1e-9, 20: 1e-13}[order]
    assert order_for(tolerance) == order
    batch = Batch(random_members(rng, 41))
    hold = spread(rng, 0.05, 5.0)
    for _ in range(12):
        batch.advance(rng.integers(0, 2, 41), hold, taylor(tolerance))
    assert (batch.statuses == FINISHED).all()
    assert batch.bodies[6].sum() > 10, "hardly anything has happened"


@pytest.mark.parametrize("n", [1, 2, LANES - 1, LANES, LANES + 1, 3 * LANES + 5])
def test_any_slice_of_any_number(n):
    rng = np.random.default_rng(n)
    batch = Guarded([(Groups(), Scene())] * n)
    for _ in range(4):
        batch.advance(rng.integers(0, 2, n), 0.5, taylor(1e-6))
    for begin, end in [(0, 0), (n, n), (0, n // 2), (n // 2, n), (n // 3, n - n // 3)]:
        batch.advance(rng.integers(0, 2, n), 0.5, taylor(1e-6), begin, end)


def test_crawlers_to_be_skipped_are_left_alone():
    rng = np.random.default_rng(0)
    n = 3 * LANES
    batch = Batch([(Groups(), Scene())] * n)
    for share in (0.3, 0.7, 1.0):
        batch.skip[:] = rng.random(n) < share
        batch.advance(rng.integers(0, 2, n), 0.5, taylor(1e-6))
    batch.skip[:] = False
    batch.skip[0] = batch.skip[-1] = True
    batch.advance(rng.integers(0, 2, n), 0.5, taylor(1e-6))


def test_a_crawler_that_diverges_leaves_its_neighbours_alone():
    unbounded = Groups(duffing=0.0, radial_coupling=2.0)
    members = [(unbounded if i % 5 == 2 else Groups(), Scene()) for i in range(2 * LANES + 1)]
    batch = Batch(members)
    batch.advance([1] * len(members), 60.0, taylor(1e-6))
    expected = [DIVERGED if i % 5 == 2 else FINISHED for i in range(len(members))]
    assert batch.statuses.tolist() == expected


def test_a_spent_budget_is_each_crawlers_own():
    # Forty steps are plenty for the default crawler's hold, and too few for one so stiff.
    members = [(Groups(damping_ratio=100.0) if i % 4 == 1 else Groups(), Scene()) for i in range(2 * LANES + 1)]
    batch = Batch(members)
    batch.advance([1] * len(members), 2.0, taylor(1e-6, max_steps=40))
    assert batch.statuses.tolist() == [OUT_OF_STEPS if i % 4 == 1 else FINISHED for i in range(len(members))]
    assert (batch.elapsed[1::4] < 2.0).all()


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e300])
def test_a_body_that_is_no_body_diverges_alone(value):
    bodies = np.zeros((7, LANES + 2))
    bodies[0, 3] = value
    batch = Batch([(Groups(), Scene())] * (LANES + 2), bodies)
    batch.advance([1] * (LANES + 2), 0.5, taylor(1e-6))
    assert batch.statuses.tolist() == [DIVERGED if i == 3 else FINISHED for i in range(LANES + 2)]


@pytest.mark.parametrize("groups", [Groups(duffing=1e4), Groups(deborah=1e-3), Groups(damping_ratio=10.0)], ids=str)
def test_extremes(groups):
    batch = Batch([(groups, Scene(ratchet=i % 2 == 0)) for i in range(LANES)])
    for k in range(4):
        batch.advance([(i + k) % 2 for i in range(LANES)], 0.5, taylor(1e-9))


LINEAR = Groups(duffing=0.0, radial_coupling=0.0)


@pytest.mark.parametrize(
    ("solver", "groups", "scene", "count"),
    [
        ("radau", Groups(), Scene(), 2),
        ("closed_form", LINEAR, Scene(), 2),
        ("closed_form", LINEAR, Scene(anchored=True), LANES),  # by one affine map for all
    ],
)
def test_radau_and_the_closed_form_take_the_same_call(solver, groups, scene, count):
    solver = SOLVERS[solver]
    options = solver.options(1e-6)
    batch = Guarded([(groups, scene)] * (count + 1))
    batch.workspace = solver.workspace(batch.members[0], 0.5, SAMPLES)
    single = np.zeros(7)
    for valve in (1, 1, 0):
        crawlers, some = batch.crawlers(np.full(count + 1, valve, np.int8)), Share(0, count, batch.skip)
        in_lanes(crawlers, some, 0.5, options, batch.workspace[None])
        own = np.empty((5, SAMPLES))
        start = Body(*single[:5].tolist(), int(single[5]), int(single[6]))
        outcome = alone(start, batch.members[0], float(valve), 0.5, options, own, batch.workspace)
        single = np.array(outcome.body)
        for i in range(count):
            np.testing.assert_array_equal(batch.bodies[:, i], single)
            np.testing.assert_array_equal(batch.samples[..., i], own[:3])
    batch.check()
    assert batch.statuses.tolist() == [FINISHED] * count + [-1]
    assert not batch.bodies[:, count].any()

"""Crawlers of a batch in lanes, each compared with the same crawler by itself."""

import numpy as np

from stickslip.compiling.compilation import compiled
from stickslip.crawler.batch.advance import advance_lanes, lane_workspace
from stickslip.crawler.loop import advance
from stickslip.crawler.model.columns import Crawlers, Share
from stickslip.crawler.model.state import Body, coefficients_of, NOTHING_YET
from stickslip.crawler.solvers import SOLVERS
from stickslip.crawler.steps.options import Hold, MAX_STEPS, Recording

SAMPLES = 3
UNTOUCHED = -9.0


@compiled
def in_lanes(crawlers, some, hold, options, workspace):
    advance_lanes(crawlers, some, hold, options, workspace)


@compiled
def alone(body, coefficients, valve, hold, options, samples, workspace):
    whole = Hold(valve, hold, 0.0, hold, 0.0)
    return advance(body, NOTHING_YET, coefficients, whole, options, Recording(samples, workspace[:0]), workspace)


class Batch:
    """The same crawlers twice: as columns of a batch, and each by itself."""

    def __init__(self, members, bodies=None):
        n = len(members)
        self.members = [coefficients_of(groups, scene) for groups, scene in members]
        self.coefficients = np.array(self.members, dtype=np.float64).T.copy()
        self.bodies = np.zeros((7, n)) if bodies is None else np.array(bodies, dtype=np.float64)
        self.samples = np.full((3, SAMPLES, n), UNTOUCHED)
        self.statuses = np.full(n, -1, np.int8)
        self.elapsed = np.full(n, UNTOUCHED)
        self.skip = np.zeros(n, bool)
        self.workspace = lane_workspace()

    def advance(self, valves, hold, options, begin=0, end=None):
        """Both ways, compared: what is in the slice bit for bit, what is not left as it was."""
        end = len(self.members) if end is None else end
        before = [array.copy() for array in self.arrays]
        valves = np.asarray(valves, np.int8)
        in_lanes(self.crawlers(valves), Share(begin, end, self.skip), hold, options, self.workspace)
        for i, coefficients in enumerate(self.members):
            bodies, samples, statuses, elapsed = (array[..., i].copy() for array in before)
            if begin <= i < end and not self.skip[i]:
                own = np.full((5, SAMPLES), UNTOUCHED)
                start = Body(*bodies[:5].tolist(), int(bodies[5]), int(bodies[6]))
                workspace = SOLVERS["taylor"].workspace(coefficients, hold, SAMPLES)
                outcome = alone(start, coefficients, float(valves[i]), hold, options, own, workspace)
                bodies, statuses, elapsed = np.array(outcome.body), outcome.status, outcome.elapsed
                samples = np.where(own[:3] == UNTOUCHED, samples, own[:3])
            np.testing.assert_array_equal(self.bodies[:, i], bodies, err_msg=f"crawler {i}")
            np.testing.assert_array_equal(self.samples[..., i], samples, err_msg=f"crawler {i}")
            assert self.statuses[i] == statuses
            assert self.elapsed[i] == elapsed

    def crawlers(self, valves):
        """They as the kernels take them."""
        return Crawlers(self.bodies, self.coefficients, valves, self.samples, self.statuses, self.elapsed)

    @property
    def arrays(self):
        return self.bodies, self.samples, self.statuses, self.elapsed


def taylor(tolerance, max_steps=MAX_STEPS):
    return SOLVERS["taylor"].options(tolerance, max_steps=max_steps)

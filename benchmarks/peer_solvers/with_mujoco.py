"""MuJoCo: payload and foot on slide joints; spring, cubic spring, damper and lagging pressure are its own.

It has neither a static friction above the kinetic one nor a ratchet, so stick-slip is written by hand: two models, with
the foot's joint and without, and a change between them where a step ends beyond an event. That makes any integrator
first order; ``located`` is the best that we found, where the step that an event falls into is shortened to end on it.
``joint frictionloss`` is MuJoCo's own friction, which asks for nothing by hand and solves another problem.
"""

from peer_solvers.own import foot_under_plain_friction
from peer_solvers.problem import (
    Contender,
    DAMPING,
    DRAG,
    force,
    GRIP,
    GROUPS,
    HOLD,
    Journey,
    LIGHT,
    PAYLOAD,
    WORD,
    Word,
)
from stickslip.common.extras import optional_import

with optional_import():
    import mujoco

__all__ = ["contenders"]

STEP = 1e-3
LOCATED_STEPS = (0.1, 0.05, 0.02, 0.01)
FRICTIONLOSS_STEPS = (1e-2, STEP)
SECANTS = 60
ON_TIME = 1e-13  # force or speed at which an event is met

EULER, RUNGE_KUTTA = "Euler", "RK4"
# Runge-Kutta advances the pressure as any state; one exact for Euler's step would be counted twice.
LAG = {EULER: "filterexact", RUNGE_KUTTA: "filter"}


def contenders() -> list[Contender]:
    """The mode switch by hand, its events located or not, and MuJoCo's own friction."""
    plain = foot_under_plain_friction(DRAG, WORD)
    note = f"one coefficient {DRAG:g} and no ratchet: the foot of that problem is at {plain:.4f}"
    return [
        Contender("MuJoCo", "Euler, mode switch", f"dt {STEP:g}", STEP, _switched(STEP, EULER, _whole_step)),
        *(
            Contender("MuJoCo", "RK4, located switch", f"dt {dt:g}", dt, _switched(dt, RUNGE_KUTTA, _step_to_event))
            for dt in LOCATED_STEPS
        ),
        *(
            Contender("MuJoCo", "joint frictionloss", f"dt {dt:g}", dt, _with_frictionloss(dt), note)
            for dt in FRICTIONLOSS_STEPS
        ),
    ]


def _model(dt: float, integrator: str, foot: str, constraints: str) -> mujoco.MjModel:
    """A payload and what it hangs on: a foot with the joint given, or with none."""
    return mujoco.MjModel.from_xml_string(f"""
        <mujoco>
          <option timestep="{dt}" gravity="0 0 0" integrator="{integrator}">
            <flag contact="disable" island="disable" constraint="{constraints}"/>
          </option>
          <worldbody>
            <body>
              <inertial pos="0 0 0" mass="{LIGHT}" diaginertia="1 1 1"/>
              {foot}
              <body>
                <inertial pos="0 0 0" mass="{PAYLOAD}" diaginertia="1 1 1"/>
                <joint name="z" type="slide" axis="1 0 0" stiffness="1 0 {GROUPS.duffing}" damping="{DAMPING}"/>
              </body>
            </body>
          </worldbody>
          <actuator>
            <general joint="z" dyntype="{LAG[integrator]}" dynprm="{GROUPS.deborah}"
              gaintype="affine" gainprm="1 {GROUPS.radial_coupling} 0" biastype="none"/>
          </actuator>
        </mujoco>""")


class _Motion:
    """One of the two models with views of its state; the payload's joint is the last."""

    def __init__(self, dt: float, integrator: str, slides: bool) -> None:
        self.model = _model(dt, integrator, '<joint type="slide" axis="1 0 0"/>' if slides else "", "disable")
        self.data = mujoco.MjData(self.model)
        self.slides = slides
        self.position, self.rate, self.pressure = self.data.qpos, self.data.qvel, self.data.act

    def reset(self) -> None:
        mujoco.mj_resetData(self.model, self.data)
        if self.slides:
            self.data.qfrc_applied[0] = -DRAG

    def take_over(self, other: "_Motion") -> None:
        self.position[-1], self.rate[-1], self.pressure[0] = other.position[-1], other.rate[-1], other.pressure[0]
        if self.slides:
            self.rate[0] = 0.0

    def margin(self) -> float:
        """What falls through zero as the motion ends."""
        if self.slides:
            return self.rate.item(0)
        return GRIP + force(self.position.item(0), self.rate.item(0), self.pressure.item(0))


def _switched(dt: float, integrator: str, step):
    motions = [_Motion(dt, integrator, slides) for slides in (False, True)]

    def run(word: Word) -> Journey:
        for motion in motions:
            motion.reset()
        sliding, slips = False, 0
        for command in word.tolist():
            for motion in motions:
                motion.data.ctrl[0] = command
            for _ in range(round(HOLD / dt)):
                left = dt
                while left > 0.0:
                    motion = motions[sliding]
                    took, ended = step(motion, left)
                    left -= took
                    if ended:
                        sliding = not sliding
                        slips += sliding
                        motions[sliding].take_over(motion)
        return Journey(motions[1].position.item(0), slips)

    return run


def _whole_step(motion: _Motion, length: float) -> tuple[float, bool]:
    """One step; an event is noticed where it has passed."""
    mujoco.mj_step(motion.model, motion.data)
    return length, motion.margin() < 0.0


def _step_to_event(motion: _Motion, length: float) -> tuple[float, bool]:
    """One step, done again shorter, by the Illinois form of the secant, until it ends on the event."""
    position, rate, pressure = motion.position.copy(), motion.rate.copy(), motion.pressure.copy()
    low, at_low = 0.0, motion.margin()
    high, at_high = length, _step_of(motion, length)
    if at_high >= 0.0 or at_low <= 0.0:  # a slip shorter than its first step is seen at the end of it
        return length, at_high < 0.0
    for _ in range(SECANTS):
        moment = high - at_high * (high - low) / (at_high - at_low)
        motion.position[:], motion.rate[:], motion.pressure[:] = position, rate, pressure
        margin = _step_of(motion, moment)
        if abs(margin) < ON_TIME:
            break
        if margin > 0.0:
            low, at_low, at_high = moment, margin, 0.5 * at_high
        else:
            high, at_high, at_low = moment, margin, 0.5 * at_low
    return moment, True


def _step_of(motion: _Motion, length: float) -> float:
    motion.model.opt.timestep = length
    mujoco.mj_step(motion.model, motion.data)
    return motion.margin()


def _with_frictionloss(dt: float):
    foot = f'<joint type="slide" axis="1 0 0" frictionloss="{DRAG}"/>'
    model = _model(dt, EULER, foot, "enable")
    data = mujoco.MjData(model)
    steps = round(HOLD / dt)

    def run(word: Word) -> Journey:
        mujoco.mj_resetData(model, data)
        for command in word.tolist():
            data.ctrl[0] = command
            mujoco.mj_step(model, data, steps)
        return Journey(data.qpos.item(0), None)

    return run

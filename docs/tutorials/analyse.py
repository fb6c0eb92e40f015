# %% [markdown]
# # Tutorial: analyse the motion and its numerics
#
# You integrate hybrid systems, or identify and control them, and want to know what this solver promises. In ten minutes:
# a trajectory with its events, how its error follows the tolerance, whether the motion is chaotic, and SI units.
#
# You need [the extra](../installation.md) `plot`. Every cell below was run when this page was built.

# %%
from matplotlib import pyplot as plt

from stickslip import Groups, simulate

word = [1, 1, 1, 0, 0]  # open for three holds, shut for two
motion = simulate(Groups(), word * 8, hold=0.5, samples_per_hold=20, tolerance=1e-12)
figure = motion.plot()

# %% [markdown]
# ## What was integrated
#
# Payload in front, foot behind, a pneumatic spring between. The foot sticks until it is pulled with more than static
# friction, slides, and comes to rest; a ratchet never lets it slide back. The engine models no more than a scene needs,
# and says what it did.

# %%
print(motion)

# %% [markdown]
# ## Events
#
# Each change between stick and slip is an event, isolated on the step's own polynomial. Between two of them the motion is
# smooth; at them it is not, which a phase portrait shows.

# %%
figure, axes = plt.subplots(figsize=(5.5, 3.6), layout="constrained")
axes.plot(motion.deformation, motion.velocity, lw=1, color="0.6", label="motion")
sliding = motion.foot_velocity > 0
axes.plot(motion.deformation[sliding], motion.velocity[sliding], ".", ms=5, color="C1", label="the foot slides")
axes.set(xlabel="deformation $z$ ($z_c$)", ylabel="rate $v$ ($z_c / t_c$)")
axes.legend()
for event in motion.events[:4]:
    print(f"at {event['time']:.8f} the foot", "slides" if event["mode"] else "sticks")

# %% [markdown]
# ## Error against tolerance
#
# `tolerance` is the largest term neglected from the Taylor series of a step. Whether the error follows it is asked of a run
# at 1e-15, over 200 time units and 50 slips, and of the balance of energies, which every run keeps of itself.

# %%
import numpy as np

gait = [1, 1, 1, 1, 0, 0, 0, 0] * 25
best = simulate(Groups(), gait, hold=1.0, tolerance=1e-15)
tolerances = 10.0 ** -np.arange(3, 15)
errors, residuals = [], []
for tolerance in tolerances:
    run = simulate(Groups(), gait, hold=1.0, tolerance=tolerance)
    assert run.slips == best.slips
    errors.append(np.abs(run.foot - best.foot).max())
    residuals.append(abs(run.energy_residual) / run.energy_scale)
figure, axes = plt.subplots(figsize=(5.5, 3.4), layout="constrained")
axes.loglog(tolerances, errors, "o-", label="largest error of the foot ($z_c$)")
axes.loglog(tolerances, residuals, "s-", label="energy not accounted for, share")
axes.loglog(tolerances, tolerances, color="0.7", label="tolerance")
axes.invert_xaxis()
axes.set(xlabel="tolerance")
axes.legend()
print(f"{best.slips} slips, foot at {best.foot[-1]:.14f}")

# %% [markdown]
# [Scenes, solvers and their cost](../solvers.md) puts the same trajectory beside SciPy, heyoka, diffrax and MuJoCo.
#
# ## How far does a small change go?
#
# `condition=True` carries tangents through slips and stops, and tells by what factor a change of the start grows until the
# end. A gait forgets; a lightly damped stiffening spring that is anchored and driven at random need not.

# %%
from stickslip import lyapunov_spectrum

print("condition of the gait:", simulate(Groups(), gait, hold=1.0, condition=True).condition)
valve = np.random.default_rng(0).integers(0, 2, (8, 2200))  # eight inputs
for duffing in (0.0, 200.0):
    body = {"duffing": duffing, "damping_ratio": 0.02}
    found = lyapunov_spectrum(body, valve, hold=0.5, scene={"anchored": True})
    print(f"duffing {duffing:5}: {found.exponents[0]:+.3f} ± {found.standard_error[0]:.3f}, {found.verdict}")

# %% [markdown]
# [Lyapunov exponents](../lyapunov.md) says what the verdicts mean, and has the bifurcation diagram.
#
# ## A batch, and SI
#
# Groups, valve, scene and hold may differ from row to row; each row is to the bit what it is alone. And `Actuator` holds
# masses, stiffness and pressure in SI, gives the groups, and takes results back.

# %%
from stickslip import Actuator

fractions = np.linspace(0.05, 0.9, 18)
bodies = [Groups(foot_mass_fraction=fraction) for fraction in fractions]
crawls = simulate(bodies, word * 80, hold=0.5)
robot = Actuator.ecoflex()
figure, axes = plt.subplots(figsize=(5.5, 3), layout="constrained")
axes.plot(fractions, crawls.foot[:, -1] / crawls.time[-1], "o-")
axes.set(xlabel="the foot's share of the mass", ylabel="speed ($z_c / t_c$)", ylim=(0, None))

metres = simulate(robot, word * 8, hold=0.5).in_si(robot)
print(f"z_c is {1e3 * robot.scales.length:.1f} mm and t_c is {1e3 * robot.scales.time:.0f} ms")
print(f"the word takes the foot {1e3 * metres.foot[-1]:.0f} mm in {metres.time[-1]:.2f} s")

# %% [markdown]
# ## From here
#
# - [Scenes, solvers, and what they cost](../solvers.md), and [the extremes](../extremes.md) of every range.
# - [What accuracy is worth](../accuracy.md) for memory, speed and trained policies.
# - [A body from measurements](../identification.md): groups or SI parameters from your own recordings.
# - [Extending](../extending.md): a new force or solver, file by file.

# %% [markdown]
# # Tutorial: benchmark a reservoir
#
# You measure reservoirs, in software or on a bench, and want fair numbers beside this body's. In ten minutes: the memory
# of the crawler against delay, tasks beside tuned baselines, and a reservoir of your own in the same table.
#
# You need [the extra](../installation.md) `plot`. Every cell below was run when this page was built.

# %%
from matplotlib import pyplot as plt

from stickslip import memory_capacity
from stickslip.tasks import crawler_states, plot_memory_profile, random_bits, RESERVOIRS

bits = random_bits(8000, seed=0)  # the valve: fair bits, one a hold
states = {
    "crawler": crawler_states(bits, hold=0.5, virtual_nodes=4),
    "delay line": RESERVOIRS["delay line"](bits, 0),
}
memories = {name: memory_capacity(every, bits, delays=20) for name, every in states.items()}
figure = plot_memory_profile(memories)

# %% [markdown]
# ## What is in a curve
#
# Row k of the states is what can be measured of the body once it has absorbed bit k: here deformation, rate and pressure
# at four instants of the hold, so twelve features. For each delay a ridge readout is fitted on the first half and scored on
# the second, by the squared correlation with the bit of that long ago. The grey band is what chance reaches; the corrected
# total counts what is above it, and no linear readout can have more than the rank of the states.

# %%
crawler = memory_capacity(states["crawler"], bits, delays=20, resamples=200)
low, high = crawler.corrected_interval
print(f"{crawler.corrected:.2f} of at most {crawler.bound}, 95% interval {low:.2f} to {high:.2f}")

# %% [markdown]
# The interval is of this run's readout. What another run would give is asked of several seeds, as below, and
# [how far to trust a capacity](../trust.md) says how often either holds the truth.
#
# ## Tasks, beside tuned baselines
#
# `run_benchmark` drives every reservoir by the same inputs and tunes the networks for each task and seed within the
# training data. `stickslip bench` is the same in the shell, with more seeds, resumed after a crash.

# %%
from stickslip.studies.benchmark import run_benchmark, table

records = run_benchmark(
    tasks=["memory capacity", "NARMA-2 NRMSE", "parity-2 capacity"],
    reservoirs=["crawler", "delay line", "echo-state network"],
    seeds=range(3),
    length=2000,
)
for row in table(records):
    print(*(f"{cell:>22}" for cell in row))

# %% [markdown]
# A delay line remembers all and computes no parity. The body remembers little, and multiplies: friction and the cubic
# spring are its nonlinearity. A tuned network of as many nodes is better at these tasks; what the body has is that it
# crawls. [The laboratory](../reservoir.md) has the whole table.
#
# ## Your own reservoir in the same table
#
# A reservoir is a function from a series in [0, 1] and a seed to states, one row a sample. So is a recording of hardware
# that was driven by that series: see [memory of measured data](../measured_data.md).

# %%
import numpy as np


def leaky_bank(series, seed):
    """Six leaky integrators with time constants of 1 to 20 samples, and their squares."""
    keep = np.exp(-1.0 / np.geomspace(1.0, 20.0, 6))
    states = np.zeros((len(series), 12))
    now = np.zeros(6)
    for k, sample in enumerate(series):
        now = keep * now + (1.0 - keep) * sample
        states[k] = np.concatenate([now, now**2])
    return states


mine = run_benchmark(
    tasks=["memory capacity", "NARMA-2 NRMSE", "parity-2 capacity"],
    reservoirs={"crawler": RESERVOIRS["crawler"], "leaky bank": leaky_bank},
    seeds=range(3),
    length=2000,
)
for row in table(mine):
    print(*(f"{cell:>22}" for cell in row))

# %% [markdown]
# ## One number of the body, swept
#
# Counted in holds, the capacity hardly depends on how long a hold is, over a factor of 32: where holds are short, the body
# remembers as many of them, which is less time.

# %%
holds = np.geomspace(0.125, 4.0, 11)
capacities = [memory_capacity(crawler_states(bits, hold=hold, virtual_nodes=4), bits, delays=30) for hold in holds]
figure, axes = plt.subplots(figsize=(6, 3), layout="constrained")
axes.semilogx(holds, [capacity.corrected for capacity in capacities], "o-")
axes.set(xlabel="hold ($t_c$)", ylabel="memory capacity (corrected)", ylim=(0, None))
axes.set_xticks([0.125, 0.25, 0.5, 1, 2, 4], ["1/8", "1/4", "1/2", "1", "2", "4"])
axes.minorticks_off()
least, most = (end([capacity.corrected for capacity in capacities]) for end in (min, max))
print(f"from {least:.2f} to {most:.2f}")

# %% [markdown]
# ## Inside scikit-learn
#
# `CrawlerReservoir` is the body as a transformer: real-valued series go in through the width of valve pulses.

# %%
from sklearn.linear_model import Ridge
from sklearn.pipeline import make_pipeline

from stickslip import CrawlerReservoir
from stickslip.tasks import random_narma

series, target = random_narma(1500, order=2, seed=0)
model = make_pipeline(CrawlerReservoir(hold=0.5, virtual_nodes=4), Ridge(1e-6))
model.fit(series[:1000, None], target[:1000])
print(f"R² on the last 500 samples: {model.score(series[1000:, None], target[1000:]):.3f}")

# %% [markdown]
# ## From here
#
# - [The reservoir laboratory](../reservoir.md): all measures, tasks and tables, sweeps and maps.
# - [Memory of measured data](../measured_data.md): your own hardware's recordings.
# - [Encodings](../encodings.md): real-valued series for a valve that is open or shut.
# - [The best body](../best.md) for each task, and what it cannot do.

"""The measures of `stickslip.reservoir` by their definitions, in loops over NumPy and SciPy.

Slow and short: one function, one delay, one sample or one resample at a time, and no two ways for one thing.
"""

import math
from itertools import combinations, product

import numpy as np
from scipy import special, stats

SENSORS = 0x4E01


def sensed(states, noise, seed):
    """States as sensors of a signal-to-noise ratio in decibels read them."""
    if noise is None:
        return states
    drawn = np.random.default_rng([SENSORS, seed]).standard_normal(states.shape)
    return states + 10 ** (-noise / 20) * states.std(axis=0) * drawn


def score(prediction, target):
    """Squared correlation; 0 where the correlation is negative."""
    return max(np.corrcoef(prediction, target)[0, 1], 0.0) ** 2


def basis_of(states):
    """Orthonormal basis of the centred states, of full rank."""
    return np.linalg.qr(states - states.mean(axis=0))[0]


def chance_cutoff(q, y, significance):
    """What a function that is uncorrelated with the states explains no more often than `significance`."""
    samples, rank = q.shape
    squares = (y - y.mean()) ** 2
    leverage = (q**2).sum(axis=1)
    share = (leverage * squares).sum() / squares.sum()
    exact = stats.beta(rank / 2, (samples - 1 - rank) / 2).isf(significance)
    cutoff = min(1.0, max(1.0, share * samples / rank) * exact)
    if squares.std() <= 0.1 * squares.mean():
        return cutoff
    covariance = q.T @ np.diag(squares) @ q / squares.sum()
    second, third = np.trace(covariance @ covariance), np.trace(covariance @ covariance @ covariance)
    variance = 2 * (second - ((leverage * squares / squares.sum()) ** 2).sum())
    law = stats.gamma(second**3 / (2 * third**2))
    own = share + math.sqrt(variance) * (law.isf(significance) - law.mean()) / law.std()
    return min(1.0, 2 * share * stats.gamma(0.5).isf(significance), max(cutoff, own))


def basic_interval(drawn, estimate, confidence, blocks):
    """Basic interval, widened to Student's law."""
    upper = (1 + confidence) / 2
    wider = stats.t(blocks - 1).ppf(upper) / stats.norm.ppf(upper) * math.sqrt(blocks / (blocks - 1))
    low, high = np.quantile(drawn, [1 - upper, upper], axis=0)
    return estimate + wider * (estimate - high), estimate + wider * (estimate - low)


def block_length(samples, delays):
    """The cube root of the samples or what the delays span, and a tenth of the samples at most."""
    return max(1, min(max(math.ceil(samples ** (1 / 3)), max(delays) - min(delays) + 1), samples // 10))


def memory(
    states,
    message,
    delays,
    *,
    washout=200,
    scoring="held out",
    holdout=0.5,
    ridge=1e-9,
    fit_intercept=True,
    significance=1e-4,
    noise=None,
    resamples=0,
    confidence=0.95,
    seed=0,
):
    """What `memory_capacity` returns, as a dictionary."""
    lags = list(range(delays)) if isinstance(delays, int) else list(delays)
    start = max(washout, *lags)
    x = sensed(states, noise, seed)[start:]
    targets = np.column_stack([message[start - d : len(message) - d] for d in lags])
    innovations = np.column_stack([(message - message.mean())[start - d : len(message) - d] for d in lags])

    def centred(x):
        return x - x.mean(axis=0) * fit_intercept

    def penalty_for(x):
        return ridge * (centred(x) ** 2).sum() / x.shape[1]

    def predicted(rows, penalty, asked):
        """By the normal equations, which are good enough for states as few and as different as these."""
        known, mean = x[rows], x[rows].mean(axis=0) * fit_intercept
        gram = centred(known).T @ centred(known) + penalty * np.eye(x.shape[1])
        weights = np.linalg.solve(gram, centred(known).T @ centred(targets[rows]))
        return (asked - mean) @ weights + targets[rows].mean(axis=0) * fit_intercept

    samples, every = len(x), np.arange(len(x))
    if scoring == "held out":
        training = scored = math.floor((1 - holdout) * samples + 1e-9)
        prediction = predicted(every[:training], penalty_for(x[:training]), x[training:])
    else:
        training, scored = samples, 0
        prediction = np.vstack([predicted(np.delete(every, k), penalty_for(x), x[k : k + 1]) for k in range(samples)])
    targets, innovations = targets[scored:], innovations[scored:]
    profile = np.array([score(*each) for each in zip(prediction.T, targets.T, strict=True)])
    rank = np.linalg.matrix_rank(x - x.mean(axis=0))
    if scoring == "held out":
        p, t = prediction - prediction.mean(axis=0), innovations
        scatter = (p**2 * t**2).sum(axis=0) / (p**2).sum(axis=0) / (t.var(axis=0) * len(t))
        cutoff = stats.norm.ppf(significance) ** 2 * scatter
    else:
        q, leverage = basis_of(x), (rank + 1) / samples
        s = samples * np.array([chance_cutoff(q, t, significance) for t in innovations.T])
        cutoff = np.minimum(
            1, np.maximum(s - rank - 1, 0) ** 2 / (samples * (s - 2 * leverage * s + samples * leverage**2))
        )
    found = {"delays": lags, "profile": profile, "cutoff": cutoff, "bound": rank}
    found |= {"total": profile.sum(), "corrected": profile[profile > cutoff].sum()}
    if not resamples:
        return found | dict.fromkeys(("profile_interval", "total_interval", "corrected_interval"))

    length, block = len(targets), block_length(len(targets), lags)
    starts = np.random.default_rng(seed).integers(0, length, (resamples, math.ceil(length / block)))
    indices = (starts[:, :, None] + np.arange(block)).reshape(resamples, -1) % length
    drawn = np.array(
        [
            [np.corrcoef(p[index], t[index])[0, 1] for p, t in zip(prediction.T, targets.T, strict=True)]
            for index in indices
        ]
    )
    blocks, signed = length // block, [np.corrcoef(*each)[0, 1] for each in zip(prediction.T, targets.T, strict=True)]
    ends = np.tanh(basic_interval(np.arctanh(drawn), np.arctanh(signed), confidence, blocks))

    def interval_of_sum(chosen):
        squares, estimate = (np.maximum(drawn, 0) ** 2)[:, chosen].sum(axis=1), profile[chosen].sum()
        low, high = basic_interval(squares, estimate, confidence, blocks)
        return max(0, min(low, estimate)), min(max(high, estimate), chosen.sum())

    above = profile > cutoff
    total, of_found = interval_of_sum(np.full(len(lags), True)), interval_of_sum(above)
    lost = (1 - profile[above]).sum() * rank / training
    return found | {
        "profile_interval": np.maximum(ends, 0) ** 2,
        "total_interval": total,
        "corrected_interval": (of_found[0], max(of_found[1], total[1]) + lost),
    }


def terms_of(degree, latest, highest):
    """Products of one degree that reach back to one delay: fewest factors first."""
    for factors in range(1, degree + 1):
        for degrees in product(range(1, highest + 1), repeat=factors):
            if sum(degrees) == degree:
                for early in combinations(range(latest), factors - 1):
                    yield tuple(zip((*early, latest), degrees, strict=True))


def one_input(inputs, basis, degree, support):
    """Orthonormal functions of one input, of degree 1 and up."""
    if basis == "walsh":
        p = (inputs == inputs.max()).mean()
        return [np.where(inputs == inputs.max(), math.sqrt((1 - p) / p), -math.sqrt(p / (1 - p)))]
    low, high = support or (inputs.min(), inputs.max())
    x = (2 * inputs - low - high) / (high - low)
    return [math.sqrt(2 * n + 1) * special.eval_legendre(n, x) for n in range(1, degree + 1)]


def information(
    states,
    inputs,
    *,
    basis="walsh",
    max_degree=3,
    delays=50,
    washout=200,
    threshold="chi-squared",
    significance=1e-4,
    surrogates=20,
    patience=10,
    budget=100_000,
    support=None,
    noise=None,
    confidence=0.95,
    seed=0,
):
    """What `information_processing_capacity` returns, as a dictionary."""
    reach = [delays] * max_degree if isinstance(delays, int) else list(delays)
    start = max(washout, max(reach) - 1)
    q = basis_of(sensed(states[start:], noise, seed))
    samples, rank = q.shape
    functions = one_input(inputs, basis, max_degree, support)
    leverage = (q**2).sum(axis=1)

    def row_of(term, functions):
        return math.prod(functions[degree - 1][start - delay : len(inputs) - delay] for delay, degree in term)

    def explained(y):
        return ((q.T @ y) ** 2).sum() / (samples * y.var())

    def events(y):
        centred = y - y.mean()
        carried = (q @ (q.T @ centred) - leverage * centred) * centred
        return (carried**2).sum() ** 2 / (carried**4).sum()

    needed = max(-2 * math.log(significance) * (f**4).mean() / (f**2).mean() ** 2 for f in functions)
    cutoffs, found, tried, last, rare = {}, [], {}, {}, 0
    for degree, count in enumerate(reach, 1):
        cutoffs[degree] = stats.beta(rank / 2, (samples - 1 - rank) / 2).isf(significance)
        if threshold == "surrogates":
            every = [term for latest in range(count) for term in terms_of(degree, latest, len(functions))]
            values = []
            for i in range(surrogates):
                order = np.random.default_rng([seed, i]).permutation(len(inputs))
                values += [explained(row_of(term, [f[order] for f in functions])) for term in every[:500]]
            cutoffs[degree] = max(cutoffs[degree], np.quantile(values, 1 - significance))
        tried[degree], last[degree], quiet = 0, -1, 0
        for latest in range(count):
            window = list(terms_of(degree, latest, len(functions)))
            if sum(tried.values()) + len(window) > budget:
                break
            passed = []
            for term in window:
                y = row_of(term, functions)
                if explained(y) > max(cutoffs[degree], chance_cutoff(q, y, significance)):
                    if events(y) > needed:
                        passed.append(term)
                    else:
                        rare += 1
            found += passed
            tried[degree], last[degree] = tried[degree] + len(window), latest
            quiet = 0 if passed else quiet + bool(window)
            if patience is not None and quiet >= patience:
                break
    block = block_length(samples, [term[-1][0] for term in found] or [0])
    blocks, before, capacity, chance, turned, influence = samples // block, 0.0, [], [], [], []
    for term in found:
        y = row_of(term, functions)
        y = y - y.mean()
        for earlier in turned:
            y = y - earlier * (earlier @ y)
        y /= np.linalg.norm(y)
        turned.append(y)
        chance.append(leverage @ y**2 * max(1 - 2 * before / rank, 0))
        capacity.append(min(max((((q.T @ y) ** 2).sum() - chance[-1]) / (1 - chance[-1]), 0), 1))
        before += capacity[-1]
        missed = (y - q @ (q.T @ y)) ** 2 / (1 - leverage)
        moved = ((1 - capacity[-1]) * y**2 - missed)[: blocks * block]
        influence.append(moved.reshape(blocks, block).sum(axis=1))
    capacity, influence = np.array(capacity), np.array(influence).reshape(len(found), blocks)
    half = stats.t(blocks - 1).ppf((1 + confidence) / 2) * math.sqrt(blocks / (blocks - 1))
    errors = half * np.sqrt((influence**2).sum(axis=1)) / (capacity * (1 - capacity))
    of_total = half * np.sqrt((influence.sum(axis=0) ** 2).sum())
    total = capacity.sum()
    return {
        "terms": tuple(found),
        "capacity": capacity,
        "chance": np.array(chance),
        "capacity_interval": special.expit(special.logit(capacity) + np.array([[-1], [1]]) * errors),
        "total_interval": (max(total - of_total, 0), min(total + of_total, max(rank, total))),
        "degree": np.array([sum(degree for _, degree in term) for term in found]),
        "delay": np.array([term[-1][0] for term in found]),
        "thresholds": cutoffs,
        "rank": rank,
        "tried": tried,
        "reach": last,
        "rare": rare,
        "total": total,
    }


def kernel(reservoir, *, inputs, length=100, shared=10, endings=5, threshold=1e-3, noise=None, seed=0):
    """What `kernel_quality` returns, as a dictionary."""
    streams = np.random.default_rng(seed).integers(0, 2, (1 + endings, inputs, length)).astype(float)
    for ending in streams[1:]:
        for stream in ending:
            stream[length - shared :] = ending[0, length - shared :]
    states = np.array([[reservoir(stream)[-1] for stream in each] for each in streams])
    unit = states[0].std(axis=0)
    values = [np.linalg.svd((x - x.mean(axis=0)) / unit, compute_uv=False) / math.sqrt(inputs) for x in states]
    floor = threshold * values[0][0] if noise is None else 10 ** (-noise / 20)
    counts = [sum(value > floor for value in each) for each in values]
    return {
        "kernel_rank": counts[0],
        "generalisation_rank": np.mean(counts[1:]),
        "kernel_singular_values": values[0],
        "generalisation_singular_values": np.array(values[1:]),
        "threshold": floor / values[0][0],
        "difference": counts[0] - np.mean(counts[1:]),
    }


def echo_state(states, *, washout=0, tolerance=1e-3):
    """What `echo_state_property` returns, as a dictionary."""
    starts, samples, features = states.shape
    unit = states / states.std(axis=(0, 1)) / math.sqrt(features)
    pairs = [(i, j) for i in range(starts) for j in range(i)]
    apart = {(i, j): np.linalg.norm(unit[i] - unit[j], axis=1) for i, j in pairs}
    # Those within the tolerance of one another are one, and those within it of one of them too.
    groups = [{i} for i in range(starts)]
    for i, j in pairs:
        if apart[i, j][-1] <= tolerance:
            one, other = (next(group for group in groups if each in group) for each in (i, j))
            if one is not other:
                groups.remove(other)
                one |= other
    growth = [[] for _ in range(samples)]
    for i in range(1, starts):
        entered = False
        for k in range(samples - 1):
            now, after = apart[i, 0][k : k + 2]
            if 1e-11 < now < 0.01 and after > 0:
                entered = True
                growth[k].append(math.log(after / now))
            elif entered:
                break
    means = [np.mean(each) for each in growth if each]
    every = [each for sample in growth for each in sample]
    correlations = [
        np.corrcoef(states[i, washout:, f], states[j, washout:, f])[0, 1] for i, j in pairs for f in range(features)
    ]
    return {
        "echo_index": len(groups),
        "distance": np.max(list(apart.values()), axis=0),
        "consistency": np.mean(correlations),
        "exponent": np.mean(every),
        "exponent_error": np.std(means, ddof=1) / math.sqrt(len(means)),
    }

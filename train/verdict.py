"""A training beside what needs none: the valve held open, held shut, and the best word."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..common.files import write_text
from .evaluation import Acting
from .long_runs import LongRuns, of_policy, of_words
from .schedules import necklaces

__all__ = [
    "REPORT",
    "STANDARD",
    "Baseline",
    "Judging",
    "Mean",
    "Verdict",
    "baselines",
    "judge",
    "read_baselines",
    "read_report",
    "write_verdict",
]

# Seeds of trainings count from 0, those of their evaluations from 10^6.
_SEARCH_SEED = 2_000_000
_FRESH_SEED = 3_000_000
# Words that are tried again, since the best of hundreds on one seed is luck.
_FINALISTS = 12
# Bodies that move in one cycle, begun at another phase of it, differ by this part.
_TIE = 1e-4
REPORT = "report.json"
"""File of a run's folder that tells the verdict to programs; ``report.md`` tells people."""

HELD_OPEN, HELD_SHUT, BEST_WORD = "held open", "held shut", "best word"


@dataclass(frozen=True)
class Judging:
    """How long, and on what, a training is judged.

    Parameters
    ----------
    seeds : int, >= 2
        Runs of the policy and of each baseline, all with the same flips, which no training has seen.
    steps : int, >= 1
        Of each run.
    burn_in : int, >= 0
        Steps before them, in which the body gets under way and the readout learns.
    longest_word : int, >= 1
        All necklaces up to this length are searched.
    """

    seeds: int = 32
    steps: int = 2000
    burn_in: int = 1000
    longest_word: int = 12


STANDARD = Judging()
"""How a training is judged where nobody says otherwise."""


class Mean(NamedTuple):
    """A mean over seeds, and its standard error."""

    value: float
    error: float

    @classmethod
    def of(cls, values: Any) -> "Mean":
        """Of one number a seed."""
        return cls(float(np.mean(values)), float(np.std(values, ddof=1) / math.sqrt(len(values))))

    def __str__(self) -> str:
        return f"{self.value:.4f} ± {self.error:.4f}"


class Baseline(NamedTuple):
    """A word that needs no training, and its runs."""

    name: str
    word: str
    runs: LongRuns


@dataclass(frozen=True)
class Verdict:
    """What a policy came to beside the baselines, all on the same fresh seeds.

    Parameters
    ----------
    policy : LongRuns
    baselines : sequence of Baseline
    judging : Judging
    """

    policy: LongRuns
    baselines: Sequence[Baseline]
    judging: Judging

    @property
    def best(self) -> Baseline:
        """The baseline with most reward."""
        return max(self.baselines, key=lambda each: float(np.mean(each.runs.reward)))

    @property
    def gain(self) -> Mean:
        """Reward of the policy less that of the best baseline, seed by seed."""
        return Mean.of(self.policy.reward - self.best.runs.reward)

    @property
    def ties(self) -> bool:
        """Whether the two are one, but for the start."""
        return abs(self.gain.value) <= _TIE * abs(float(np.mean(self.best.runs.reward)))

    @property
    def loses(self) -> bool:
        """Whether the best baseline has more reward."""
        return self.gain.value < 0.0 and not self.ties

    @property
    def sentence(self) -> str:
        """The verdict in words."""
        best, gain = self.best, self.gain
        other = f"{best.word} repeated, the best word" if best.name == BEST_WORD else f"the valve {best.name}"
        if self.ties:
            return f"The policy is as good as {other}, the best that needs no training."
        comparison = (
            f"{np.mean(self.policy.reward):.4f} of reward per step against {np.mean(best.runs.reward):.4f}, "
            f"{abs(gain.value):.4f} ± {gain.error:.4f} {'less' if self.loses else 'more'}"
        )
        if self.loses:
            return f"The training FAILED: its policy loses to {other}, which needs no training: {comparison}."
        return f"The policy beats {other}, the best that needs no training: {comparison}."

    def to_dict(self) -> dict[str, Any]:
        """All of it, ready for JSON."""
        gain = self.gain
        return {
            "verdict": self.sentence,
            "loses": self.loses,
            "best baseline": self.best.name,
            "gain of reward": {"mean": gain.value, "standard error": gain.error},
            "judging": asdict(self.judging),
            "policy": _runs_as_lists(self.policy),
            "baselines": {each.name: {"word": each.word, **_runs_as_lists(each.runs)} for each in self.baselines},
        }

    def to_markdown(self) -> str:
        """A page: the verdict, and the table that it was read from."""
        rows = [("the policy", self.policy), *((f"{each.name} ({each.word})", each.runs) for each in self.baselines)]
        judging = self.judging
        return "\n".join(
            [
                "# What the training came to",
                "",
                self.sentence,
                "",
                "| | speed | memory | reward per step |",
                "| --- | ---: | ---: | ---: |",
                *(f"| {name} | {' | '.join(str(Mean.of(each)) for each in runs)} |" for name, runs in rows),
                "",
                f"Means over {judging.seeds} fresh seeds, with standard errors: {judging.steps} steps of each after "
                f"{judging.burn_in} to get under way. The best word has most reward of all necklaces of up to "
                f"{judging.longest_word} letters; it was found on other seeds.",
                "",
            ]
        )


def baselines(env_kwargs: Mapping[str, Any], judging: Judging) -> list[Baseline]:
    """The valve held open, held shut, and the best word, in an environment.

    Parameters
    ----------
    env_kwargs : mapping
        Arguments of the environment.
    judging : Judging

    Returns
    -------
    list of Baseline
        Held open, held shut, and the best of the words that move the valve.
    """
    words = [word for word in necklaces(judging.longest_word) if len(word) > 1] or ["10"]
    length = {"steps": judging.steps, "burn_in": judging.burn_in}
    shorter = {name: max(1, count // 2) for name, count in length.items()}
    found = of_words(words, env_kwargs, seeds=[_SEARCH_SEED], **shorter)
    order = np.argsort([-float(np.mean(runs.reward)) for runs in found], kind="stable")
    finalists = [words[i] for i in order[:_FINALISTS]]
    others = range(_SEARCH_SEED + 1, _SEARCH_SEED + 1 + judging.seeds)
    again = of_words(finalists, env_kwargs, seeds=others, **shorter)
    best = finalists[int(np.argmax([np.mean(runs.reward) for runs in again]))]
    named = {HELD_OPEN: "1", HELD_SHUT: "0", BEST_WORD: best}
    judged = of_words(list(named.values()), env_kwargs, seeds=_fresh(judging), **length)
    return [Baseline(name, word, runs) for (name, word), runs in zip(named.items(), judged, strict=True)]


def judge(
    policy: Acting,
    env_kwargs: Mapping[str, Any],
    judging: Judging,
    *,
    against: Sequence[Baseline] | None = None,
) -> Verdict:
    """Judge a policy on fresh seeds over long runs.

    Parameters
    ----------
    policy : Policy or BaseAlgorithm
    env_kwargs : mapping
        Arguments of the environment.
    judging : Judging
    against : sequence of Baseline, optional
        What `baselines` found for the same arguments; it is asked by default.

    Returns
    -------
    Verdict
    """
    others = baselines(env_kwargs, judging) if against is None else against
    own = of_policy(policy, env_kwargs, seeds=_fresh(judging), steps=judging.steps, burn_in=judging.burn_in)
    return Verdict(own, others, judging)


def write_verdict(verdict: Verdict, folder: Path) -> None:
    """Write ``report.json`` and ``report.md``.

    Raises
    ------
    OSError
        If they cannot be written.
    """
    page, table = verdict.to_markdown(), json.dumps(verdict.to_dict(), indent=1) + "\n"
    write_text(folder / "report.md", page)
    write_text(folder / REPORT, table)


def read_report(folder: Path) -> dict[str, Any] | None:
    """What `write_verdict` has kept in a folder, if it has."""
    file = folder / REPORT
    return json.loads(file.read_text(encoding="utf-8")) if file.is_file() else None


def read_baselines(folder: Path, judging: Judging) -> list[Baseline] | None:
    """The baselines of an earlier verdict in a folder, if there is one that was judged alike."""
    written = read_report(folder)
    if written is None or written["judging"] != asdict(judging):
        return None
    return [
        Baseline(name, each["word"], LongRuns(*(np.array(each[term]) for term in LongRuns._fields)))
        for name, each in written["baselines"].items()
    ]


def _fresh(judging: Judging) -> range:
    return range(_FRESH_SEED, _FRESH_SEED + judging.seeds)


def _runs_as_lists(runs: LongRuns) -> dict[str, list[float]]:
    return {name: values.tolist() for name, values in runs._asdict().items()}

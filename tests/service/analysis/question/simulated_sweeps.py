"""Simulated questions: pairs drawn from the scores that our own runs reached, many sweeps at once.

A pair is one score of either entry, drawn independently: measured pairs of equal seed correlate
little. Scores are those of results/scores.csv, on the normalised scale, in [0, 1].
"""

import csv
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from physics.randomness import generator
from service.analysis.curves import Floats
from service.analysis.question.decision import Decisions, Outcome, decide, refuted
from service.analysis.question.evidence import log_evidence
from service.model.inquiry.question import Method, Question

Flags = NDArray[np.bool_]

RESULTS = Path(__file__).parents[4] / "results"
TASKS = (
    "Acrobot", "CartPole", "CartPoleSwingUp", "HalfCheetah", "MountainCar", "Pendulum", "RollingDie"
)  # fmt: skip
FIXED = 32
SWEEPS = 2000
WAYS: tuple[tuple[Method, float], ...] = (("bounded", 1.0), ("bounded", 0.25), ("normal", 1.0))
GAINS = (
    ("CartPole", "hybrid-ddpg"),
    ("Acrobot", "hybrid-ddpg-cosine"),
    ("CartPole", "hybrid-ddpg-cosine"),
    ("RollingDie", "hybrid-ddpg"),
    ("CartPoleSwingUp", "hybrid-ddpg"),
    ("Pendulum", "hybrid-ddpg-cosine"),
)


@cache
def scores(task: str, algorithm: str, score: str) -> Floats:
    """The normalised scores of an algorithm's runs in a task, in [0, 1]."""
    with (RESULTS / "random-returns.csv").open() as file:
        [zero] = [row for row in csv.DictReader(file) if row["environment"] == task]
    start, best = float(zero["random"]), float(zero["best"])
    with (RESULTS / "scores.csv").open() as file:
        values = [
            float(row[score])
            for row in csv.DictReader(file)
            if (row["environment"], row["algorithm"]) == (task, algorithm)
        ]
    return np.clip((np.array(values) - start) / (best - start), 0.0, 1.0)


@dataclass(frozen=True)
class Drawn:
    """Paired differences [sweeps, tasks, seeds], and their true means [tasks]."""

    differences: Floats
    means: Floats


def draw(name: str, pools: Sequence[tuple[Floats, Floats]], question: Question) -> Drawn:
    """Draw each task's pairs from two pools, ours and theirs."""
    draws = generator(0, f"simulated sweeps: {name}")
    shape = (SWEEPS, question.max_seeds)
    found = [
        np.clip(draws.choice(ours, shape) - draws.choice(theirs, shape),
                -question.clip, question.clip)
        for ours, theirs in pools
    ]  # fmt: skip
    means = [
        np.clip(ours[:, None] - theirs, -question.clip, question.clip).mean()
        for ours, theirs in pools
    ]
    return Drawn(np.stack(found, axis=1), np.array(means))


def no_difference(algorithm: str, score: str, question: Question) -> Drawn:
    """Sweeps in which both entries are the same algorithm."""
    pools = [(scores(task, algorithm, score),) * 2 for task in TASKS]
    return draw(f"none {algorithm} {score}", pools, question)


def as_measured(algorithm: str, score: str, question: Question) -> Drawn:
    """Sweeps that compare an algorithm with ddpg."""
    pools = [(scores(task, algorithm, score), scores(task, "ddpg", score)) for task in TASKS]
    return draw(f"as measured {algorithm} {score}", pools, question)


def question_of(method: Method = "bounded", clip: float = 1.0, max_seeds: int = 128) -> Question:
    """One that looks after every eighth seed."""
    first = tuple(range(8))
    return Question(first, ("h",), "ddpg", clip=clip, method=method, max_seeds=max_seeds)


def looks_of(question: Question) -> tuple[int, ...]:
    """How many seeds there are at each look."""
    return tuple(len(question.seeds(k + 1)) for k in range(question.looks))


def decided(drawn: Drawn, question: Question) -> Decisions:
    """What the service would decide in each of the sweeps."""
    tasks = drawn.differences.shape[1]
    n = looks_of(question)
    evidence = refuted(drawn.differences, n, question)
    counts, ended = np.tile(n, (tasks, 1)), np.full(tasks, question.looks)
    return decide(evidence, counts, ended, range(tasks), question)


def wrong(decisions: Decisions, drawn: Drawn, question: Question) -> Flags:
    """Which sweeps decided anything wrongly: the share of them is what is bounded."""
    outcome, means = decisions.outcome, drawn.means
    is_wrong = (
        ((outcome == Outcome.BETTER) & (means <= 0))
        | ((outcome == Outcome.WORSE) & (means >= 0))
        | ((outcome == Outcome.EQUIVALENT) & (abs(means) >= question.margin))
    )
    found: Flags = is_wrong.any(axis=1)
    return found


def missed(drawn: Drawn, question: Question) -> Flags:
    """Which sequences of one comparison by itself miss the mean at any look [sweeps, tasks]."""
    bar, n = -np.log(question.error_rate / 2), looks_of(question)
    found = [
        (log_evidence(d, m, n, question.method, question.clip) >= bar).any(-1)
        | (log_evidence(-d, -m, n, question.method, question.clip) >= bar).any(-1)
        for d, m in zip(np.moveaxis(drawn.differences, 1, 0), drawn.means, strict=True)
    ]
    return np.stack(found, axis=1)


def naive(drawn: Drawn, question: Question) -> Flags:
    """Which sweeps find a difference by Student's 95 % interval at any look, task by task."""
    n = np.array(looks_of(question))
    d = drawn.differences
    mean = np.cumsum(d, -1)[..., n - 1] / n
    spread = np.maximum(np.cumsum(d * d, -1)[..., n - 1] / n - mean**2, 0.0) / (n - 1)
    found: Flags = (abs(mean) > stdtrit(n - 1, 0.975) * np.sqrt(spread)).any(axis=(1, 2))
    return found


def power_of_fixed(drawn: Drawn) -> float:
    """How often Student's 95 % interval of 32 seeds excludes 0, in one task."""
    d = drawn.differences[:, 0, :FIXED]
    reach = stdtrit(FIXED - 1, 0.975) * d.std(axis=1, ddof=1) / np.sqrt(FIXED)
    return float((abs(d.mean(axis=1)) > reach).mean())


def savings(task: str, algorithm: str, question: Question) -> float | None:
    """The mean number of seeds of a question whose budget just suffices for a fixed 32's power.

    None where the question's own budget does not.
    """
    drawn = draw(
        f"{task} {algorithm}",
        [(scores(task, algorithm, "area"), scores(task, "ddpg", "area"))],
        question,
    )
    power, n = power_of_fixed(drawn), np.array(looks_of(question))
    decisions = decided(drawn, question)
    is_found = np.isin(decisions.outcome[:, 0], (Outcome.BETTER, Outcome.WORSE))
    spent = n[decisions.look[:, 0] - 1]
    for budget in n:
        if (is_found & (spent <= budget)).mean() >= power:
            return float(np.minimum(spent, budget).mean())
    return None


def error_rows() -> Iterator[str]:
    """Lines of the table of errors."""
    for score, (method, clip) in product(("area", "final"), WAYS):
        question = question_of(method, clip)
        same = [no_difference(each, score, question) for each in ("ddpg", "hybrid-ddpg")]
        real = [
            as_measured(each, score, question) for each in ("hybrid-ddpg", "hybrid-ddpg-cosine")
        ]
        false, wrongs = (
            max(wrong(decided(drawn, question), drawn, question).mean() for drawn in each)
            for each in (same, real)
        )
        looked = max(naive(drawn, question).mean() for drawn in same)
        covered = 1 - max(missed(drawn, question).mean(axis=0).max() for drawn in (*same, *real))
        cells = (f"`{score}`", f"{method}, {clip:g}", f"{false:.1%}", f"{looked:.0%}",
                 f"{wrongs:.1%}", f"{covered:.1%}")  # fmt: skip
        yield f"| {' | '.join(cells)} |"


def saving_rows() -> Iterator[str]:
    """Lines of the table of savings."""
    for task, algorithm in GAINS:
        ours, theirs = scores(task, algorithm, "area"), scores(task, "ddpg", "area")
        found = [savings(task, algorithm, question_of(*way, max_seeds=256)) for way in WAYS]
        cells = ["more than 256" if each is None else f"{each:.0f}" for each in found]
        yield f"| {task}, {algorithm} | {ours.mean() - theirs.mean():+.2f} | {' | '.join(cells)} |"


if __name__ == "__main__":
    print(*error_rows(), "", *saving_rows(), sep="\n")  # noqa: T201

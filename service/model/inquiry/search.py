"""A search: which entry of a sweep is best in each task, by successive halving.

The entries of a task climb rungs. On rung k all that are left have T_k timesteps; the best of
them, one in `reduction`, go on from their checkpoints to the next rung. On the last one the best is
found.

    n_0 = entries of the task      n_k+1 = ceil(n_k / reduction), until one is left: K rungs
    T_k = T / reduction^(K-1-k), in whole measurements      T: timesteps of a run of the sweep
    cost of a seed = sum over tasks and rungs of n_k (T_k - T_k-1)
    seeds = budget / cost of a seed

So every rung costs about the same, and a larger budget means more seeds, not longer runs. (Jamieson
and Talwalkar, "Non-stochastic best arm identification and hyperparameter optimization", AISTATS
2016.) The seeds are of a range that no question takes (`tuning_seeds`).

What is planned when a sweep is submitted is stored with it: neither presets nor a later version of
this file change a search that has begun.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import Any, Literal, Self, get_args

from algorithms.measurement import MEASURE_EVERY
from service.model.inquiry.tuning_seeds import SEARCHES

SearchScore = Literal["area", "final"]
SEARCH_SCORES: tuple[SearchScore, ...] = get_args(SearchScore)
FEWEST_SEEDS = 2
"""With one seed the luckiest entry is chosen."""


@dataclass(frozen=True)
class Rung:
    """A number of entries, the best ones so far, and the timesteps they are trained to."""

    entries: int
    timesteps: int


@dataclass(frozen=True)
class Search:
    """A search as it was planned.

    budget     timesteps of all runs together, at most
    reduction  one in this many entries goes on
    score      that compares entries, up to the timesteps of the rung
    seeds      of every entry
    rungs      of each task
    """

    budget: int
    reduction: int
    score: SearchScore
    seeds: tuple[int, ...]
    rungs: Mapping[str, tuple[Rung, ...]]

    @classmethod
    def of(cls, document: Mapping[str, Any] | None) -> Self | None:
        """Read what `document` wrote; None: the sweep does not search."""
        if document is None:
            return None
        rungs = {
            task: tuple(Rung(**each) for each in listed)
            for task, listed in document["rungs"].items()
        }
        return cls(**{**document, "seeds": tuple(document["seeds"]), "rungs": rungs})

    @property
    def document(self) -> dict[str, Any]:
        """Plain values; `of` gives an equal search back."""
        return asdict(self)

    @property
    def timesteps(self) -> int:
        """Timesteps of all runs together."""
        return len(self.seeds) * cost_of_a_seed(self.rungs)


def rungs_of(entries: int, timesteps: int, reduction: int) -> tuple[Rung, ...]:
    """Return the rungs of so many entries, at least two, to so many timesteps."""
    counts = [entries]
    while counts[-1] > reduction:
        counts.append(-(-counts[-1] // reduction))
    shares = [reduction ** (len(counts) - 1 - k) for k in range(len(counts))]
    lengths = [_whole(timesteps, share) for share in shares]
    return tuple(Rung(*each) for each in zip(counts, lengths, strict=True))


def _whole(timesteps: int, share: int) -> int:
    """Return one in `share` timesteps, in whole measurements, at least one; for 1, all of them."""
    if share == 1:
        return timesteps
    return min(max(round(timesteps / share / MEASURE_EVERY), 1) * MEASURE_EVERY, timesteps)


def cost_of_a_seed(rungs: Mapping[str, Sequence[Rung]]) -> int:
    """Return the timesteps of all entries together, with one seed."""
    return sum(_cost(each) for each in rungs.values())


def _cost(rungs: Sequence[Rung]) -> int:
    going_on = (
        upper.entries * (upper.timesteps - lower.timesteps) for lower, upper in pairwise(rungs)
    )
    return rungs[0].entries * rungs[0].timesteps + sum(going_on)


def search_seeds(count: int) -> tuple[int, ...]:
    """Return so many seeds of a search; there are `len(SEARCHES)`."""
    return tuple(SEARCHES[:count])

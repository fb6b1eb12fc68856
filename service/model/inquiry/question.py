"""A question: what a sweep shall find out, and when it may stop.

"Does each of the entries `compare` differ from the entry `against`, in each task?" The first look
comes after the sweep's own seeds. The service then adds seeds in batches, and looks after each of
them, until each of these comparisons is decided or has `max_seeds`.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import count, islice
from typing import Any, Literal, Self

from service.model.inquiry.tuning_seeds import chooses

Method = Literal["bounded", "normal"]

SECONDS_TO = re.compile(r"seconds to (1|0\.\d{0,5}[1-9])")


@dataclass(frozen=True)
class Question:
    """A question of a sweep, whose entries it names by their labels.

    first        the seeds before the first look
    compare      the entries that are asked about
    against      the entry that each of them is compared with
    score        "area", "final" or "seconds to X" with X in (0, 1], on the normalised scale
    margin       smaller differences do not matter
    confidence   of all decisions together
    max_seeds    seeds of each entry in each task, at most
    batch        seeds between two looks
    clip         larger differences of a pair count as this value, in (0, 1]
    method       "bounded" assumes nothing; "normal" that differences are normally distributed
    drop_losers  whether an entry that is worse in one task gets no more seeds in the others
    """

    first: tuple[int, ...]
    compare: tuple[str, ...]
    against: str
    score: str = "area"
    margin: float = 0.02
    confidence: float = 0.95
    max_seeds: int = 128
    batch: int = 8
    clip: float = 1.0
    method: Method = "bounded"
    drop_losers: bool = False

    @classmethod
    def of(cls, request: Mapping[str, Any]) -> Self | None:
        """Return the question of a posted sweep; None where it asks none."""
        asked = request.get("question")
        if asked is None:
            return None
        fields = {name: value for name, value in asked.items() if name not in ("with", "until")}
        seeds = request["seeds"]
        first = tuple(range(seeds) if isinstance(seeds, int) else seeds)
        return cls(
            first, **{**fields, "compare": tuple(asked["compare"]), "against": asked["with"]}
        )

    @property
    def error_rate(self) -> float:
        """The probability that any decision is wrong, at most."""
        return 1.0 - self.confidence

    @property
    def threshold(self) -> float | None:
        """The X of "seconds to X"; None for another score."""
        found = SECONDS_TO.fullmatch(self.score)
        return float(found[1]) if found else None

    @property
    def looks(self) -> int:
        """How many looks there are at most."""
        return 1 + -(-max(self.max_seeds - len(self.first), 0) // self.batch)

    def seeds(self, looks: int) -> tuple[int, ...]:
        """Return the seeds of so many looks together: the first ones, then those that follow.

        Seeds that choose settings are skipped.
        """
        more = min(len(self.first) + (looks - 1) * self.batch, self.max_seeds) - len(self.first)
        following = (seed for seed in count(max(self.first) + 1) if not chooses(seed))
        return (*self.first, *islice(following, max(more, 0)))

"""How many more seeds a comparison needs, judging by the pairs seen so far.

Later pairs are drawn from those that were seen, with replacement, CONTINUATIONS times,
each time until `decision` would decide at the level of the next look. The forecast is the median
number of seeds; the power is the share of continuations that decide before the budget ends. Both
take the pairs seen for typical, and say nothing where fewer than MIN_PAIRS were.
"""

from dataclasses import dataclass

import numpy as np

from physics.randomness import generator
from service.analysis.question.decision import refuted
from service.analysis.question.pairs import Pairs
from service.model.inquiry.question import Question

CONTINUATIONS = 64
HORIZON = 512
"""Seeds looked ahead."""
MIN_PAIRS = 4
MOST_PAIRS = 10_000


@dataclass(frozen=True)
class Forecast:
    """What more seeds would do.

    more   seeds until half of the continuations have decided; None: more than HORIZON
    power  share of the continuations that decide with the seeds that the budget has left
    """

    more: int | None
    power: float


def forecast(pairs: Pairs, level: float, question: Question) -> Forecast | None:
    """Return the forecast for an open comparison; None where too few pairs were seen."""
    seen = pairs.differences
    if len(seen) < MIN_PAIRS:
        return None
    draws = generator(0, "forecast of a question", len(seen))
    to_come = draws.choice(seen, size=(CONTINUATIONS, HORIZON))
    path = np.concatenate([np.broadcast_to(seen, (CONTINUATIONS, len(seen))), to_come], axis=1)
    more = np.arange(question.batch, HORIZON + 1, question.batch)
    found = refuted(path, tuple(len(seen) + more), question)
    bar = -np.log(level)
    is_decided = (found.better >= bar) | (found.worse >= bar) | (found.equivalent >= bar)
    share = is_decided.mean(axis=0)
    enough = np.flatnonzero(share >= 0.5)
    left = more <= question.max_seeds - len(question.seeds(len(pairs.looks)))
    return Forecast(
        more=int(more[enough[0]]) if len(enough) else None,
        power=float(share[left].max(initial=0.0)),
    )


def fewest_to_equivalence(question: Question, comparisons: int) -> int | None:
    """Return the pairs that "equivalent" needs where all differences are 0 and nothing is decided.

    None where MOST_PAIRS are too few.
    """
    level = question.error_rate / (2 * comparisons)
    found = refuted(np.zeros(MOST_PAIRS), range(MOST_PAIRS + 1), question)
    enough = np.flatnonzero(found.equivalent >= -np.log(level))
    return int(enough[0]) if len(enough) else None

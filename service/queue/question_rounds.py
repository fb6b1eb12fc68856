"""The rounds of questions and searches: after each batch, the next one, until there is an answer.

The next batch is a pure function of the runs that have ended (`service/analysis/question`). Nothing
is remembered here: a service that is killed at any moment asks for the same seeds again, and the
store writes them once, and only if the sweep has not changed
(`service/store/claiming/inquiry/question_batches.py`). `service/queue/search_rounds.py` has the
rounds of searches.
"""

from collections.abc import Mapping, Sequence

from service.analysis.question.pairs import Pairs, all_pairs
from service.analysis.question.verdict import wanted
from service.model.environment import best_return
from service.model.inquiry.question import Question
from service.model.request.entry import Entries
from service.model.sweep import Sweep
from service.queue.rounds import Rounds
from service.queue.search_rounds import next_rung
from service.store.claiming.inquiry.question_batches import Cell
from service.store.store import Store

ROUND_SECONDS = 0.5

Batch = Mapping[Cell, Sequence[int]]


class QuestionRounds(Rounds):
    """Works twice a second."""

    def __init__(self, store: Store, seconds: float = ROUND_SECONDS) -> None:
        """Begin nothing yet."""
        super().__init__("question rounds", seconds)
        self._store = store

    def work(self) -> bool:
        """Continue every question and search whose batch has ended."""
        look_at_all(self._store)
        return False


def look_at_all(store: Store) -> int:
    """Continue all whose batch or rung has ended; return how many runs were added or go on."""
    return sum(look(store, sweep_id) for sweep_id in store.waiting_questions())


def look(store: Store, sweep_id: str) -> int:
    """Write the next batch or rung, or settle the sweep; return how many runs it has."""
    seen = store.sweep_version(sweep_id)  # before all else that is read
    sweep = store.find_sweep(sweep_id)
    if sweep is None:  # it was deleted meanwhile
        return 0
    if sweep.search is not None:
        return store.go_on_searching(sweep_id, seen, next_rung(store, sweep, sweep.search))
    return store.go_on_asking(sweep_id, seen, next_batch(store, sweep))


def next_batch(store: Store, sweep: Sweep) -> Batch:
    """Return the seeds that the cells of a sweep shall have."""
    question, entries = Question.of(sweep.request), Entries(sweep.request)
    if question is None:
        return {}
    places = {entry.label: entry.place for entry in entries.all}
    seeds = wanted(pairs_of(store, sweep, question), question)
    return {(task, places[label]): of_cell for (task, label), of_cell in seeds.items()}


def pairs_of(store: Store, sweep: Sweep, question: Question) -> list[Pairs]:
    """Return the pairs of a sweep's comparisons, as its runs stand."""
    x = "timesteps" if question.threshold is None else "seconds"
    [curves] = store.curves(sweep.id, ["return_mean"], x)
    return all_pairs(curves, Entries(sweep.request), question, store.random_returns(), best_return)

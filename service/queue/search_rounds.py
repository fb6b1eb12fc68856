"""The rounds of searches: after each rung, the next one, until the best entry is found.

As with questions, nothing is remembered here. The next rung is a pure function of the plan and of
what the runs have measured (`service/analysis/halving.py`), and the store writes it once
(`service/store/claiming/inquiry/search_rungs.py`).
"""

import json
from collections.abc import Mapping, Sequence

from service.analysis.halving import Ladder, ladders, wanted
from service.model.environment import best_return
from service.model.inquiry.search import Search
from service.model.request.entry import Entries
from service.model.run_curve import RunCurve
from service.model.sweep import Sweep
from service.store.claiming.inquiry.question_batches import Cell
from service.store.store import Store
from workers.messages.run_spec import RunSpec, Weights

Rung = Mapping[Cell, int]
"""The timesteps that cells shall have."""
Setting = tuple[str, str, Weights, str]
"""A task, an algorithm, its weights, its settings as text."""


def next_rung(store: Store, sweep: Sweep, search: Search) -> Rung:
    """Return the timesteps that the cells of a search shall have."""
    [curves] = store.curves(sweep.id, ["return_mean"])
    entries = Entries(sweep.request)
    places = {entry.label: entry.place for entry in entries.all}
    climbed = _ladders(store, curves, entries, search)
    return {(task, places[label]): steps for (task, label), steps in wanted(climbed).items()}


def ladders_of(store: Store, sweep: Sweep, search: Search) -> list[Ladder]:
    """Return the rungs that the entries of a search have reached, from its present runs."""
    [curves] = store.curves(sweep.id, ["return_mean"])
    return _ladders(store, curves, Entries(sweep.request), search)


def searches_that_tried(store: Store, sweep: Sweep) -> list[Sweep]:
    """Return the earlier searches that tried a setting of this sweep, whatever they found."""
    settings = _settings(store, sweep)
    return [
        each
        for each in store.list_searches()
        if each.created_at < sweep.created_at and settings & _settings(store, each)
    ]


def _settings(store: Store, sweep: Sweep) -> set[Setting]:
    """What cells compare, apart from seeds and timesteps."""
    return {_setting(cell.spec) for cell in store.sweep_cells(sweep.id)}


def _setting(spec: RunSpec) -> Setting:
    config = json.dumps(spec.config, sort_keys=True)
    return spec.environment, spec.algorithm, spec.weights, config


def _ladders(
    store: Store, curves: Sequence[RunCurve], entries: Entries, search: Search
) -> list[Ladder]:
    return ladders(curves, entries, search, store.random_returns(), best_return)

"""The entries of a sweep: what its request compares, each with a name of its own.

An entry is an algorithm with its settings and one pair of weights; a list of pairs is as many
entries. What it does not state is the preset's, which may differ from task to task: it is one entry
all the same. Curves, tables, statistics and runs go by entries, and a run's place in its sweep says
of which entry it is: runs lie environment by environment, in each entry by entry, in each seed by
seed.
"""

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from service.model.run_name import RunName
from workers.messages.run_spec import Weights

Json = Mapping[str, Any]

LARGEST_WHOLE = 1e16  # above it, floats are shown by their exponent


@dataclass(frozen=True)
class Entry:
    """One entry of a request.

    field         where in the request: `algorithms[1]`, `algorithms[1].weights[0]`
    weights       None: the preset's
    config        the settings it states
    environments  those of the sweep's that it runs in
    label         its name: the algorithm, and what tells it from its siblings
    """

    field: str
    algorithm: str
    weights: Weights | None
    config: Json
    environments: tuple[str, ...]
    label: str = ""

    @property
    def stated(self) -> dict[str, Any]:
        """Weights and settings that it states, by name, weights first."""
        weights = {} if self.weights is None else self.weights._asdict()
        return {**weights, **dict(sorted(self.config.items()))}


class Entries:
    """The entries of a posted sweep (`SweepRequest`, as JSON without what was not set)."""

    def __init__(self, request: Json) -> None:
        """List them, in the order of the request."""
        environments = tuple(dict.fromkeys(request["environments"]))
        self.all = _labelled(
            [
                entry
                for place, algorithm in enumerate(request["algorithms"])
                for entry in _entries(f"algorithms[{place}]", algorithm, environments)
            ]
        )
        self.cells = [
            (environment, entry)
            for environment in environments
            for entry in self.all
            if environment in entry.environments
        ]
        """Each environment with each entry that runs in it, in the order of the runs."""
        seeds = request["seeds"]
        self.runs_of_cell: int = seeds if isinstance(seeds, int) else len(seeds)

    def label(self, run_id: str) -> str:
        """Return the name of the entry that a run is of."""
        _, entry = self.cells[RunName.parse(run_id).ordinal // self.runs_of_cell]
        return entry.label


def _entries(field: str, algorithm: Json, everywhere: tuple[str, ...]) -> list[Entry]:
    asked = algorithm.get("weights")
    pairs = asked if isinstance(asked, list) else [asked]
    is_listed = len(pairs) > 1
    return [
        Entry(
            field=f"{field}.weights[{place}]" if is_listed else field,
            algorithm=algorithm["name"],
            weights=None if pair is None else Weights(**pair),
            config=algorithm.get("config") or {},
            environments=tuple(algorithm.get("environments") or everywhere),
        )
        for place, pair in enumerate(pairs)
    ]


def _labelled(entries: Sequence[Entry]) -> list[Entry]:
    """Name each by its algorithm, and by what it states that tells it from its siblings.

    Siblings are the entries of the same algorithm. Where some state the same, in environments of
    their own, those tell them apart.
    """
    telling = {name: _telling(name, entries) for name in {each.algorithm for each in entries}}
    labels = [_label(entry, telling[entry.algorithm]) for entry in entries]
    counts = Counter(labels)
    return [
        replace(entry, label=f"{label} in {', '.join(entry.environments)}")
        if counts[label] > 1
        else replace(entry, label=label)
        for label, entry in zip(labels, entries, strict=True)
    ]


def _telling(algorithm: str, entries: Sequence[Entry]) -> set[str]:
    """The names of weights and settings in which entries of an algorithm differ."""
    stated = [entry.stated for entry in entries if entry.algorithm == algorithm]
    texts = [{name: setting_text(value) for name, value in each.items()} for each in stated]
    names = {name for each in texts for name in each}
    return {name for name in names if len({each.get(name) for each in texts}) > 1}


def _label(entry: Entry, telling: set[str]) -> str:
    told = [f"{n}={setting_text(value)}" for n, value in entry.stated.items() if n in telling]
    return " ".join([entry.algorithm, *told])


def setting_text(value: Any) -> str:
    """Return a setting as a label shows it: equal numbers alike, different ones never."""
    if isinstance(value, float) and value.is_integer() and abs(value) < LARGEST_WHOLE:
        return str(int(value))
    if isinstance(value, float):
        short = f"{value:g}"
        return short if float(short) == value else repr(value)
    return json.dumps(value, ensure_ascii=False)

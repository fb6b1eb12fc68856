"""The entries of a sweep: what its request compares, each with a name of its own.

An entry is an algorithm with its settings, one pair of weights and a share of the timesteps. A list
in their place is a grid: as many entries as it has points. What an entry does not state is the
preset's, which may differ from task to task: it is one entry all the same. Curves, tables,
statistics and runs go by entries. A run knows the place of its entry among them; entries that are
added to a sweep come after those that it has.
"""

import json
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, Protocol, Self

from service.model.request.grid import expand, size
from workers.messages.run_spec import Weights

Json = Mapping[str, Any]

ALWAYS_TOLD = frozenset({"placebo"})
"""Settings that make an algorithm its own baseline: never left out of a label."""

LARGEST_WHOLE = 1e16  # above it, floats are shown by their exponent


class OfEntry(Protocol):
    """Something that belongs to an entry: a run, or its curve."""

    @property
    def entry(self) -> int:
        """The place of its entry in the sweep."""


@dataclass(frozen=True)
class Entry:
    """One entry of a request.

    field         where in the request: `algorithms[1]`, `algorithms[1].weights[0]`
    point         of the grid there: `noise=0.1, scale=0.5`; empty where that is no grid
    place         among the sweep's entries
    item          the place of its algorithm in the request
    base          the label of its algorithm in the request; else the algorithm's name
    weights       None: the preset's
    config        the settings it states
    environments  those of the sweep's that it runs in
    scale         share of the timesteps that it runs; None: the request states none
    label         its name: the base, and what tells it from its siblings
    """

    field: str
    point: str
    place: int
    item: int
    base: str
    algorithm: str
    weights: Weights | None
    config: Json
    environments: tuple[str, ...]
    scale: float | None
    label: str = ""

    @property
    def stated(self) -> dict[str, Any]:
        """Weights, settings and share that it states, by name, weights first."""
        weights = {} if self.weights is None else self.weights._asdict()
        share = {} if self.scale is None else {"scale": self.scale}
        return {**weights, **dict(sorted(self.config.items())), **share}


class Entries:
    """The entries of a posted sweep (`SweepRequest`, as JSON without what was not set)."""

    def __init__(self, request: Json) -> None:
        """List them, in the order of the request."""
        environments = tuple(dict.fromkeys(request["environments"]))
        stated = [
            entry
            for item, algorithm in enumerate(request["algorithms"])
            for entry in _entries(item, algorithm, environments, request.get("scale"))
        ]
        self.all = _labelled([replace(each, place=place) for place, each in enumerate(stated)])
        self.cells = _cells(environments, self.all)
        """Each environment with each entry that runs in it, in the order of the runs."""

    @classmethod
    def of_all(cls, entries: Sequence[Entry]) -> Self:
        """Return entries of several requests, which have their places and names."""
        together = cls.__new__(cls)
        together.all = list(entries)
        environments = dict.fromkeys(task for each in entries for task in each.environments)
        together.cells = _cells(environments, together.all)
        return together

    def label(self, of_entry: OfEntry) -> str:
        """Return the name of the entry that a run is of."""
        return self.all[of_entry.entry].label


def _cells(environments: Iterable[str], entries: Sequence[Entry]) -> list[tuple[str, Entry]]:
    return [
        (task, entry) for task in environments for entry in entries if task in entry.environments
    ]


def listed(value: Any) -> list[Any]:
    """Return the values of a list, or the single value given instead of a list."""
    return value if isinstance(value, list) else [value]


def axes_of(pair: Json | None, config: Json) -> dict[str, list[Any]]:
    """Return the axes of an algorithm's grid for one of its pairs: its weights, its settings."""
    weights = {} if pair is None else {**Weights()._asdict(), **pair}
    return {name: listed(value) for name, value in {**weights, **config}.items()}


def entries_of(algorithm: Json) -> int:
    """Count an algorithm's entries, whatever the share of the timesteps; nothing is expanded."""
    config, together = algorithm.get("config") or {}, algorithm.get("zip") or ()
    return sum(size(axes_of(pair, config), together) for pair in listed(algorithm.get("weights")))


def _entries(
    item: int, algorithm: Json, everywhere: tuple[str, ...], shares: Any
) -> Iterator[Entry]:
    pairs = listed(algorithm.get("weights"))
    config, together = algorithm.get("config") or {}, algorithm.get("zip") or ()
    for index, pair in enumerate(pairs):
        axes = axes_of(pair, config)
        varied = [name for name, values in axes.items() if len(values) > 1]
        for point, share in product(expand(axes, together), listed(shares)):
            told = {name: point[name] for name in varied}
            told |= {"scale": share} if isinstance(shares, list) else {}
            yield Entry(
                field=f"algorithms[{item}]" + f".weights[{index}]" * (len(pairs) > 1),
                point=", ".join(f"{name}={setting_text(value)}" for name, value in told.items()),
                place=0,
                item=item,
                base=algorithm.get("label") or algorithm["name"],
                algorithm=algorithm["name"],
                weights=None if pair is None else Weights(point["w1"], point["w2"]),
                config={name: point[name] for name in config},
                environments=tuple(algorithm.get("environments") or everywhere),
                scale=share,
            )


def _labelled(entries: Sequence[Entry]) -> list[Entry]:
    """Name each by its base, and by what it states that tells it from its siblings.

    Siblings are the entries of the same algorithm; those of one label, the entries under it. Where
    some state the same, in environments of their own, those tell them apart. A placebo says that it
    is one, unless the request gives it a label.
    """
    telling = {
        base: _telling([each for each in entries if base in (each.base, each.algorithm)])
        for base in {each.base for each in entries}
    }
    labels = [_label(entry, telling[entry.base]) for entry in entries]
    counts = Counter(labels)
    return [
        replace(entry, label=f"{label} in {', '.join(entry.environments)}")
        if counts[label] > 1
        else replace(entry, label=label)
        for label, entry in zip(labels, entries, strict=True)
    ]


def _telling(siblings: Sequence[Entry]) -> set[str]:
    """The names of weights and settings in which entries differ."""
    texts = [{n: setting_text(value) for n, value in each.stated.items()} for each in siblings]
    names = {name for each in texts for name in each}
    return {name for name in names if len({each.get(name) for each in texts}) > 1}


def _label(entry: Entry, telling: set[str]) -> str:
    telling = telling | ALWAYS_TOLD if entry.base == entry.algorithm else telling
    told = [f"{n}={setting_text(value)}" for n, value in entry.stated.items() if n in telling]
    return " ".join([entry.base, *told])


def setting_text(value: Any) -> str:
    """Return a setting as a label shows it: equal numbers alike, different ones never."""
    if isinstance(value, float) and value.is_integer() and abs(value) < LARGEST_WHOLE:
        return str(int(value))
    if isinstance(value, float):
        short = f"{value:g}"
        return short if float(short) == value else repr(value)
    return json.dumps(value, ensure_ascii=False)

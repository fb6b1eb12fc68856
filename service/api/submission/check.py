"""What can be wrong with a posted sweep beyond the form of its fields."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, TypeVar

from pydantic import ValidationError

from algorithms import catalogue
from algorithms.catalogue import Algorithm
from service.api.refusals.nearest import unknown_name
from service.api.refusals.problems import Fault, faults_of, printable
from service.api.schemas.requests.sweep_request import MAX_RUNS, AlgorithmRequest, SweepRequest
from service.api.submission.grid_faults import repeated_values
from service.model.environment import environment_facts, submittable_facts, without_defaults
from service.model.request.entry import Entry, Json, entries_of, listed

Value = TypeVar("Value")


def cap_faults(request: SweepRequest, posted: Json) -> list[Fault]:
    """Count the product without expanding it, and refuse one above the cap."""
    curves = sum(
        entries_of(algorithm) * len(listed(request.scale))
        for each, algorithm in zip(request.algorithms, posted["algorithms"], strict=True)
        for environment in request.environments
        if each.runs_in(environment)
    )
    seeds = request.seeds if isinstance(request.seeds, int) else len(request.seeds)
    if (runs := curves * seeds) <= MAX_RUNS:
        return []
    message = (
        f"{curves} pairs of an entry (an algorithm with its weights and settings) and an "
        f"environment, times {seeds} seeds, are "
        f"{runs} runs; a sweep has at most {MAX_RUNS}"
    )
    return [Fault("seeds", message, MAX_RUNS)]


def name_faults(request: SweepRequest) -> list[Fault]:
    """Refuse names that are not in the catalogues."""
    algorithms = [(f"algorithms[{i}].name", each.name) for i, each in enumerate(request.algorithms)]
    environments = [(f"environments[{i}]", name) for i, name in enumerate(request.environments)]
    return [*_unknown(algorithms, catalogue.find), *_unknown(environments, submittable_facts)]


def product_faults(request: SweepRequest, posted: Json, entries: Sequence[Entry]) -> list[Fault]:
    """Refuse repeated seeds, environments and grid values, and what an algorithm cannot do.

    Of algorithms that are not in the catalogue, `name_faults` tells.
    """
    seeds = [] if isinstance(request.seeds, int) else request.seeds
    return [
        *_repeated({f"seeds[{i}]": seed for i, seed in enumerate(seeds)}),
        *_repeated(
            {
                f"environments[{i}]": without_defaults(name)
                for i, name in enumerate(request.environments)
            }
        ),
        *_environments_faults(request),
        *repeated_values(posted),
        *_useless_weights(request, entries),
        *_wrong_settings(request, posted, entries),
        *_impossible_pairs(request),
    ]


def _unknown(named: Iterable[tuple[str, str]], find: Callable[[str], object]) -> list[Fault]:
    """Ask a catalogue, which knows the nearest name, for each."""
    faults = []
    for field, name in named:
        try:
            find(name)
        except ValueError as unknown:
            faults.append(Fault(field, str(unknown)))
    return faults


def _repeated(values: Mapping[str, Value]) -> list[Fault]:
    """Refuse a value that stands in two fields."""
    first: dict[Value, str] = {}
    return [
        Fault(field, f"is the same as {first[value]}: all runs of a sweep must differ")
        for field, value in values.items()
        if first.setdefault(value, field) != field
    ]


def _environments_faults(request: SweepRequest) -> Iterator[Fault]:
    """Refuse an algorithm's environment that is not one of the sweep's, or is repeated."""
    for i, algorithm in enumerate(request.algorithms):
        own = {
            f"algorithms[{i}].environments[{j}]": name
            for j, name in enumerate(algorithm.environments or [])
        }
        yield from _repeated(own)
        for field, name in own.items():
            if name not in request.environments:
                yield Fault(field, f"{printable(name)!r} is not one of the sweep's environments")


def _known(request: SweepRequest) -> Iterator[tuple[int, AlgorithmRequest, Algorithm]]:
    """Yield the algorithms that the catalogue has, each with its place in the request."""
    for i, each in enumerate(request.algorithms):
        if not _unknown([("", each.name)], catalogue.find):
            yield i, each, catalogue.find(each.name)


def label_faults(request: SweepRequest, entries: Iterable[Entry]) -> list[Fault]:
    """Refuse labels of a request that another of its entries has, too."""
    first: dict[str, Entry] = {}
    taken: dict[str, Entry] = {}
    for entry in entries:
        if (earlier := first.setdefault(entry.label, entry)) is not entry:
            given = entry if request.algorithms[entry.item].label else earlier
            taken.setdefault(f"algorithms[{given.item}].label", given)
    return [
        Fault(field, f"another entry is called {printable(entry.label)!r} too: choose another")
        for field, entry in taken.items()
        if request.algorithms[entry.item].label
    ]


def _useless_weights(request: SweepRequest, entries: Sequence[Entry]) -> list[Fault]:
    weighed = {entry.item for entry in entries if entry.weights and any(entry.weights)}
    return [
        Fault(
            f"algorithms[{i}].weights",
            f"{asked.name} has no gradient terms to weigh: leave the weights out, or set them to 0",
            0,
        )
        for i, asked, algorithm in _known(request)
        if not algorithm.uses_weights and i in weighed
    ]


def _wrong_settings(
    request: SweepRequest, posted: Json, entries: Sequence[Entry]
) -> Iterator[Fault]:
    """Refuse settings that the config class does not take, each value of a grid once."""
    for i, _, algorithm in _known(request):
        settings, stated = algorithm.config_class(), posted["algorithms"][i].get("config", {})
        faults: dict[str, Fault] = {}
        for entry in (each for each in entries if each.item == i):
            try:
                settings(**entry.config)
            except ValidationError as refusal:
                for error in refusal.errors():
                    fault = _settings_fault(
                        f"algorithms[{i}].config", error, settings, entry.config, stated
                    )
                    faults.setdefault(fault.field, fault)
        yield from faults.values()


def _settings_fault(
    field: str, error: Mapping[str, Any], settings: type[Any], chosen: Json, stated: Json
) -> Fault:
    """Return the fault of a setting; `stated` may have a list where `chosen` has one of it."""
    name = error["loc"][0]
    if error["type"] == "unexpected_keyword_argument":
        return unknown_name(f"{field}.{name}", name, list(settings.__dataclass_fields__))
    values = stated.get(name)
    place = (values.index(chosen[name]),) if isinstance(values, list) else ()
    return faults_of([{**error, "loc": (field, name, *place, *error["loc"][1:])}])[0]


def _impossible_pairs(request: SweepRequest) -> list[Fault]:
    return [
        Fault(
            f"environments[{j}]",
            f"{asked.name} (algorithms[{i}]) needs the gradient of the reward, and "
            f"{environment} has none: its reward is piecewise constant. Leave one of them out.",
        )
        for i, asked, algorithm in _known(request)
        if algorithm.needs_reward_gradient
        for j, environment in enumerate(request.environments)
        if asked.runs_in(environment)
        and not _unknown([("", environment)], environment_facts)
        and not environment_facts(environment).reward_is_differentiable
    ]

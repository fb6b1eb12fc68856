"""What can be wrong with a posted sweep beyond the form of its fields."""

from collections.abc import Iterable, Iterator, Mapping
from typing import TypeVar

import physics
from service.algorithm import algorithm_facts, algorithm_names
from service.environment import environment_facts
from service.problems import Fault
from service.schemas.sweep_request import MAX_RUNS, AlgorithmRequest, SweepRequest, Weights
from service.submission.nearest import unknown_name

Value = TypeVar("Value")


def cap_faults(request: SweepRequest) -> list[Fault]:
    """Count the product without expanding it, and refuse one above the cap."""
    curves = sum(len(_listed(each)) for each in request.algorithms) * len(request.environments)
    seeds = request.seeds if isinstance(request.seeds, int) else len(request.seeds)
    if (runs := curves * seeds) <= MAX_RUNS:
        return []
    message = (
        f"{curves} pairs of algorithm (with its weights) and environment, times {seeds} seeds, are "
        f"{runs} runs; a sweep has at most {MAX_RUNS}"
    )
    return [Fault("seeds", message, MAX_RUNS)]


def name_faults(request: SweepRequest) -> list[Fault]:
    """Refuse names that are not in the catalogues."""
    algorithms = [(f"algorithms[{i}].name", each.name) for i, each in enumerate(request.algorithms)]
    environments = [(f"environments[{i}]", name) for i, name in enumerate(request.environments)]
    return [
        *_unknown(algorithms, algorithm_names()),
        *_unknown(environments, physics.names()),
    ]


def product_faults(request: SweepRequest) -> list[Fault]:
    """Refuse what would make two equal runs, and what an algorithm cannot do."""
    seeds = [] if isinstance(request.seeds, int) else request.seeds
    return [
        *_repeated({f"seeds[{i}]": seed for i, seed in enumerate(seeds)}),
        *_repeated({f"environments[{i}]": name for i, name in enumerate(request.environments)}),
        *_repeated(dict(_variants(request))),
        *_useless_weights(request),
        *_impossible_pairs(request),
    ]


def _unknown(named: Iterable[tuple[str, str]], known: list[str]) -> list[Fault]:
    return [unknown_name(field, name, known) for field, name in named if name not in known]


def _repeated(values: Mapping[str, Value]) -> list[Fault]:
    """Refuse a value that stands in two fields."""
    first: dict[Value, str] = {}
    return [
        Fault(field, f"is the same as {first[value]}: every run of a sweep is a different one")
        for field, value in values.items()
        if first.setdefault(value, field) != field
    ]


def _variants(request: SweepRequest) -> Iterator[tuple[str, object]]:
    """Yield what tells curves of one environment apart, by the field that says it."""
    for i, algorithm in enumerate(request.algorithms):
        config = tuple(sorted((name, repr(value)) for name, value in algorithm.config.items()))
        listed = _listed(algorithm)
        for j, weights in enumerate(listed):
            field = f"algorithms[{i}].weights[{j}]" if len(listed) > 1 else f"algorithms[{i}]"
            yield field, (algorithm.name, config, weights and (weights.w1, weights.w2))


def _useless_weights(request: SweepRequest) -> list[Fault]:
    return [
        Fault(
            f"algorithms[{i}].weights",
            f"{algorithm.name} has no gradient terms to weigh: leave the weights out, or 0",
            0,
        )
        for i, algorithm in enumerate(request.algorithms)
        if not algorithm_facts(algorithm.name).uses_weights
        and any(weights and (weights.w1 or weights.w2) for weights in _listed(algorithm))
    ]


def _impossible_pairs(request: SweepRequest) -> list[Fault]:
    return [
        Fault(
            f"environments[{j}]",
            f"{algorithm.name} (algorithms[{i}]) needs the gradient of the reward, and "
            f"{environment} has none: its reward is piecewise constant. Leave one of them out.",
        )
        for i, algorithm in enumerate(request.algorithms)
        if algorithm_facts(algorithm.name).needs_reward_gradient
        for j, environment in enumerate(request.environments)
        if not environment_facts(environment).reward_is_differentiable
    ]


def _listed(algorithm: AlgorithmRequest) -> list[Weights] | list[None]:
    """Return the pairs of weights; one None where the preset's are asked for."""
    if algorithm.weights is None:
        return [None]
    return [algorithm.weights] if isinstance(algorithm.weights, Weights) else algorithm.weights

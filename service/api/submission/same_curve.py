"""Entries that have the same curve once presets are filled in and numbers are compared.

Two entries that are one cell in an environment are refused: its seeds would be counted twice. A
hybrid whose weights are (0, 0) is another cell than the algorithm it extends, and bit for bit its
curve: a notice says so.
"""

from collections.abc import Hashable, Iterable, Sequence
from dataclasses import asdict, fields
from typing import Any, NamedTuple

from algorithms import catalogue
from service.api.refusals.problems import Fault
from service.model.request.entry import Entry, setting_text
from workers.messages.run_spec import NO_WEIGHTS, RunSpec, Weights

Cells = Iterable[tuple[Entry, RunSpec]]


class _Curve(NamedTuple):
    """What a curve depends on; equal numbers are equal, whatever they were written as."""

    algorithm: str
    environment: str
    weights: Weights
    timesteps: int
    settings: tuple[Hashable, ...]


def repetition_faults(cells: Cells) -> list[Fault]:
    """Refuse each entry that is an earlier one again, with the environments where it is."""
    first: dict[_Curve, Entry] = {}
    repeated: dict[tuple[str, str], list[tuple[RunSpec, Entry, Entry]]] = {}
    for entry, spec in cells:
        curve = _curve(spec)
        earlier = entry if curve is None else first.setdefault(curve, entry)
        if earlier is not entry:
            repeated.setdefault((entry.field, earlier.field), []).append((spec, entry, earlier))
    return [_repetition(found) for found in repeated.values()]


def notices(cells: Cells) -> list[str]:
    """Tell of each hybrid without gradient terms, and of the entries whose curve it repeats."""
    alike: dict[_Curve, list[Entry]] = {}
    hybrids = []
    for entry, spec in cells:
        curve = _curve(spec)
        if curve is None:
            continue
        bare = _without_gradient(curve)
        alike.setdefault(bare, []).append(entry)
        if catalogue.find(spec.algorithm).uses_weights and spec.weights == NO_WEIGHTS:
            hybrids.append((entry, spec, bare))
    told: dict[tuple[str, str, tuple[str, ...]], list[str]] = {}
    for entry, spec, bare in hybrids:
        others = tuple(other.field for other in alike[bare] if other is not entry)
        told.setdefault((entry.field, spec.algorithm, others), []).append(spec.environment)
    return [_notice(*what, where) for what, where in told.items()]


def _curve(spec: RunSpec) -> _Curve | None:
    """Return what the cell's curve depends on; None where its settings are refused anyway."""
    try:
        settings = catalogue.find(spec.algorithm).config_class()(**spec.config)
    except ValueError:
        return None
    values = tuple(_hashable(getattr(settings, field.name)) for field in fields(settings))
    return _Curve(spec.algorithm, spec.environment, spec.weights, spec.timesteps, values)


def _hashable(value: Any) -> Hashable:
    return tuple(map(_hashable, value)) if isinstance(value, list | tuple) else value


def _without_gradient(curve: _Curve) -> _Curve:
    if curve.weights != NO_WEIGHTS:
        return curve
    return curve._replace(algorithm=catalogue.baseline(curve.algorithm) or curve.algorithm)


def _repetition(found: Sequence[tuple[RunSpec, Entry, Entry]]) -> Fault:
    spec, entry, earlier = found[0]
    where = " and ".join(each.environment for each, _, _ in found)
    message = (
        f"is the same as {_named(earlier)} in {where}: with presets filled in, both are "
        f"{_described(spec, {**entry.config, **earlier.config})}. Leave one out, change it, or "
        f"give it `environments` without {where}."
    )
    return Fault(entry.field, message)


def _named(entry: Entry) -> str:
    """Where an entry stands in the request, and at which point of a grid."""
    return f"{entry.field} with {entry.point}" if entry.point else entry.field


def _described(spec: RunSpec, stated: Iterable[str]) -> str:
    """`hybrid-ddpg with w1=1, w2=0, noise=0.2`: settings that are stated or the preset's."""
    algorithm = catalogue.find(spec.algorithm)
    settings = asdict(algorithm.config_class()(**spec.config))
    pair = spec.weights._asdict() if algorithm.uses_weights else {}
    names = sorted({*spec.config, *stated})
    told = {**pair, **{name: settings[name] for name in names}}
    text = ", ".join(f"{name}={setting_text(value)}" for name, value in told.items())
    return f"{spec.algorithm} with {text or 'its defaults'}"


def _notice(field: str, algorithm: str, others: Sequence[str], environments: Sequence[str]) -> str:
    baseline = catalogue.baseline(algorithm) or "the algorithm that it extends"
    repeats = f" It repeats {' and '.join(others)}." if others else ""
    return (
        f"{field} ({algorithm}) has the weights (0, 0) in {' and '.join(environments)}: without "
        f"gradient terms it is {baseline}, bit for bit, and says nothing of gradient matching."
        f"{repeats}"
    )

"""What can be wrong with a grid: joint lists of different lengths, and repeated values."""

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

from service.api.refusals.problems import Fault, printable
from service.model.request.entry import Json, axes_of, listed


def zip_faults(posted: Json) -> Iterator[Fault]:
    """Refuse names that go together and are not lists of one length."""
    for i, algorithm in enumerate(posted["algorithms"]):
        lists = [axes_of(pair, algorithm.get("config") or {}) for pair in _pairs(algorithm)]
        yield from _zip_faults(f"algorithms[{i}].zip", algorithm.get("zip") or (), lists)


def _zip_faults(
    field: str, together: Sequence[str], grids: Sequence[dict[str, list[Any]]]
) -> Iterator[Fault]:
    counts = Counter(together)
    for j, name in enumerate(together):
        if counts[name] > 1:
            yield Fault(f"{field}[{j}]", f"{printable(name)!r} is named twice")
        elif any(len(axes.get(name, ())) < 2 for axes in grids):
            known = ", ".join(n for n, values in grids[0].items() if len(values) > 1) or "none"
            message = f"{printable(name)!r} is not a list of this algorithm (its lists: {known})"
            yield Fault(f"{field}[{j}]", message)
    for axes in grids:
        lengths = {name: len(axes[name]) for name in together if name in axes}
        if len(set(lengths.values())) > 1:
            told = ", ".join(f"{name} has {length}" for name, length in lengths.items())
            yield Fault(field, f"lists that advance together must have one length: {told}")
            return


def repeated_values(posted: Json) -> Iterator[Fault]:
    """Refuse a value that a list of a grid has twice, unless the list goes together with others."""
    yield from _repeated("scale", posted.get("scale"))
    for i, algorithm in enumerate(posted["algorithms"]):
        together = algorithm.get("zip") or ()
        stated = {f"config.{name}": values for name, values in _config(algorithm).items()}
        for j, pair in enumerate(_pairs(algorithm)):
            place = f"[{j}]" if isinstance(algorithm.get("weights"), list) else ""
            stated |= {f"weights{place}.{name}": values for name, values in (pair or {}).items()}
        for name, values in stated.items():
            if name.rpartition(".")[2] not in together:
                yield from _repeated(f"algorithms[{i}].{name}", values)


def _repeated(field: str, values: Any) -> Iterator[Fault]:
    for place, value in enumerate(listed(values)):
        # As a pair: to Python, 1 and True are equal.
        seen = [(type(each) is bool, each) for each in values[:place]] if place else []
        if (type(value) is bool, value) in seen:
            first = seen.index((type(value) is bool, value))
            yield Fault(f"{field}[{place}]", f"is the same as {field}[{first}]: give each once")


def _pairs(algorithm: Json) -> list[Any]:
    return listed(algorithm.get("weights"))


def _config(algorithm: Json) -> Json:
    config: Json = algorithm.get("config") or {}
    return config

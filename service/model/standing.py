"""The result of a cell: one entry in one environment, all of whose runs succeeded."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from workers.messages.random_return import RandomReturn

Zeros = Mapping[tuple[str, int], RandomReturn]


@dataclass(frozen=True)
class CellStanding:
    """The mean final score of a cell, raw."""

    sweep_id: str
    entry: int
    environment: str
    environment_version: int
    mean: float


@dataclass(frozen=True)
class Best:
    """The best cell of a sweep; `score` is normalised, `start` and `unit` are of that scale."""

    cell: CellStanding
    score: float
    start: float
    unit: float


def best_of(
    cells: Iterable[CellStanding], zeros: Zeros, best_return: Callable[[str], float]
) -> dict[str, Best]:
    """Return the best cell of each sweep, by normalised score; tasks without a scale are left out.

    `zeros` are the random returns, `best_return(environment)` is the one of the scale.
    """
    found: dict[str, Best] = {}
    for cell in cells:
        zero = zeros.get((cell.environment, cell.environment_version))
        if zero is None:
            continue
        unit = best_return(cell.environment) - zero.mean
        best = Best(cell, (cell.mean - zero.mean) / unit, zero.mean, unit)
        if cell.sweep_id not in found or best.score > found[cell.sweep_id].score:
            found[cell.sweep_id] = best
    return found

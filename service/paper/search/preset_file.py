"""algorithms/presets.toml: the best cell of each learner on each task, from the search."""

import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

from algorithms import catalogue
from service.paper.search import tuning
from service.paper.search.tuning import (
    AS_ON,
    PAIRS,
    SPACES,
    TIMESTEPS,
    Outcome,
    best,
    searched_cells,
)

FILE = Path(catalogue.__file__).with_name("presets.toml")
HEAD = """\
# Settings and weights (w1, w2) by learner and task, as `d3pg paper presets` read them off
# results/tuning.csv. "other": tasks that are not named, as one of your own.
"""

Rows = dict[str, Any]
"""What was chosen by task."""
Cell = TypeVar("Cell")


def lacking(rows: Sequence[Outcome]) -> list[str]:
    """Parts of the search that have not ended, as "learner, task"."""
    return [
        f"{name}, {task}"
        for name, task in tuning.all_searches()
        if not tuning.is_whole(rows, task, name)
    ]


def presets_of(rows: Sequence[Outcome]) -> dict[str, dict[str, Rows]]:
    """Settings and weights by learner and task; ValueError if a search has not ended.

    A learner with a space has settings of its own. A hybrid of the paper's losses has those of
    what it extends, and weights of its own. One with bounded losses has one pair for all tasks.
    """
    if missing := lacking(rows):
        raise ValueError(
            f"the search has not ended: it lacks {'; '.join(missing)}; go on with `d3pg paper tune`"
        )
    tables = {name: {"settings": _settings(rows, name)} for name in SPACES}
    for name, space in SPACES.items():
        if catalogue.find(space.algorithm).uses_weights:
            tables[name]["weights"] = {"other": list(space.weights)}
    return tables | {name: {"weights": _weights(rows, name)} for name in PAIRS}


def _settings(rows: Sequence[Outcome], name: str) -> Rows:
    """By task the settings of the best cell."""
    space = SPACES[name]
    tasks = space.tasks()

    def area(config: Mapping[str, Any], task: str) -> float:
        settings = {**space.fixed.get(task, {}), **config}
        return _area(rows, task, name, lambda row: row.config == settings)

    chosen = {task: best(rows, task, name).config for task in tasks}
    return {"other": _least_regret(space.configs, tasks, area), **_with_others(chosen)}


def _weights(rows: Sequence[Outcome], name: str) -> Rows:
    """By task the best pair of a hybrid."""

    def area(pair: tuple[float, float], task: str) -> float:
        return _area(rows, task, name, lambda row: row.weights == pair)

    tasks = list(TIMESTEPS)
    chosen = {task: list(best(rows, task, name).weights) for task in tasks}
    other = _least_regret(PAIRS[name], tasks, area)
    return {"other": list(other), **_with_others(chosen)}


def _with_others(chosen: Rows) -> Rows:
    """What was chosen, and the same for the tasks that follow one of those."""
    return {**chosen, **{task: chosen[followed] for task, followed in AS_ON.items()}}


def _area(
    rows: Iterable[Outcome], task: str, name: str, is_cell: Callable[[Outcome], bool]
) -> float:
    return max(row.area for row in searched_cells(rows, task, name) if is_cell(row))


def _least_regret(
    cells: Sequence[Cell], tasks: Sequence[str], area: Callable[[Cell, str], float]
) -> Cell:
    """The cell with the least mean loss against the best of each task; the first of equals."""
    most = {task: max(area(cell, task) for cell in cells) for task in tasks}
    return min(cells, key=lambda cell: sum(most[task] - area(cell, task) for task in tasks))


def as_toml(tables: Mapping[str, Mapping[str, Rows]]) -> str:
    """The text of presets.toml, which `tomllib` reads back to the same."""
    return HEAD + "".join(
        f"\n[{_key(name)}.{kind}]\n"
        + "".join(f"{_key(task)} = {_value(value)}\n" for task, value in rows.items())
        for name, table in tables.items()
        for kind, rows in table.items()
    )


def _key(name: str) -> str:
    return name if re.fullmatch(r"[\w-]+", name, re.ASCII) else json.dumps(name)


def _value(value: Any) -> str:
    """A list, or a table of a line; numbers, words and truths are as in JSON."""
    if not isinstance(value, Mapping):
        return json.dumps(value)
    pairs = ", ".join(f"{_key(key)} = {json.dumps(each)}" for key, each in value.items())
    return f"{{ {pairs} }}" if pairs else "{}"

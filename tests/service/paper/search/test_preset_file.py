"""The presets' file is what the recorded search found best, and reads back to what was written."""

import tomllib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from algorithms import catalogue
from algorithms.presets import CHOSEN, FORMS
from service.paper.search import preset_file, tuning, tuning_file
from service.paper.search.preset_file import as_toml, lacking, presets_of
from service.paper.search.tuning import PAIRS, SEEDS, SPACES, TIMESTEPS, Outcome, space_of
from workers.messages.run_spec import Weights

RESULTS = Path(__file__).parents[4] / "results"


def outcome(task: str, algorithm: str, weights: Weights, config: Any, area: float) -> Outcome:
    return Outcome(task, algorithm, weights, config, area, 0.0, len(SEEDS), "a")


def whole_search(areas: Mapping[tuple[str, str, int], float]) -> list[Outcome]:
    """A search in which the cell (learner, task, place) has the area given, else 0."""
    rows = [
        outcome(task, space.algorithm, space.weights, cell, areas.get((name, task, place), 0.0))
        for name, space in SPACES.items()
        for task in space.tasks()
        for place, cell in enumerate(space.on(task))
    ]
    return rows + [
        outcome(task, name, pair, space_of(name).on(task)[0], areas.get((name, task, place), 0.0))
        for name, pairs in PAIRS.items()
        for task in TIMESTEPS
        for place, pair in enumerate(pairs)
    ]


def test_the_file_is_what_the_recorded_search_found_best() -> None:
    rows = tuning_file.read(RESULTS)
    assert not lacking(rows)
    assert as_toml(presets_of(rows)) == preset_file.FILE.read_text(encoding="utf-8")


def test_the_best_cell_of_each_task_is_chosen() -> None:
    rows = whole_search({("ddpg", "Pendulum", 4): 0.5, ("hybrid-ddpg", "Acrobot", 3): 0.1})
    chosen = presets_of(rows)
    assert chosen["ddpg"]["settings"]["Pendulum"] == SPACES["ddpg"].on("Pendulum")[4]
    assert chosen["ddpg"]["settings"]["CartPole"] == SPACES["ddpg"].on("CartPole")[0]
    assert chosen["hybrid-ddpg"]["weights"]["Acrobot"] == list(PAIRS["hybrid-ddpg"][3])
    assert chosen["hybrid-ddpg-robust"]["weights"] == {"other": [1.0, 0.1]}
    assert "settings" not in chosen["hybrid-ddpg"]


def test_weights_of_an_earlier_space_are_not_chosen() -> None:
    rows = whole_search({})
    earlier = outcome("Pendulum", "hybrid-sac", PAIRS["hybrid-sac"][3], {"rate": 0.5}, 0.9)
    assert presets_of([*rows, earlier]) == presets_of(rows)
    alone = [row for row in rows if (row.environment, row.algorithm) != ("Pendulum", "hybrid-sac")]
    missing = [replace(earlier, weights=pair) for pair in PAIRS["hybrid-sac"]]
    assert lacking([*alone, *missing]) == ["hybrid-sac, Pendulum"]


def test_tasks_that_are_not_searched_have_what_was_best_on_another() -> None:
    chosen = presets_of(whole_search({("td3", "HalfCheetah", 2): 0.5}))
    for task in ("Hopper", "Walker2d"):
        assert chosen["td3"]["settings"][task] == SPACES["td3"].on("HalfCheetah")[2]
        assert task not in TIMESTEPS


def test_other_tasks_get_the_cell_that_loses_least_on_average() -> None:
    """Cell 5 is the best nowhere, and second everywhere."""
    areas = {("ddpg", task, place % 5): 1.0 for place, task in enumerate(TIMESTEPS)}
    areas |= {("ddpg", task, 5): 0.9 for task in TIMESTEPS}
    chosen = presets_of(whole_search(areas))
    assert chosen["ddpg"]["settings"]["other"] == SPACES["ddpg"].configs[5]
    assert chosen["ddpg"]["settings"]["HalfCheetah"]["cycle_updates"] == 100
    assert "cycle_updates" not in chosen["ddpg"]["settings"]["other"]
    pairs = {("hybrid-sac", task, 2): 0.3 for task in TIMESTEPS}
    other = presets_of(whole_search(pairs))["hybrid-sac"]["weights"]["other"]
    assert other == list(PAIRS["hybrid-sac"][2])


def test_a_search_that_has_not_ended_chooses_nothing() -> None:
    rows = [row for row in whole_search({}) if row.environment != "MountainCar"]
    with pytest.raises(ValueError, match=r"lacks ddpg, MountainCar; .*`d3pg paper tune`"):
        presets_of(rows)


def test_what_is_written_is_read_back() -> None:
    chosen = presets_of(whole_search({}))
    assert tomllib.loads(as_toml(chosen)) == chosen


@pytest.mark.parametrize("row", CHOSEN)
def test_every_row_is_of_a_learner_or_of_a_form_and_can_be_trained(row: str) -> None:
    forms = {form.row: name for name, forms in FORMS.items() for form in forms}
    algorithm = catalogue.find(forms.get(row, row))
    for settings in CHOSEN[row].get("settings", {}).values():
        algorithm.config_class()(**settings)
    assert bool(CHOSEN[row].get("weights")) == algorithm.uses_weights
    assert row in tuning.SPACES or row in tuning.PAIRS

"""Entries of a request: what each is called, and which runs are its own."""

from typing import Any

import pytest

from service.model.request.entry import Entries, entries_of, setting_text
from workers.messages.run_spec import Weights


def entries(*algorithms: dict[str, Any], environments: str = "MassPoint Pendulum") -> Entries:
    request = {"algorithms": algorithms, "environments": environments.split(), "seeds": 3}
    return Entries(request)


def labels(*algorithms: dict[str, Any]) -> list[str]:
    return [entry.label for entry in entries(*algorithms).all]


def test_an_algorithm_alone_goes_by_its_name() -> None:
    assert labels({"name": "ddpg"}, {"name": "sac"}) == ["ddpg", "sac"]
    assert labels({"name": "ddpg", "config": {"noise": 0.3}}) == ["ddpg"]


def test_what_is_not_stated_is_no_part_of_the_name() -> None:
    """Presets differ from task to task; the entry that leaves them in place is one."""
    assert labels({"name": "ddpg"}, {"name": "ddpg", "config": {"noise": 0.1}}) == [
        "ddpg",
        "ddpg noise=0.1",
    ]


def test_only_what_tells_from_siblings_is_named() -> None:
    assert labels(
        {"name": "ddpg", "config": {"tau": 0.02, "noise": 0.1}},
        {"name": "ddpg", "config": {"tau": 0.02, "noise": 0.2}},
        {"name": "sac", "config": {"tau": 0.02}},
    ) == ["ddpg noise=0.1", "ddpg noise=0.2", "sac"]


def test_a_placebo_alone_says_that_it_is_one() -> None:
    placebo = {"name": "hybrid-ddpg", "config": {"placebo": "shuffled"}}
    assert labels({"name": "ddpg"}, placebo) == ["ddpg", 'hybrid-ddpg placebo="shuffled"']
    assert labels({**placebo, "label": "other gradients"}) == ["other gradients"]


def test_each_pair_of_weights_is_an_entry() -> None:
    found = entries(
        {"name": "ddpg"}, {"name": "hybrid-ddpg", "weights": [{"w1": 1}, {"w1": 0.1, "w2": 0.01}]}
    )
    assert [entry.label for entry in found.all] == [
        "ddpg",
        "hybrid-ddpg w1=1 w2=0",
        "hybrid-ddpg w1=0.1 w2=0.01",
    ]
    assert [entry.field for entry in found.all] == [
        "algorithms[0]",
        "algorithms[1].weights[0]",
        "algorithms[1].weights[1]",
    ]
    assert labels({"name": "hybrid-ddpg"}, {"name": "hybrid-ddpg", "weights": {"w1": 1}}) == [
        "hybrid-ddpg",
        "hybrid-ddpg w1=1 w2=0",
    ]


def test_near_weights_have_different_names() -> None:
    near = [{"w1": 0.1}, {"w1": 0.10000000001}]
    assert labels({"name": "hybrid-ddpg", "weights": near}) == [
        "hybrid-ddpg w1=0.1",
        "hybrid-ddpg w1=0.10000000001",
    ]


def test_the_same_in_other_environments_is_told_apart_by_those() -> None:
    assert labels(
        {"name": "ddpg", "environments": ["MassPoint"]},
        {"name": "ddpg", "environments": ["Pendulum"]},
    ) == ["ddpg in MassPoint", "ddpg in Pendulum"]


def test_a_label_of_ones_own() -> None:
    """Where it stands for several entries, what tells those apart follows it."""
    assert labels(
        {"name": "ddpg", "label": "base"},
        {"name": "ddpg", "config": {"noise": 0.1}},
        {"name": "ddpg", "label": "mine", "config": {"noise": [0.3, 0.4], "tau": 0.02}},
    ) == ["base", "ddpg noise=0.1", "mine noise=0.3", "mine noise=0.4"]


def test_a_list_is_a_grid() -> None:
    found = entries(
        {"name": "hybrid-ddpg", "weights": {"w1": [0, 1]}, "config": {"noise": [0.1, 0.2]}}
    )
    assert [entry.label for entry in found.all] == [
        "hybrid-ddpg w1=0 noise=0.1",
        "hybrid-ddpg w1=0 noise=0.2",
        "hybrid-ddpg w1=1 noise=0.1",
        "hybrid-ddpg w1=1 noise=0.2",
    ]
    second = found.all[1]
    assert (second.weights, second.config) == (Weights(0, 0), {"noise": 0.2})
    assert second.point == "w1=0, noise=0.2"
    assert [entry.place for entry in found.all] == [0, 1, 2, 3]


def test_lists_that_go_together() -> None:
    grid = {"w1": [0, 1], "w2": [2, 3]}
    zipped = {"name": "sac", "weights": grid, "config": {"rate": [1, 2]}, "zip": ["w1", "rate"]}
    found = entries(zipped).all
    assert [(*entry.stated.values(),) for entry in found] == [
        (0, 2, 1),
        (0, 3, 1),
        (1, 2, 2),
        (1, 3, 2),
    ]
    assert entries_of(zipped) == len(found)


def test_shares_of_the_timesteps_are_entries() -> None:
    request = {"algorithms": [{"name": "ddpg"}], "environments": ["Pendulum"], "scale": [0.5, 1]}
    found = Entries(request).all
    assert [(entry.label, entry.scale) for entry in found] == [
        ("ddpg scale=0.5", 0.5),
        ("ddpg scale=1", 1),
    ]


@pytest.mark.parametrize("seeds", [2, [7, 3]])
def test_cells_lie_environment_by_environment(seeds: Any) -> None:
    found = Entries(
        {
            "algorithms": [
                {"name": "ddpg"},
                {"name": "gd", "environments": ["Pendulum"]},
                {"name": "hybrid-ddpg", "weights": [{"w1": 1}, {"w2": 1}]},
            ],
            "environments": ["Acrobot", "Pendulum"],
            "seeds": seeds,
        }
    )
    hybrids = ["hybrid-ddpg w1=1 w2=0", "hybrid-ddpg w1=0 w2=1"]
    assert [entry.label for _, entry in found.cells] == ["ddpg", *hybrids, "ddpg", "gd", *hybrids]
    assert [entry.place for _, entry in found.cells] == [0, 2, 3, 0, 1, 2, 3]
    assert [environment for environment, _ in found.cells] == ["Acrobot"] * 3 + ["Pendulum"] * 4


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (1, "1"),
        (1.0, "1"),
        (1_000_000, "1000000"),
        (1e6, "1000000"),
        (1e-05, "1e-05"),
        (1e30, "1e+30"),
        (0.1 + 0.2, "0.30000000000000004"),
        (True, "true"),
        (None, "null"),
        ("fast", '"fast"'),
        ([1, 2], "[1, 2]"),
    ],
)
def test_settings_as_labels_show_them(value: Any, text: str) -> None:
    assert setting_text(value) == text

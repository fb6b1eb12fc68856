"""Entries of a request: what each is called, and which runs are its own."""

from typing import Any

import pytest

from service.model.entry import Entries, setting_text


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


@pytest.mark.parametrize("seeds", [2, [7, 3]])
def test_a_runs_place_says_its_entry(seeds: Any) -> None:
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
    by_run = [found.label(f"3f9a0c51b7de-{ordinal}") for ordinal in range(14)]
    hybrids = ["hybrid-ddpg w1=1 w2=0", "hybrid-ddpg w1=0 w2=1"]
    expected = ["ddpg", *hybrids, "ddpg", "gd", *hybrids]
    assert by_run == [label for label in expected for _ in range(2)]


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

"""Searches over REST: what is refused, what is said, what is answered."""

from typing import Any

import pytest
from starlette.testclient import TestClient

from service.model.inquiry.search import search_seeds
from service.queue.question_rounds import look_at_all
from service.store.store import Store
from tests.service.training import RANDOM, random_return, train
from workers.messages.run_spec import RunSpec

NOISES = [0.1, 0.2, 0.3, 0.4, 0.5]
SEED_COST = 5 * 800 + 2 * 1600
"""Timesteps of a seed: five entries to 800, two of them to 2400."""


def searching(budget: int = 3 * SEED_COST, **fields: Any) -> dict[str, Any]:
    """A search among five entries of ddpg."""
    sweep = {
        "algorithms": [{"name": "ddpg", "config": {"noise": NOISES}}],
        "environments": ["Pendulum"],
        "seeds": 2,
        "timesteps": 2400,
        "search": {"budget": budget},
    }
    return {**sweep, **fields}


def worth(spec: RunSpec, timestep: int) -> float:
    """Noise 0.4 is the best."""
    return float(RANDOM * (1 - timestep / 2400 * (1 - abs(spec.config["noise"] - 0.4))))


def train_rungs(store: Store) -> None:
    """Train each rung to its end, and look."""
    train(store, 1, worth)
    while look_at_all(store):
        train(store, 3, worth)


def faults(client: TestClient, sweep: dict[str, Any]) -> dict[str, str]:
    """What is wrong with it, by field."""
    answer = client.post("/api/v1/sweeps", json=sweep)
    assert answer.status_code == 422, answer.text
    return {each["field"]: each["message"] for each in answer.json()["errors"]}


@pytest.mark.parametrize(
    ("fields", "field", "said"),
    [
        ({"seeds": [1, 2]}, "seeds", "takes seeds of its own"),
        (
            {"seeds": [100, 116]},
            "seeds",
            "for choosing settings (100 to 115; 1,000,000,000 to",
        ),
        ({"seeds": [100]}, "seeds", "2 or more seeds"),
        ({"seeds": 1}, "seeds", "2 or more"),
        ({"scale": [0.1, 1.0]}, "scale", "equal timesteps"),
        ({"search": {"budget": 14_399}}, "search.budget", "2 seeds the search takes 14,400"),
        ({"search": {"budget": 0}}, "search.budget", "greater than or equal to 1"),
        ({"search": {}}, "search.budget", "required"),
        ({"search": {"budget": 10**6, "reduction": 1}}, "search.reduction", "equal to 2"),
        ({"search": {"budget": 10**6, "score": "best"}}, "search.score", "'area' or 'final'"),
        ({"algorithms": [{"name": "ddpg"}]}, "search", "one entry in Pendulum"),
        (
            {"algorithms": [{"name": "gd", "config": {"rate": [0.1, 0.01, 0.03, 0.3]}}]},
            "search.reduction",
            "gd cannot go on from where they ended: give 4 or more",
        ),
        (
            {"algorithms": [{"name": "ddpg"}, {"name": "mpc"}], "timesteps": None},
            "timesteps",
            "the presets of its learners differ in Pendulum (ddpg 20,000, mpc",
        ),
        (
            {"question": {"compare": ["ddpg noise=0.1"], "with": "ddpg noise=0.2"}},
            "search",
            "a search or a question, not both",
        ),
    ],
)
def test_what_cannot_be_searched_is_refused_by_field(
    idle_client: TestClient, fields: dict[str, Any], field: str, said: str
) -> None:
    assert said in faults(idle_client, searching(**fields))[field]


def test_the_fewest_timesteps_of_a_search_are_enough(idle_client: TestClient) -> None:
    sweep = searching(budget=2 * SEED_COST)
    answer = idle_client.post("/api/v1/sweeps?dry_run=true", json=sweep).json()
    assert answer["timesteps"] == 2 * SEED_COST


def test_whoever_searches_is_told_what_will_be_trained(idle_client: TestClient) -> None:
    sweep = searching(budget=4 * SEED_COST - 1)
    answer = idle_client.post("/api/v1/sweeps?dry_run=true", json=sweep).json()
    assert answer["runs"]["total"] == 15
    assert answer["timesteps"] == 3 * SEED_COST
    assert {cell["timesteps"] for cell in answer["cells"]} == {800}
    assert answer["notices"] == [
        "The search takes 21,600 of its budget of 28,799 timesteps, with 3 seeds. Pendulum: 5 "
        "entries to 800, then 2 entries to 2,400.",
        "Its seeds are 1,000,000,000 to 1,000,000,002, which no question takes: ask with others "
        "whether the best entry is better.",
    ]


def test_seeds_that_are_kept_for_choosing_can_be_named(idle_client: TestClient) -> None:
    sweep = searching(budget=9 * SEED_COST, seeds=[100, 103])
    answer = idle_client.post("/api/v1/sweeps?dry_run=true", json=sweep).json()
    assert (answer["runs"]["total"], answer["timesteps"]) == (10, 2 * SEED_COST)
    assert answer["notices"][1].startswith("Its seeds are 100; 103, which no question takes")
    short = searching(budget=2 * SEED_COST - 1, seeds=[100, 103])
    assert "with 2 seeds" in faults(idle_client, short)["search.budget"]


def test_the_estimate_is_of_all_rungs(idle_client: TestClient) -> None:
    one_rung = {"budget": 2 * 5 * 2400, "reduction": 5}
    costs = [
        idle_client.post("/api/v1/sweeps?dry_run=true", json=sweep).json()["estimate"]
        for sweep in (searching(budget=2 * SEED_COST), searching(search=one_rung))
    ]
    shares = costs[0]["core_seconds"] / costs[1]["core_seconds"]
    assert shares == pytest.approx(SEED_COST / (5 * 2400), rel=0.01)


def test_a_search_climbs_and_finds_the_best(client: TestClient, store: Store) -> None:
    store.record_random_return(random_return("Pendulum", RANDOM))
    sweep = client.post("/api/v1/sweeps", json=searching()).json()["id"]
    path = f"/api/v1/sweeps/{sweep}/search"
    first = client.get(path).json()
    [task] = first["tasks"]
    assert (first["is_settled"], task["winner"], task["algorithm"]) == (False, None, None)
    assert task["sentence"] == "rung 1 of 2: 5 entries to 800 timesteps"
    assert [rung["state"] for rung in task["rungs"]] == ["climbing", "to come"]
    assert {each["climbing"] for each in task["rungs"][0]["standings"]} == {3}
    assert first["seeds"] == list(search_seeds(3))
    train_rungs(store)
    found = client.get(path).json()
    [task] = found["tasks"]
    assert (found["is_settled"], found["timesteps"]) == (True, 3 * SEED_COST)
    assert task["winner"] == "ddpg noise=0.4"
    assert task["algorithm"] == {"name": "ddpg", "config": {"noise": 0.4}}
    assert task["sentence"].startswith("ddpg noise=0.4 is the best of 5: 0.")
    last = task["rungs"][-1]["standings"]
    assert [(each["label"], each["goes_on"]) for each in last] == [
        ("ddpg noise=0.4", True),
        ("ddpg noise=0.5", False),
    ]
    assert client.get(f"/api/v1/sweeps/{sweep}").json()["progress"] == 1.0


def test_a_question_about_what_was_searched_says_so_and_takes_other_seeds(
    client: TestClient, store: Store
) -> None:
    store.record_random_return(random_return("Pendulum", RANDOM))
    search = client.post("/api/v1/sweeps", json=searching()).json()["id"]
    train_rungs(store)
    asked = {
        "algorithms": [{"name": "ddpg", "config": {"noise": 0.4}}, {"name": "sac"}],
        "environments": ["Pendulum"],
        "seeds": 4,
        "timesteps": 2400,
        "question": {"compare": ["ddpg"], "with": "sac", "max_seeds": 8},
    }
    question = client.post("/api/v1/sweeps", json=asked).json()["id"]
    verdict = client.get(f"/api/v1/sweeps/{question}/verdict").json()
    assert verdict["searches"] == [search]
    expected = f"Sweep {search} searched these settings on seeds 1,000,000,000 to 1,000,000,002."
    assert verdict["kept_apart"].endswith(expected)
    client.post("/api/v1/sweeps", json=searching())  # what was searched later chose nothing here
    assert client.get(f"/api/v1/sweeps/{question}/verdict").json()["searches"] == [search]
    other = {**asked, "algorithms": [{"name": "ddpg", "config": {"noise": 0.9}}, {"name": "sac"}]}
    question = client.post("/api/v1/sweeps", json=other).json()["id"]
    assert client.get(f"/api/v1/sweeps/{question}/verdict").json()["searches"] == []


@pytest.mark.parametrize("seeds", [101, [99, 100], [1_000_000_000], [3, 1_000_009_999]])
def test_a_question_about_seeds_that_chose_settings_is_refused(
    idle_client: TestClient, seeds: int | list[int]
) -> None:
    asked = {
        "algorithms": [{"name": "ddpg"}, {"name": "sac"}],
        "environments": ["Pendulum"],
        "seeds": seeds,
        "question": {"compare": ["ddpg"], "with": "sac"},
    }
    assert "chose settings, so a question does not count it" in faults(idle_client, asked)["seeds"]


def test_a_search_gets_no_other_runs(client: TestClient) -> None:
    sweep = client.post("/api/v1/sweeps", json=searching()).json()["id"]
    for addition in ({"seeds": [7]}, {"algorithms": [{"name": "sac"}]}):
        answer = client.post(f"/api/v1/sweeps/{sweep}/runs", json=addition)
        assert answer.status_code == 409
        assert "searches, which says what runs it gets" in answer.json()["detail"]


def test_a_sweep_without_a_search_has_none(client: TestClient) -> None:
    plain = {key: value for key, value in searching().items() if key != "search"}
    sweep = client.post("/api/v1/sweeps", json=plain).json()["id"]
    answer = client.get(f"/api/v1/sweeps/{sweep}/search")
    assert answer.status_code == 404
    assert "searches nothing" in answer.json()["detail"]

"""Questions and their verdicts over REST: what is refused, what is said, what is answered."""

from typing import Any

import pytest
from starlette.testclient import TestClient

from service.queue.question_rounds import look_at_all
from service.store.store import Store
from tests.service.training import RANDOM, random_return, train
from workers.messages.run_spec import RunSpec

QUESTION: dict[str, Any] = {"compare": ["hybrid-ddpg"], "with": "ddpg", "clip": 0.25}
GAINS = {"Pendulum": 0.2, "MassPoint": -0.2}


def asked(sweep: dict[str, Any] | None = None, **fields: Any) -> dict[str, Any]:
    """A sweep with a question."""
    return {
        "algorithms": [{"name": "ddpg"}, {"name": "hybrid-ddpg"}],
        "environments": list(GAINS),
        "seeds": 8,
        "timesteps": 800,
        **(sweep or {}),
        "question": {**QUESTION, **fields},
    }


def value(spec: RunSpec, _: int) -> float:
    """The hybrid is better in one task and worse in the other."""
    gain = GAINS[spec.environment] if spec.algorithm == "hybrid-ddpg" else 0.0
    best = 0.0
    return RANDOM + (0.5 + gain) * (best - RANDOM)


def faults(client: TestClient, sweep: dict[str, Any]) -> dict[str, str]:
    """What is wrong with it, by field."""
    answer = client.post("/api/v1/sweeps", json=sweep)
    assert answer.status_code == 422, answer.text
    return {each["field"]: each["message"] for each in answer.json()["errors"]}


@pytest.mark.parametrize(
    ("fields", "field", "said"),
    [
        ({"compare": ["hybrid-dpg"]}, "question.compare[0]", "did you mean 'hybrid-ddpg'?"),
        ({"with": "sac"}, "question.with", "'sac' is not known"),
        ({"with": "hybrid-ddpg"}, "question.compare[0]", "would be compared with itself"),
        ({"compare": ["hybrid-ddpg"] * 2}, "question.compare[1]", "same as question.compare[0]"),
        ({"compare": []}, "question.compare", "at least 1"),
        ({"margin": 0.5}, "question.margin", "below question.clip (0.25)"),
        ({"margin": 0.0}, "question.margin", "greater than 0"),
        ({"confidence": 1.0}, "question.confidence", "0.9999"),
        ({"max_seeds": 7}, "question.max_seeds", "below the sweep's own 8 seeds"),
        ({"max_seeds": 9_999}, "question.max_seeds", "39,996 runs; it has at most 20,000"),
        (
            {"max_seeds": 2000, "batch": 4},
            "question.batch",
            "499 looks, of at most 200: give 11",
        ),
        ({"score": "seconds to 2"}, "question.score", '"seconds to X"'),
        ({"score": "best"}, "question.score", '"area", "final"'),
        ({"method": "guess"}, "question.method", "'bounded' or 'normal'"),
        ({"until": "bored"}, "question.until", "'decided'"),
        ({"looks": 3}, "question.looks", ""),
    ],
)
def test_what_cannot_be_asked_is_refused_by_field(
    idle_client: TestClient, fields: dict[str, Any], field: str, said: str
) -> None:
    assert said in faults(idle_client, asked(**fields))[field]


def test_entries_that_meet_in_no_task_cannot_be_compared(idle_client: TestClient) -> None:
    apart = [
        {"name": "ddpg", "environments": ["Pendulum"]},
        {"name": "hybrid-ddpg", "environments": ["MassPoint"]},
    ]
    found = faults(idle_client, asked({"algorithms": apart}))
    assert found == {"question.compare[0]": "'hybrid-ddpg' and 'ddpg' have no task in common"}


def test_seeds_that_would_be_too_large_are_refused(idle_client: TestClient) -> None:
    found = faults(idle_client, asked({"seeds": [2**53 - 9]}))
    assert "question.max_seeds" in found


def test_whoever_asks_is_told_how_far_it_may_go(idle_client: TestClient) -> None:
    three = [{"name": name} for name in ("ddpg", "hybrid-ddpg", "td3")]
    answer = idle_client.post(
        "/api/v1/sweeps?dry_run=true", json=asked({"algorithms": three}, clip=1.0)
    ).json()
    assert answer["runs"]["total"] == 48
    assert answer["notices"] == [
        "The question adds seeds until it is decided: the 48 runs may become 528.",
        "algorithms[2] (td3) is not asked about: it gets no further seeds.",
        "With 128 seeds no difference can be found to be below 0.02: that needs 276 at least, or "
        '67 with "clip": 0.25. Better and worse can be found.',
    ]


@pytest.fixture
def sweep(client: TestClient, store: Store) -> str:
    """The id of a posted question."""
    for task in GAINS:
        store.record_random_return(random_return(task, RANDOM))
    sweep_id: str = client.post("/api/v1/sweeps", json=asked()).json()["id"]
    return sweep_id


def test_the_verdict_forms_and_stands(client: TestClient, store: Store, sweep: str) -> None:
    path = f"/api/v1/sweeps/{sweep}/verdict"
    first = client.get(path).json()
    assert not first["is_settled"]
    for each in first["comparisons"]:
        assert (each["outcome"], each["seeds"], each["low"]) == ("open", 0, None)
        assert each["sentence"] == "not decided: its first runs have not ended"
    train(store, 1, value)
    forming = client.get(path).json()["comparisons"]
    assert [each["outcome"] for each in forming] == ["open", "open"]
    assert forming[0]["forecast"] == {"more": 8, "power": 1.0}
    look_at_all(store)
    assert client.get(f"/api/v1/sweeps/{sweep}").json()["runs"]["queued"] == 32
    train(store, 1, value)
    look_at_all(store)
    verdict = client.get(path).json()
    assert verdict["is_settled"]
    pendulum, mass_point = verdict["comparisons"]
    assert (pendulum["environment"], pendulum["outcome"]) == ("Pendulum", "better")
    assert (mass_point["environment"], mass_point["outcome"]) == ("MassPoint", "worse")
    assert pendulum["seeds"] == pendulum["n"] == 16
    assert pendulum["sequence"]["n"] == [8, 16]
    assert pendulum["mean"] == pytest.approx(0.2)
    assert 0 < pendulum["low"] == pytest.approx(pendulum["sequence"]["low"][-1])
    assert pendulum["low"] == pytest.approx(-mass_point["high"])
    assert pendulum["confidence"] == pytest.approx(1 - 0.05 / 2)
    assert pendulum["sentence"].startswith("better by 0.")
    assert pendulum["sentence"].endswith("; 16 seeds")
    assert "Better than ddpg: hybrid-ddpg in Pendulum (+0.200, 97.5% CI" in verdict["paper"]
    assert client.get(f"/api/v1/sweeps/{sweep}").json()["status"] == "finished"


def test_a_cancelled_question_stays_undecided(client: TestClient, store: Store, sweep: str) -> None:
    train(store, 1, value)
    client.post(f"/api/v1/sweeps/{sweep}/cancel")
    verdict = client.get(f"/api/v1/sweeps/{sweep}/verdict").json()
    assert verdict["is_settled"]
    assert {each["outcome"] for each in verdict["comparisons"]} == {"undecided"}


def test_the_answer_is_kept_until_something_changes(client: TestClient, sweep: str) -> None:
    path = f"/api/v1/sweeps/{sweep}/verdict"
    headers = {"If-None-Match": client.get(path).headers["ETag"]}
    assert client.get(path, headers=headers).status_code == 304


def test_a_sweep_without_a_question_has_no_verdict(client: TestClient) -> None:
    plain = {key: value for key, value in asked().items() if key != "question"}
    sweep_id = client.post("/api/v1/sweeps", json=plain).json()["id"]
    answer = client.get(f"/api/v1/sweeps/{sweep_id}/verdict")
    assert answer.status_code == 404
    assert "asks no question" in answer.json()["detail"]

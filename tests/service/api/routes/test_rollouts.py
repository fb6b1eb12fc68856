"""Rollouts over REST: a trained policy's episode, and when there is none."""

import numpy as np
import pytest
from fastapi import FastAPI
from starlette.testclient import TestClient

import physics
from service.api.schemas.rollout_answer import RolloutAnswer
from service.settings import Settings
from tests.service.conftest import changed
from tests.workers.policies.test_rollout import write_policy

LINK = "/api/v1/rollouts"


@pytest.fixture
def run(client: TestClient, settings: Settings) -> str:
    """A run on Pendulum that has learned something."""
    run = unlearned(client)
    write_policy(settings.checkpoint_place, run, "Pendulum")
    return run


def unlearned(client: TestClient) -> str:
    body = changed(seeds=1, environments=["Pendulum"], algorithms=[{"name": "ddpg"}])
    sweep = client.post("/api/v1/sweeps", json=body).json()["id"]
    (run,) = client.get(f"/api/v1/sweeps/{sweep}/runs").json()["items"]
    return str(run["id"])


def test_an_episode_and_its_film(client: TestClient, run: str) -> None:
    answer = client.get(f"/api/v1/runs/{run}/rollout", params={"seed": 3})
    assert answer.status_code == 200, answer.text
    episode = RolloutAnswer.model_validate_json(answer.content)
    pendulum = physics.make("Pendulum")
    np.testing.assert_array_equal(episode.states[0], pendulum.initial_states([3])[0])
    assert len(episode.frames) == len(episode.states) == len(episode.actions) + 1
    assert len(episode.contacts) == len(episode.rewards) == len(episode.actions)
    assert (episode.dt, episode.surface) == (0.05, None)


def test_a_run_links_to_it_once_there_is_a_policy(client: TestClient, run: str) -> None:
    links = client.get(f"/api/v1/runs/{run}").json()["links"]
    assert client.get(links["rollout"]).status_code == 200
    assert "rollout" not in client.get(f"/api/v1/runs/{unlearned(client)}").json()["links"]


def test_an_episode_from_a_start_of_ones_own(client: TestClient, run: str) -> None:
    answer = client.post(LINK, json={"run": run, "start": [0.5, -1.0]})
    assert answer.status_code == 200
    assert answer.json()["states"][0] == [0.5, -1.0]


@pytest.mark.parametrize(
    ("start", "reason"),
    [([0.5], "has 2 numbers, got 1"), ([], "at least 1"), ([1e9, 0.0], "1000000")],
)
def test_a_bad_start_is_refused(
    client: TestClient, run: str, start: list[float], reason: str
) -> None:
    refusal = client.post(LINK, json={"run": run, "start": start})
    assert refusal.status_code == 422
    assert refusal.json()["errors"][0]["field"].startswith("start")
    assert reason in refusal.json()["detail"]


def test_a_policy_in_a_bucket_is_played(app: FastAPI, client: TestClient, bucket: str) -> None:
    run = unlearned(client)
    write_policy(f"{bucket}/lab", run, "Pendulum")
    app.state.checkpoints = f"{bucket}/lab"
    links = client.get(f"/api/v1/runs/{run}").json()["links"]
    assert client.get(links["rollout"]).status_code == 200


def test_an_unknown_run_is_not_there(client: TestClient) -> None:
    assert client.post(LINK, json={"run": "nobody-1", "start": [0.0]}).status_code == 404

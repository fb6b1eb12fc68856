"""What a run has learned, over REST: when it cannot be had, a sentence says why."""

from pathlib import Path

import pytest
from fastapi import FastAPI
from starlette.testclient import TestClient

from service.api.load.side_process import BusyError
from service.model.environment import environment_facts
from service.settings import Settings
from tests.service.api.routes.test_rollouts import unlearned
from tests.workers.policies.test_rollout import write_policy


@pytest.fixture(params=["rollout", "policy"])
def kind(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def run(client: TestClient, settings: Settings) -> str:
    """A run on Pendulum that has learned something."""
    run = unlearned(client)
    write_policy(settings.checkpoint_place, run, "Pendulum")
    return run


def test_no_policy_yet_is_a_conflict(client: TestClient, kind: str) -> None:
    refusal = client.get(f"/api/v1/runs/{unlearned(client)}/{kind}")
    assert refusal.status_code == 409
    assert "(queued) has no policy" in refusal.json()["detail"]


def test_a_damaged_policy_is_said(
    client: TestClient, run: str, settings: Settings, kind: str
) -> None:
    (file,) = (each for each in Path(settings.checkpoint_place).rglob("policy") if each.is_file())
    file.write_bytes(file.read_bytes()[:-1])
    refusal = client.get(f"/api/v1/runs/{run}/{kind}")
    assert refusal.status_code == 409
    assert "cannot be read" in refusal.json()["detail"]


def test_where_its_place_cannot_be_had_it_says_why(
    app: FastAPI, client: TestClient, run: str, bucket: str, kind: str
) -> None:
    app.state.checkpoints = bucket.replace("d3pg", "no-such-bucket")
    refusal = client.get(f"/api/v1/runs/{run}/{kind}")
    assert refusal.status_code == 503
    assert "make it, or name another with D3PG_CHECKPOINTS" in refusal.json()["detail"]
    shown = client.get(f"/api/v1/runs/{run}")
    assert shown.status_code == 200
    assert kind not in shown.json()["links"]


def test_an_unknown_run_is_not_there(client: TestClient, kind: str) -> None:
    assert client.get(f"/api/v1/runs/nobody-1/{kind}").status_code == 404


def test_a_stranger_gets_nothing(stranger: TestClient, run: str, kind: str) -> None:
    assert stranger.get(f"/api/v1/runs/{run}/{kind}").status_code == 401


def test_when_too_many_wait_it_says_so(
    app: FastAPI, client: TestClient, run: str, monkeypatch: pytest.MonkeyPatch, kind: str
) -> None:
    def busy(*_: object, **__: object) -> None:
        raise BusyError("16 others wait already")

    monkeypatch.setattr(app.state.side, "call", busy)
    refusal = client.get(f"/api/v1/runs/{run}/{kind}")
    assert refusal.status_code == 503
    assert "16 others wait" in refusal.json()["detail"]


@pytest.mark.parametrize(
    ("version", "reason"), [(2, "has version 2"), (None, "unknown environment 'Pendulum'")]
)
def test_a_policy_of_another_task_is_not_shown_as_of_this_one(
    client: TestClient,
    run: str,
    monkeypatch: pytest.MonkeyPatch,
    kind: str,
    version: int | None,
    reason: str,
) -> None:
    def facts(name: str) -> object:
        if version is None:
            raise ValueError(f"unknown environment {name!r}")
        found = environment_facts(name)
        return type(found)(**{**vars(found), "version": version})

    monkeypatch.setattr("service.api.learned.environment_facts", facts)
    refusal = client.get(f"/api/v1/runs/{run}/{kind}")
    assert refusal.status_code == 409
    assert reason in refusal.json()["detail"]

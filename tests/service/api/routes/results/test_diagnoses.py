"""Diagnoses over REST: asked for, made, told, drawn; and what is refused."""

import xml.dom.minidom
from pathlib import Path
from typing import Any

import pytest
from fastapi import FastAPI
from starlette.testclient import TestClient

from service.api.load.side_process import BusyError
from service.api.routes.results import diagnoses
from service.api.schemas.diagnosis_answer import DiagnosisAnswer
from service.settings import Settings
from service.store.store import Store
from tests.service.api.routes.results.test_figures import texts
from tests.service.conftest import changed
from tests.service.found import find
from tests.service.training import rising, train
from tests.workers.policies.test_rollout import write_policy

LEARNERS = [{"name": "ddpg"}, {"name": "hybrid-ddpg"}]


def submitted(client: TestClient, **fields: Any) -> str:
    """The link of a sweep."""
    body = changed(**{"algorithms": LEARNERS, "environments": ["Pendulum"]} | fields)
    answer = client.post("/api/v1/sweeps", json=body)
    assert answer.status_code == 202, answer.text
    return str(answer.json()["links"]["self"])


def runs_of(client: TestClient, sweep: str) -> list[str]:
    return [run["links"]["self"] for run in client.get(f"{sweep}/runs").json()["items"]]


@pytest.fixture
def sweep(client: TestClient, store: Store) -> str:
    """The link of a sweep of two cells with three seeds that have ended."""
    link = submitted(client)
    train(store, 5, rising)
    return link


@pytest.fixture
def run(client: TestClient, sweep: str, settings: Settings) -> str:
    """The link of its first run, which has learned something."""
    link = runs_of(client, sweep)[0]
    write_policy(settings.checkpoint_place, link.rpartition("/")[2], "Pendulum")
    return link


def test_a_run_is_diagnosed_once(app: FastAPI, client: TestClient, store: Store, run: str) -> None:
    nothing = client.get(f"{run}/diagnosis").json()
    assert (nothing["runs"], nothing["waiting"], nothing["done"]) == (1, 0, 0)
    asked = client.post(f"{run}/diagnosis")
    assert asked.status_code == 202, asked.text
    assert asked.json()["waiting"] == 1
    app.state.diagnoser.work()
    made = DiagnosisAnswer.model_validate_json(client.get(f"{run}/diagnosis").content)
    assert (made.waiting, made.done, made.problems) == (0, 1, [])
    [cell] = made.cells
    assert (cell.label, cell.environment, cell.seeds) == ("ddpg", "Pendulum", [0])
    assert len(cell.findings) == 102
    assert [figure.name for figure in made.figures] == ["smoothing", "growth", "critic", "loss"]
    assert client.post(f"{run}/diagnosis").json() == client.get(f"{run}/diagnosis").json()
    assert store.next_waiting_diagnosis() is None


def test_a_sweep_is_told_as_medians_over_the_seeds_of_each_cell(
    client: TestClient, store: Store, sweep: str
) -> None:
    asked = client.post(f"{sweep}/diagnosis", params={"seeds": 2})
    assert (asked.json()["runs"], asked.json()["waiting"]) == (4, 4)
    assert client.get(f"{sweep}/diagnosis").json()["runs"] == 6
    find(store)
    made = client.get(f"{sweep}/diagnosis", params={"seeds": 2}).json()
    assert [(cell["label"], cell["seeds"]) for cell in made["cells"]] == [
        ("ddpg", [0, 1]),
        ("hybrid-ddpg", [0, 1]),
    ]
    [median] = [
        each["value"]
        for each in made["cells"][0]["findings"]
        if (each["quantity"], each["horizon"]) == ("median_norm", 4)
    ]
    assert median == pytest.approx(1.5 * 4)


def test_of_runs_that_have_not_learned_each_reason_is_told_once(
    app: FastAPI, client: TestClient, sweep: str
) -> None:
    client.post(f"{sweep}/diagnosis", params={"seeds": 1})
    app.state.diagnoser.work()
    told = client.get(f"{sweep}/diagnosis", params={"seeds": 1}).json()
    assert (told["done"], told["failed"]) == (0, 2)
    assert all("has no policy" in problem for problem in told["problems"])
    assert client.post(f"{sweep}/diagnosis", params={"seeds": 1}).json()["waiting"] == 2


def test_figures_are_drawn_with_their_definition(
    client: TestClient, store: Store, sweep: str
) -> None:
    client.post(f"{sweep}/diagnosis")
    find(store)
    for link in (sweep, runs_of(client, sweep)[0]):
        links = client.get(f"{link}/diagnosis").json()["links"]
        for name in ("smoothing", "growth", "critic", "loss"):
            svg = client.get(links[name])
            assert svg.status_code == 200, svg.text
            xml.dom.minidom.parseString(svg.content)  # noqa: S318 - our own
    said = texts(client.get(f"{sweep}/diagnosis/growth.svg").content)
    assert "Growth of gradients through time in Pendulum" in said
    assert "small (" in said
    assert "n = 3" in said.replace("\N{NO-BREAK SPACE}", " ")
    assert "hybrid-ddpg" in said
    png = client.get(f"{sweep}/diagnosis/loss.png", params={"environment": "Pendulum"})
    assert png.headers["content-type"] == "image/png"


def test_an_answer_is_kept_until_something_is_found(
    client: TestClient, store: Store, sweep: str
) -> None:
    client.post(f"{sweep}/diagnosis", params={"seeds": 1})
    tag = client.get(f"{sweep}/diagnosis").headers["etag"]
    known = {"If-None-Match": tag}
    assert client.get(f"{sweep}/diagnosis", headers=known).status_code == 304
    find(store)
    assert client.get(f"{sweep}/diagnosis", headers=known).status_code == 200


def test_a_run_without_a_critic_has_no_figures_of_one(client: TestClient, store: Store) -> None:
    sweep = submitted(client, algorithms=[{"name": "gd"}], seeds=1)
    train(store, 5, rising)
    client.post(f"{sweep}/diagnosis")
    find(store)
    told = client.get(f"{sweep}/diagnosis").json()
    assert [figure["name"] for figure in told["figures"]] == ["smoothing", "growth"]
    assert told["remarks"] == ["No critic, so nothing about a critic's gradient: gd."]
    refusal = client.get(f"{sweep}/diagnosis/critic.svg")
    assert refusal.status_code == 404
    assert "have no critic" in refusal.json()["detail"]


def test_of_a_piecewise_constant_reward_it_is_said(client: TestClient, store: Store) -> None:
    sweep = submitted(client, environments=["Acrobot"], seeds=1)
    train(store, 5, rising)
    client.post(f"{sweep}/diagnosis")
    find(store)
    [remark] = client.get(f"{sweep}/diagnosis").json()["remarks"]
    assert remark.startswith("The reward of Acrobot is piecewise constant")


def test_before_it_is_made_there_is_no_figure(client: TestClient, sweep: str) -> None:
    refusal = client.get(f"{sweep}/diagnosis/growth.svg")
    assert refusal.status_code == 404
    assert "There is no diagnosis yet" in refusal.json()["detail"]
    assert client.get(f"{sweep}/diagnosis/kinks.svg").status_code == 422


def test_what_has_not_ended_is_a_conflict(client: TestClient) -> None:
    sweep = submitted(client)
    for link, reason in (
        (sweep, "has reached its end"),
        (runs_of(client, sweep)[0], "is queued: only ended runs can be diagnosed"),
    ):
        refusal = client.post(f"{link}/diagnosis")
        assert refusal.status_code == 409
        assert reason in refusal.json()["detail"]
        assert client.get(f"{link}/diagnosis").json()["runs"] == 0


def test_a_run_without_a_policy_is_a_conflict(client: TestClient, sweep: str) -> None:
    refusal = client.post(f"{runs_of(client, sweep)[1]}/diagnosis")
    assert refusal.status_code == 409
    assert "(succeeded) has no policy" in refusal.json()["detail"]


def test_where_its_place_cannot_be_had_it_says_why(
    app: FastAPI, client: TestClient, run: str, bucket: str
) -> None:
    app.state.checkpoints = bucket.replace("d3pg", "no-such-bucket")
    refusal = client.post(f"{run}/diagnosis")
    assert refusal.status_code == 503
    assert "D3PG_CHECKPOINTS" in refusal.json()["detail"]


@pytest.mark.parametrize("path", ["runs/nobody-1", "sweeps/nobody"])
def test_of_nobody_there_is_none(client: TestClient, path: str) -> None:
    assert client.post(f"/api/v1/{path}/diagnosis").status_code == 404
    assert client.get(f"/api/v1/{path}/diagnosis").status_code == 404
    assert client.get(f"/api/v1/{path}/diagnosis/loss.png").status_code == 404


@pytest.mark.parametrize(
    ("asked", "reason"),
    [
        ({"environment": "Pendulumm"}, "did you mean 'Pendulum'?"),
        ({"seeds": 17}, "less than or equal to 16"),
        ({"sedes": 1}, "did you mean 'seeds'"),
    ],
)
def test_what_cannot_be_asked_is_refused(
    client: TestClient, sweep: str, asked: dict[str, Any], reason: str
) -> None:
    refusal = client.post(f"{sweep}/diagnosis", params=asked)
    assert refusal.status_code == 422
    assert reason in refusal.json()["detail"]


def test_no_more_is_asked_for_than_can_be_made(
    client: TestClient, sweep: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(diagnoses, "MOST_AT_ONCE", 5)
    refusal = client.post(f"{sweep}/diagnosis")
    assert refusal.status_code == 422
    assert "would be 6 diagnoses; at most 5" in refusal.json()["detail"]
    monkeypatch.setattr("service.api.diagnoser.MOST_WAITING", 3)
    full = client.post(f"{sweep}/diagnosis", params={"seeds": 2})
    assert full.status_code == 503
    assert "ask again when some are made" in full.json()["detail"]


def test_when_too_many_wait_for_a_figure_it_says_so(
    app: FastAPI, client: TestClient, store: Store, sweep: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def busy(*_: object, **__: object) -> bytes:
        raise BusyError("16 others wait already")

    client.post(f"{sweep}/diagnosis")
    find(store)
    monkeypatch.setattr(app.state.side, "call", busy)
    refusal = client.get(f"{sweep}/diagnosis/growth.svg")
    assert refusal.status_code == 503
    assert "16 others wait" in refusal.json()["detail"]


def test_a_damaged_policy_is_said(
    app: FastAPI, client: TestClient, run: str, settings: Settings
) -> None:
    (file,) = (each for each in Path(settings.checkpoint_place).rglob("policy") if each.is_file())
    file.write_bytes(file.read_bytes()[:-1])
    client.post(f"{run}/diagnosis")
    app.state.diagnoser.work()
    [problem] = client.get(f"{run}/diagnosis").json()["problems"]
    assert "cannot be read" in problem


def test_placebos_are_entries_that_labels_tell_apart(client: TestClient) -> None:
    """They are compared as any setting is."""
    names = ("shuffled", "untargeted")
    placebos = [{"name": "hybrid-ddpg-robust", "config": {"placebo": name}} for name in names]
    sweep = submitted(client, algorithms=[{"name": "hybrid-ddpg-robust"}, *placebos])
    labels = [entry["label"] for entry in client.get(sweep).json()["entries"]]
    assert len(set(labels)) == 3
    assert all(name in label for name, label in zip(names, labels[1:], strict=True))

"""The walk to a quadrotor in the service: as docs/walk-quadrotor.md says it, but for its length."""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from fastapi import FastAPI
from starlette.testclient import TestClient

from service.model.environment import environment_facts, facts_of_file
from service.settings import Settings
from service.store.store import Store
from service.task_shelf import TaskShelf
from tests.docs.pages import ROOT, blocks
from tests.service.trained import train_queued
from workers.messages.random_return import RandomReturn

PAGE = ROOT / "docs" / "walk-quadrotor.md"


@pytest.fixture
def file(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path_factory.mktemp("walk")
    path = folder / "quadrotor.py"
    path.write_text(blocks(PAGE, "python")[0])
    monkeypatch.chdir(folder)
    monkeypatch.syspath_prepend(folder)
    monkeypatch.delitem(sys.modules, "quadrotor", raising=False)
    return path


@pytest.fixture
def shelf(app: FastAPI, tmp_path: Path, file: Path) -> Iterator[TaskShelf]:
    """That of a service which was started with the file."""
    app.state.shelf = TaskShelf(tmp_path)
    app.state.shelf.serve([file], facts_of_file)
    yield app.state.shelf
    TaskShelf(tmp_path / "empty")  # what a process knows is that of its last shelf


def test_from_the_file_to_the_policy(
    client: TestClient, store: Store, settings: Settings, shelf: TaskShelf, file: Path
) -> None:
    (shown,) = blocks(PAGE, "yaml")
    request = {**yaml.safe_load(shown), "seeds": 2, "timesteps": 800}
    version = environment_facts("Quadrotor").version
    store.record_random_return(RandomReturn("Quadrotor", version, 5.0, 4.0, 6.0, 1000))
    answer = client.post("/api/v1/sweeps", json=request)
    assert answer.status_code == 202, answer.text
    sweep = answer.json()["id"]
    train_queued(store, settings, shelf)
    runs = client.get(f"/api/v1/sweeps/{sweep}/runs").json()["items"]
    assert [run["status"] for run in runs] == ["succeeded"] * 4
    assert client.get(f"/api/v1/sweeps/{sweep}/plot.svg").status_code == 200
    (panel,) = client.get(f"/api/v1/sweeps/{sweep}/curves").json()["panels"]
    assert [curve["label"] for curve in panel["curves"]] == ["ddpg", "hybrid-ddpg"]
    episode = client.get(f"/api/v1/runs/{sweep}-0/rollout")
    assert episode.status_code == 200, episode.text
    Path("quadrotor.npz").write_bytes(client.get(f"/api/v1/runs/{sweep}-0/policy").content)
    names: dict[str, Any] = {}
    exec(compile(blocks(PAGE, "python")[1], PAGE, "exec"), names)  # noqa: S102
    assert 0 < names["reward"] <= 1
    assert names["policy"].header.hidden == [6, 7]

"""docs/add-a-learner.md in a sweep: the page's learner is trained, kept and plotted beside ours."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from starlette.testclient import TestClient

import algorithms
from service.settings import Settings
from service.store.store import Store
from tests.docs.pages import ROOT, blocks
from tests.installed_package import install
from tests.service.trained import train_queued
from tests.service.training import RANDOM, random_return

PAGE = ROOT / "docs" / "add-a-learner.md"


@pytest.fixture(autouse=True)
def package(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Path:
    (code, _), (project,) = blocks(PAGE, "python"), blocks(PAGE, "toml")
    return install(tmp_path_factory.mktemp("site"), "cem", code, project, monkeypatch)


def test_the_pages_sweep(client: TestClient, store: Store, settings: Settings) -> None:
    (shown,) = blocks(PAGE, "yaml")
    request = {**yaml.safe_load(shown), "seeds": 2, "timesteps": 1600}
    for entry in request["algorithms"][1:]:
        entry["config"] = {"population": entry.get("config", {}).get("population", 16) // 8}
        entry["config"] |= {"best": 1}
    store.record_random_return(random_return("Pendulum", RANDOM))
    answer = client.post("/api/v1/sweeps", json=request)
    assert answer.status_code == 202, answer.text
    sweep = answer.json()["id"]
    train_queued(store, settings)
    (panel,) = client.get(f"/api/v1/sweeps/{sweep}/curves").json()["panels"]
    assert [curve["label"] for curve in panel["curves"]] == [
        "ddpg", "cem population=2", "cem population=4",
    ]  # fmt: skip
    assert all(curve["x"] == [800, 1600] for curve in panel["curves"])
    plotted = client.get(f"/api/v1/sweeps/{sweep}/plot.png")
    assert plotted.content.startswith(b"\x89PNG")
    runs = client.get(f"/api/v1/sweeps/{sweep}/runs").json()["items"]
    assert {run["status"] for run in runs} == {"succeeded"}
    own = next(run for run in runs if run["algorithm"] == "cem")
    file = client.get(f"/api/v1/runs/{own['id']}/policy")
    policy = algorithms.load_policy(file.content)
    assert policy.header.hidden_units == [16]
    assert np.abs(policy.act_in([0.1, 0.0])) <= 1
    episode = client.get(f"/api/v1/runs/{own['id']}/rollout").json()
    np.testing.assert_allclose(
        policy.act_in(episode["states"][:-1]), episode["actions"], rtol=0, atol=2e-6
    )

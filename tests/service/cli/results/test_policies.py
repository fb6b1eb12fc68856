"""A policy as a file."""

from pathlib import Path

import numpy as np
import pytest

import algorithms
from service.client import Client, ServiceError
from service.settings import Settings
from tests.service.cli.conftest import Command, as_json
from tests.service.conftest import changed
from tests.workers.policies.test_rollout import write_policy


@pytest.fixture
def run(service: Client) -> str:
    body = changed(seeds=1, environments=["MassPoint"], algorithms=[{"name": "ddpg"}])
    return next(service.runs(service.submit(body).id)).id


def test_it_is_saved_and_described(
    d3pg: Command, service: Client, run: str, settings: Settings, tmp_path: Path
) -> None:
    write_policy(settings.checkpoint_place, run, "MassPoint")
    file = tmp_path / "policy.npz"
    said = d3pg("policy", run, "-o", str(file)).stdout
    assert f"{run} at timestep 100 in MassPoint (version 1): 1 actions of 1 features" in said
    assert f"Wrote {file}" in said
    state = np.array([0.3])
    action = algorithms.load_policy(file).act_in(state)
    np.testing.assert_array_equal(service.policy(run).act_in(state), action, strict=True)
    described = as_json(d3pg("policy", run, "--json"))
    assert (described["file"], described["task"], described["origin"]["run"]) == (
        None, "MassPoint", run,
    )  # fmt: skip
    assert as_json(d3pg("policy", run, "-o", str(file), "--json"))["file"] == str(file)


def test_without_a_policy_it_says_so(d3pg: Command, run: str) -> None:
    refusal = d3pg("policy", run, code=1).exception
    assert isinstance(refusal, ServiceError)
    assert "has no policy" in str(refusal)


def test_another_suffix_is_refused(d3pg: Command) -> None:
    assert "must end in .npz" in d3pg("policy", "a-1", "-o", "policy.pt", code=2).stderr

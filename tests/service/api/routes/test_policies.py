"""The policy of a run over REST: a file that acts as the run does."""

import numpy as np
from starlette.testclient import TestClient

import algorithms
import physics
from service.settings import Settings
from tests.service.api.routes.test_rollouts import unlearned
from tests.workers.policies.test_episode import learnt
from tests.workers.policies.test_rollout import write_policy


def test_the_file_acts_as_the_run_does(client: TestClient, settings: Settings) -> None:
    run = unlearned(client)
    assert "policy" not in client.get(f"/api/v1/runs/{run}").json()["links"]
    write_policy(settings.checkpoint_place, run, "Pendulum")
    answer = client.get(client.get(f"/api/v1/runs/{run}").json()["links"]["policy"])
    assert answer.status_code == 200, answer.text
    assert answer.headers["content-type"] == "application/octet-stream"
    assert answer.headers["content-disposition"] == f'attachment; filename="{run}.npz"'
    policy = algorithms.load_policy(answer.content)
    pendulum = physics.make("Pendulum")
    features = pendulum.features(pendulum.initial_states([4]))
    np.testing.assert_allclose(
        policy.act(features), learnt(pendulum).policies().act(features), rtol=0, atol=2e-6
    )
    assert policy.header.task_version == pendulum.version
    config = client.get(f"/api/v1/runs/{run}").json()["config"]
    assert policy.header.origin == {
        "run": run, "algorithm": "ddpg", "weights": [0.0, 0.0], "config": config, "seed": 0,
        "timestep": 100,
    }  # fmt: skip

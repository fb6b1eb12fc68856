"""Searches and questions on a real Ray, killed again and again: the same rungs and decisions."""

import random
from typing import Any

import pytest

from service.client import Client
from tests.end_to_end.curves import curves_at_the_end, wait_for
from tests.end_to_end.running_service import kill, running_service

pytestmark = [
    pytest.mark.cluster,
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore::service.client.SubmissionNotice"),
]

SEARCH: dict[str, Any] = {
    "name": "which noise?",
    "algorithms": [{"name": "ddpg", "config": {"noise": [0.1, 0.2, 0.4, 0.6, 0.8]}}],
    "environments": ["Pendulum", "MassPoint"],
    "seeds": 4,
    "timesteps": 4800,
    "search": {"budget": 125_000, "reduction": 2},
}
QUESTION: dict[str, Any] = {
    "name": "does noise help?",
    "algorithms": [
        {"name": "ddpg", "label": "loud", "config": {"noise": 0.8}},
        {"name": "ddpg", "label": "still", "config": {"noise": 0.1}},
    ],
    "environments": ["Pendulum"],
    "seeds": 4,
    "timesteps": 1600,
    "question": {
        "compare": ["loud"], "with": "still", "clip": 0.25, "batch": 4, "max_seeds": 16,
    },
}  # fmt: skip
KILLS = 6


def found(client: Client, sweep_id: str) -> dict[str, Any]:
    """What a sweep has come to, but for its name; and the timesteps of each of its runs."""
    sweep = client.sweep(sweep_id)
    answer = client.search(sweep_id) if sweep.request.get("search") else client.verdict(sweep_id)
    runs = {(run.label, run.environment, run.seed): run.timesteps for run in client.runs(sweep_id)}
    return {**answer.model_dump(exclude={"sweep", "searches", "kept_apart"}), "runs": runs}


@pytest.mark.parametrize("request_", [SEARCH, QUESTION], ids=["search", "question"])
def test_killed_at_any_moment_it_finds_the_same(
    tmp_path_factory: pytest.TempPathFactory, request_: dict[str, Any]
) -> None:
    draw = random.Random(0)  # noqa: S311
    with running_service(tmp_path_factory.mktemp("data")) as (service, _):
        quiet = service.client.submit(request_).id
        undisturbed = curves_at_the_end(service.client, quiet)
        expected = found(service.client, quiet)
        assert expected["is_settled"]
        killed = service.client.submit(request_).id
        for moment in sorted(draw.random() for _ in range(KILLS)):
            wait_for(lambda: has_come(service.client, killed, moment))  # noqa: B023
            if draw.random() < 0.5:
                service.kill()
                service.start()
            elif pids := service.worker_pids():
                kill([draw.choice(pids)])
        assert curves_at_the_end(service.client, killed) == undisturbed
        assert found(service.client, killed) == expected


def has_come(client: Client, sweep_id: str, share: float) -> bool:
    """Whether a sweep is so far, or at its end: that of a question is not known before."""
    sweep = client.sweep(sweep_id)
    return sweep.progress >= share or sweep.status == "finished"

"""The main job as a user does it: real processes, real training, real deaths."""

import os
import re
import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

import algorithms
from service.api.schemas.run_answer import RunAnswer
from service.client import Client
from tests.end_to_end.running_service import RunningService, running_service, wait_for_end
from tests.workers.processes import processor_seconds

pytestmark = pytest.mark.cluster

Json = dict[str, Any]
Curve = list[tuple[float | None, ...]]

ALGORITHMS = [
    {"name": "ddpg"},
    {"name": "hybrid-ddpg", "weights": {"w1": 0.1, "w2": 0.1}},
]
TIMESTEPS = 6_400
STOP_SECONDS = 5.0
SEEDS = [0, 1]
REQUEST = {
    "name": "two learners, <b>one</b> pendulum",
    "algorithms": ALGORITHMS,
    "environments": ["Pendulum"],
    "seeds": SEEDS,
    "timesteps": TIMESTEPS,
}
YAML = """
name: typed by hand
algorithms: [{name: ddpg}]
environments: [MassPoint]
seeds: 2
timesteps: 1600
"""


@pytest.fixture(scope="module")
def running(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[RunningService, Client]]:
    with running_service(tmp_path_factory.mktemp("data")) as running:
        yield running


@pytest.fixture(scope="module")
def undisturbed() -> dict[tuple[str, int], Curve]:
    """What each run must give: the same specs, trained alone in this process."""
    return {
        (name, seed): [
            (m.timestep, m.return_mean, m.return_history)
            for m in algorithms.train(name, "Pendulum", [seed], weights, TIMESTEPS)
        ]
        for name, weights in (("ddpg", (0.0, 0.0)), ("hybrid-ddpg", (0.1, 0.1)))
        for seed in SEEDS
    }


def curve(client: Client, run_id: str) -> Curve:
    columns = client.measurements(run_id).columns
    return list(
        zip(columns["timestep"], columns["return_mean"], columns["return_history"], strict=True)
    )


def last_timestep(client: Client, run_id: str) -> float:
    return max((timestep or 0 for timestep, *_ in curve(client, run_id)), default=0)


def curves(client: Client, sweep_id: str) -> dict[tuple[str, int], Curve]:
    return {(run.algorithm, run.seed): curve(client, run.id) for run in client.runs(sweep_id)}


def wait_until(is_so: Callable[[], bool]) -> None:
    deadline = time.monotonic() + 120
    while not is_so():
        assert time.monotonic() < deadline
        time.sleep(0.05)


def wait_for_a_measurement(client: Client, sweep_id: str) -> None:
    wait_until(lambda: any(run.timestep >= 800 for run in client.runs(sweep_id)))


def test_killed_worker_costs_time_and_nothing_else(
    running: tuple[RunningService, Client], undisturbed: dict[tuple[str, int], Curve]
) -> None:
    service, client = running
    sweep_id = client.submit(REQUEST).id
    wait_for_a_measurement(client, sweep_id)
    for pid in service.worker_pids():
        os.kill(pid, signal.SIGKILL)
    ended = client.wait(sweep_id, timeout_seconds=240)
    assert ended.runs.succeeded == ended.runs.total == 4
    assert max(run.attempt for run in client.runs(sweep_id)) >= 2
    assert curves(client, sweep_id) == undisturbed


def test_killed_worker_s_run_goes_on_from_its_checkpoint(
    running: tuple[RunningService, Client],
) -> None:
    """Beside it trains its twin, undisturbed: the same bits, also beyond where it was killed."""
    service, client = running
    one = REQUEST | {"algorithms": ALGORITHMS[1:], "seeds": [0], "timesteps": 2_000_000}
    twins = [client.submit(one).id for _ in range(2)]

    def runs() -> list[RunAnswer]:
        return [client.run(f"{sweep_id}-0") for sweep_id in twins]

    wait_until(lambda: all(run.checkpoint_timestep > 0 for run in runs()))
    os.kill(service.worker_pids()[0], signal.SIGKILL)
    wait_until(lambda: any(run.attempt > 1 for run in runs()))
    at_kill = max(last_timestep(client, run.id) for run in runs() if run.attempt > 1)
    wait_until(lambda: all(last_timestep(client, run.id) > at_kill for run in runs()))
    for sweep_id in twins:
        client.move(sweep_id, "cancel")
    for sweep_id in twins:
        client.wait(sweep_id, timeout_seconds=30)
    twin, killed = sorted(runs(), key=lambda run: run.attempt)
    assert (twin.attempt, killed.attempt) == (1, 2)
    assert killed.resumed_timestep is not None
    # Not at the start; a checkpoint may be further than the last measurement that was told.
    assert 0 < killed.resumed_timestep <= killed.timestep
    both = [curve(client, run.id) for run in (twin, killed)]
    undisturbed, resumed = (points[: min(map(len, both))] for points in both)
    assert resumed == undisturbed
    assert (resumed[-1][0] or 0) > at_kill


def test_killed_server_goes_on_where_it_was(
    tmp_path: Path, undisturbed: dict[tuple[str, int], Curve]
) -> None:
    with running_service(tmp_path) as (service, client):
        sweep_id = client.submit(REQUEST).id
        wait_for_a_measurement(client, sweep_id)
        service.kill()
        again = service.start()
        ended = again.wait(sweep_id, timeout_seconds=240)
        assert ended.runs.succeeded == 4
        assert all(run.attempt == 1 for run in again.runs(sweep_id))  # its workers went on
        assert curves(again, sweep_id) == undisturbed
        with service.open_streams(50):
            assert service.stop(signal.SIGTERM) < STOP_SECONDS


def test_commands(running: tuple[RunningService, Client], tmp_path: Path) -> None:
    service, _ = running
    dry = service.command("submit", "-", "--dry-run", stdin=YAML)
    assert dry.returncode == 0, dry.stderr
    assert "2 runs, 3,200 timesteps; nothing was queued." in dry.stdout

    submitted = service.command("submit", "-", "--watch", stdin=YAML)
    assert submitted.returncode == 0, submitted.stderr
    assert "2 succeeded" in submitted.stdout
    sweep_id = submitted.stdout.split()[1].rstrip(":")

    figure = tmp_path / "figure.png"
    plotted = service.command("plot", sweep_id, "-o", str(figure))
    assert plotted.returncode == 0, plotted.stderr
    assert figure.read_bytes().startswith(b"\x89PNG")

    refused = service.command("submit", "-", stdin=YAML.replace("MassPoint", "MasPoint"))
    assert refused.returncode == 1
    assert "MassPoint" in refused.stderr
    assert "Traceback" not in refused.stderr

    unknown = service.command("watch", "0" * 12)
    assert unknown.returncode == 1
    assert "0" * 12 in unknown.stderr


def test_the_log_of_a_worker_is_told_while_it_trains(
    running: tuple[RunningService, Client],
) -> None:
    service, client = running
    sweep_id = client.submit(REQUEST | {"algorithms": ALGORITHMS[:1], "timesteps": 2_000_000}).id
    told: list[str] = []
    for attempt in client.follow_log(f"{sweep_id}-0", poll_seconds=0.05):
        told.append(attempt.log_tail)
        if (
            "training, after" in attempt.log_tail
            and client.run(f"{sweep_id}-0").status == "running"
        ):
            client.move(sweep_id, "cancel")
    first, second, *_ = told[-1].splitlines()
    assert re.search(r"d3pg: ddpg w1=0 w2=0 .*in Pendulum, seed.* 0.*, 2000000 timesteps$", first)
    assert re.search(r"d3pg: training, after [\d.]+ s of preparation$", second)
    client.wait(sweep_id, timeout_seconds=15)
    shown = service.command("logs", f"{sweep_id}-0")
    assert shown.stdout.strip() == told[-1].strip()


def test_cancel_of_what_is_training(running: tuple[RunningService, Client]) -> None:
    service, client = running
    sweep_id = client.submit(REQUEST | {"timesteps": 2_000_000}).id
    wait_for_a_measurement(client, sweep_id)
    cancelled = service.command("cancel", sweep_id)
    assert cancelled.returncode == 0, cancelled.stderr
    ended = client.wait(sweep_id, timeout_seconds=15)
    assert ended.runs.cancelled == 4
    assert all(curve(client, run.id) for run in client.runs(sweep_id))


def test_cancel_of_a_worker_that_does_not_listen(running: tuple[RunningService, Client]) -> None:
    """It is in a kernel for minutes, where it hears no word and handles no signal."""
    service, client = running
    slow = {"hidden_units": 512, "batch_size": 1024, "rollout_steps": 800, "cycle_updates": 800}
    deaf = REQUEST | {"algorithms": [{"name": "ddpg", "config": slow}], "seeds": 1}
    used = {pid: processor_seconds(pid) for pid in service.worker_pids()}

    def in_its_kernel() -> list[int]:
        return [pid for pid in used if processor_seconds(pid) > used[pid] + 2.0]

    run_id = f"{client.submit(deaf | {'timesteps': 100_000}).id}-0"
    wait_until(lambda: bool(in_its_kernel()))
    worker = in_its_kernel()
    client.move(run_id, "cancel")
    asked = time.monotonic()
    wait_until(lambda: client.run(run_id).status == "cancelled")
    assert time.monotonic() - asked < 15.0
    wait_for_end(worker)

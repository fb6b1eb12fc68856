"""Faults on a real Ray: what is killed or frozen costs time, and no curve shows it.

One service goes through all of it. Every sweep is compared with its twin that was left undisturbed.
"""

import os
import random
import signal
import time
from collections.abc import Iterator, Sequence
from typing import Any

import pysqlite3.dbapi2
import pytest

from tests.end_to_end.curves import Curves, curves_at_the_end, report, submitted, wait_for
from tests.end_to_end.running_service import RunningService, kill, running_service, wait_for_end
from tests.workers.processes import command_line

pytestmark = [pytest.mark.cluster, pytest.mark.slow]

SWEEP: dict[str, Any] = {
    "name": "in harm's way",
    "algorithms": [
        {"name": "ddpg"},
        {"name": "hybrid-ddpg", "weights": [{"w1": w, "w2": 0.1} for w in (0.0, 0.1, 1.0)]},
    ],
    "environments": ["Pendulum"],
    "seeds": 16,
    "timesteps": 8_000,
}
SMALL = SWEEP | {"algorithms": [{"name": "ddpg"}], "seeds": 4, "timesteps": 40_000}
KILLS = 50
LEASE_SECONDS = 15.0


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningService]:
    with running_service(tmp_path_factory.mktemp("data")) as (service, _):
        yield service


@pytest.fixture(scope="module")
def undisturbed(service: RunningService) -> Curves:
    """Those of the small sweep."""
    return curves_at_the_end(service.client, service.client.submit(SMALL).id)


def test_fifty_kills_of_server_and_workers(service: RunningService) -> None:
    begun = time.monotonic()
    undisturbed = curves_at_the_end(service.client, service.client.submit(SWEEP).id)
    report("64 runs, undisturbed", time.monotonic() - begun, "s")
    draw = random.Random(0)  # noqa: S311
    sweep_id = service.client.submit(SWEEP).id
    begun = time.monotonic()
    victims: list[str] = []
    for moment in sorted(draw.random() for _ in range(KILLS)):
        wait_for(lambda: service.client.sweep(sweep_id).progress >= moment)  # noqa: B023
        victims.append(draw.choice(["server", "worker"]))
        if victims[-1] == "server":
            service.kill()
            service.start()
        else:
            wait_for(lambda: bool(service.worker_pids()))
            kill([draw.choice(service.worker_pids())])
    assert curves_at_the_end(service.client, sweep_id) == undisturbed
    report("killed: servers", victims.count("server"), "")
    report("killed: workers", victims.count("worker"), "")
    report("64 runs, with 50 kills", time.monotonic() - begun, "s")
    attempts = [run.attempt for run in service.client.runs(sweep_id)]
    report("attempts a run, most", max(attempts), "")


@pytest.mark.parametrize("with_workers", [False, True])
def test_a_killed_server(
    service: RunningService, undisturbed: Curves, *, with_workers: bool
) -> None:
    sweep_id = submitted(service.client, SMALL)
    begun = time.monotonic()
    service.kill()
    if with_workers:
        family = service.family()
        kill(family)
        wait_for_end(family)
    killed_at = time.time()
    service.start()
    report("killed server: serves again after", service.serving_after, "s")
    report("of it, work of a processor", service.work_until_serving, "s")
    assert service.work_until_serving <= 3.0  # a machine that is busy with other things is slower
    wait_for(lambda: not unheard(service, killed_at), 60.0)
    report("killed server: every run is truthful after", time.monotonic() - begun, "s")
    assert time.monotonic() - begun <= 30.0
    assert curves_at_the_end(service.client, sweep_id) == undisturbed
    attempts = {run.attempt for run in service.client.runs(sweep_id)}
    assert attempts == ({2} if with_workers else {1})


def test_a_killed_raylet(service: RunningService, undisturbed: Curves) -> None:
    sweep_id = submitted(service.client, SMALL)
    kill(raylets(service))
    assert curves_at_the_end(service.client, sweep_id) == undisturbed
    assert {run.attempt for run in service.client.runs(sweep_id)} == {2}


def test_a_frozen_raylet(service: RunningService, undisturbed: Curves) -> None:
    sweep_id = submitted(service.client, SMALL)
    frozen = raylets(service)
    send(signal.SIGSTOP, frozen)
    begun = time.monotonic()
    assert curves_at_the_end(service.client, sweep_id) == undisturbed
    report("frozen raylet: sweep done after", time.monotonic() - begun, "s")
    again = submitted(service.client, SMALL)
    report("frozen raylet: another sweep trains after", time.monotonic() - begun, "s")
    assert curves_at_the_end(service.client, again) == undisturbed
    wait_for_end(frozen)


def test_frozen_workers_are_ended_and_others_have_their_runs(
    service: RunningService, undisturbed: Curves
) -> None:
    sweep_id = submitted(service.client, SMALL)
    frozen = service.worker_pids()
    send(signal.SIGSTOP, frozen)
    begun = time.monotonic()
    wait_for(lambda: all(run.attempt == 2 for run in service.client.runs(sweep_id)), 90.0)
    report("frozen workers: others have their runs after", time.monotonic() - begun, "s")
    wait_for_end(frozen)
    assert curves_at_the_end(service.client, sweep_id) == undisturbed
    assert {run.attempt for run in service.client.runs(sweep_id)} == {2}


def unheard(service: RunningService, since: float) -> int:
    """How many runs are said to be running of which no word has come since then."""
    query = "SELECT count(*) FROM runs WHERE status = 'running' AND lease_until < ?"
    connection = pysqlite3.dbapi2.connect(service.data_dir / "d3pg.sqlite")
    try:
        return int(connection.execute(query, (since + LEASE_SECONDS,)).fetchone()[0])
    finally:
        connection.close()


def raylets(service: RunningService) -> list[int]:
    found = [pid for pid in service.family() if "/raylet" in command_line(pid)[0]]
    assert found
    return found


def send(number: signal.Signals, pids: Sequence[int]) -> None:
    for pid in pids:
        try:
            os.kill(pid, number)
        except ProcessLookupError:
            continue

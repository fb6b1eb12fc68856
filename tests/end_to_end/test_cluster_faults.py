"""What can befall a cluster: its nodes, its head, its network and its service, one after the other.

Each node is on a machine of its own (see `machine.py`), as in `docker/compose.yml`, and what has
ended is started again, as Docker does it. Every sweep is compared with its twin that a service with
a local Ray has trained. Needs root, for the networks.
"""

import os
import random
import secrets
import signal
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import psycopg
import pytest

from service.client import Client
from tests.end_to_end.curves import (
    Curve,
    Curves,
    curves_at_the_end,
    report,
    wait_for,
    without_times,
)
from tests.end_to_end.machine import Machine, can_separate, separate_machines
from tests.end_to_end.ray_node import Node, cluster_environment, head, worker
from tests.end_to_end.running_service import RunningService, is_worker, running_service
from tests.service.store.postgresql import PostgreSQL, running_postgresql

pytestmark = [
    pytest.mark.cluster,
    pytest.mark.slow,
    pytest.mark.skipif(not can_separate(), reason="root may make networks, others may not"),
]

DOCKER = Path(__file__).resolve().parents[2] / "docker"
SWEEP: dict[str, Any] = {  # four cohorts of two runs for two cores, so that some wait
    "name": "in harm's way",
    "algorithms": [
        {"name": "ddpg"},
        {"name": "hybrid-ddpg", "weights": [{"w1": w, "w2": 0.1} for w in (0.0, 0.1, 1.0)]},
    ],
    "environments": ["Pendulum"],
    "seeds": 2,
    "timesteps": 16_000,
}
NAMES = ["h", "one", "two", "d", "s"]
LEASE_SECONDS = 15.0
TRUTHFUL_SECONDS = 30.0
KILLS, KILLS_A_SWEEP = 200, 20
VICTIMS = {"worker": 8, "node": 5, "driver": 3, "service": 3, "head": 1}
"""By how often, of twenty."""


@dataclass(frozen=True)
class Cluster:
    """A head without cores, two nodes with one each, the driver of Ray, and the service."""

    head: Node
    nodes: Sequence[Node]
    driver: "Driver"
    machine: Machine
    """The service's."""
    service: RunningService
    database: PostgreSQL

    @property
    def of_ray(self) -> "list[Node | Driver]":
        """What is Ray's."""
        return [self.head, *self.nodes, self.driver]

    def keep_up(self) -> bool:
        """Start what has ended, as Docker does; whether all is up."""
        is_up = [each.keep_up() for each in self.of_ray]
        return all(is_up)

    def kill_service(self) -> None:
        """End its container by force."""
        self.service.kill()
        self.machine.kill()

    def unheard(self, since: float) -> int:
        """How many runs are said to be running of which no word has come since then."""
        query = "SELECT count(*) FROM runs WHERE status = 'running' AND lease_until < %s"
        with psycopg.connect(self.database.conninfo("d3pg")) as connection:
            found = connection.execute(query, [since + LEASE_SECONDS]).fetchone()
        return int(found[0]) if found else 0


class Driver:
    """The process that drives Ray, on a machine of its own: a node without cores."""

    def __init__(self, machine: Machine, address: str, environment: dict[str, str]) -> None:
        """Start nothing yet."""
        self.machine = machine
        self.folder = machine.folder / "shared"
        self._words = (str(DOCKER / "drive-ray"), address, str(self.folder))
        self._environment = {
            **environment,
            "D3PG_DATA_DIR": str(machine.folder),
            "PATH": os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]]),
            "RAY_TMPDIR": str(machine.folder),
        }
        self.folder.mkdir()

    def keep_up(self) -> bool:
        """Start it again where it has ended; whether it listens."""
        if not self.machine.is_on:
            self.machine.start(self._words, self._environment)
        return (self.folder / "pool.sock").exists()


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Curves:
    """Those of a service with a local Ray and SQLite."""
    with running_service(tmp_path_factory.mktemp("alone")) as (_, client):
        return curves_at_the_end(client, client.submit(SWEEP).id)


@pytest.fixture(scope="module")
def cluster(
    undisturbed: Curves,  # first, for the cores
    tmp_path_factory: pytest.TempPathFactory,
) -> Iterator[Cluster]:
    folder = tmp_path_factory.mktemp("cluster")
    (data_dir := folder / "data").mkdir()
    token = folder / "ray_token"
    for name in ("token", "ray_token"):
        (folder / name).write_text(secrets.token_hex(32))
        (folder / name).chmod(0o600)
    with running_postgresql() as database, separate_machines(NAMES) as machines:
        address = f"{machines[0].address}:6379"
        environment = cluster_environment(address, token)
        first = head(machines[0], 6379, environment)
        nodes = [worker(machine, address, environment) for machine in machines[1:3]]
        driver = Driver(machines[3], address, environment)
        of_ray: list[Node | Driver] = [first, *nodes, driver]
        for each in of_ray:
            wait_for(each.keep_up)
        service = RunningService(
            data_dir,
            environment={
                **service_environment(machines[4]),
                "D3PG_DRIVER": str(driver.folder / "pool.sock"),
                "D3PG_RAY_ADDRESS": address,
                "D3PG_DATABASE_URL": database.create("d3pg"),
            },
            command=machines[4].command([str(DOCKER / "serve-d3pg"), str(folder)]),
            address=machines[4].address,
        )
        cluster = Cluster(first, nodes, driver, machines[4], service, database)
        try:
            service.start()
            yield cluster
        finally:
            cluster.kill_service()
            service.client.close()


def service_environment(machine: Machine) -> dict[str, str]:
    return {
        **machine.mark,
        "D3PG_HOST": "0.0.0.0",  # noqa: S104
        "D3PG_ALLOW_HOST": machine.address,
        "HOME": str(machine.folder),
        "PATH": os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]]),
    }


def survived(cluster: Cluster, undisturbed: Curves, name: str, fault: Callable[[], None]) -> None:
    """Let something befall the cluster while it trains on both nodes, and see that it is survived.

    That is: every run is truthful soon, what was shown before is still there, and no
    curve shows it.
    """
    client = cluster.service.client
    wait_for(cluster.keep_up)
    sweep_id = client.submit(SWEEP).id

    def is_under_way() -> bool:
        trained = all(run.timestep >= 800 for run in client.runs(sweep_id, status="running"))
        return trained and all(node.trains for node in cluster.nodes)

    wait_for(is_under_way)
    shown = {run.id: shown_of(client, run.id) for run in client.runs(sweep_id)}
    reached = {run.id: run.timestep for run in client.runs(sweep_id, status="running")}
    begun, begun_at = time.monotonic(), time.time()
    moved_at = dict.fromkeys(reached, begun)
    stood_still = [0.0]

    def tell(event: str) -> None:
        report(f"{name}: {event} after", time.monotonic() - begun, "s")

    def is_serving() -> bool:
        cluster.keep_up()
        return cluster.service.is_serving

    fault()
    wait_for(lambda: not cluster.unheard(begun_at))
    truthful = time.monotonic() - begun
    tell("every run is truthful")
    wait_for(is_serving)
    for run_id, columns in shown.items():
        still_shown = shown_of(client, run_id)
        assert {key: still_shown[key][: len(columns[key])] for key in columns} == columns

    def has_ended() -> bool:
        cluster.keep_up()
        for run in client.runs(sweep_id):
            if run.timestep > reached.get(run.id, run.timesteps):
                now = time.monotonic()
                stood_still.append(now - moved_at[run.id])
                reached[run.id], moved_at[run.id] = run.timestep, now
        return client.sweep(sweep_id).status == "finished"

    wait_for(has_ended)
    report(f"{name}: a run in training stood still for at most", max(stood_still), "s")
    tell("all runs have ended")
    assert curves_at_the_end(client, sweep_id) == undisturbed
    attempts = [run.attempt for run in client.runs(sweep_id)]
    report(f"{name}: attempts of runs", sum(attempts) / len(attempts), "")
    assert truthful <= TRUTHFUL_SECONDS


def shown_of(client: Client, run_id: str) -> Curve:
    """What the service shows of a run now, but for the time it took."""
    return without_times(client.measurements(run_id).columns)


def test_a_node_is_killed(cluster: Cluster, undisturbed: Curves) -> None:
    survived(cluster, undisturbed, "killed node", cluster.nodes[0].machine.kill)


def test_a_node_freezes(cluster: Cluster, undisturbed: Curves) -> None:
    frozen = cluster.nodes[0].machine
    survived(cluster, undisturbed, "frozen node", frozen.freeze)
    frozen.thaw()
    wait_for(lambda: not frozen.is_on)  # Ray ends a node that was counted as dead


def test_a_node_is_cut_off(cluster: Cluster, undisturbed: Curves) -> None:
    lost = cluster.nodes[0].machine
    survived(cluster, undisturbed, "node cut off", lost.unplug)
    lost.plug_in()
    wait_for(lambda: not lost.is_on)  # as above


def test_the_service_is_killed(cluster: Cluster, undisturbed: Curves) -> None:
    def fault() -> None:
        cluster.kill_service()
        cluster.service.launch()

    survived(cluster, undisturbed, "killed service", fault)


def test_the_driver_is_killed(cluster: Cluster, undisturbed: Curves) -> None:
    survived(cluster, undisturbed, "killed driver", cluster.driver.machine.kill)


def test_service_and_driver_are_killed(cluster: Cluster, undisturbed: Curves) -> None:
    def fault() -> None:
        cluster.kill_service()
        cluster.driver.machine.kill()
        cluster.keep_up()
        cluster.service.launch()

    survived(cluster, undisturbed, "killed service and driver", fault)


def test_the_head_is_killed(cluster: Cluster, undisturbed: Curves) -> None:
    survived(cluster, undisturbed, "killed head", cluster.head.machine.kill)


def test_the_service_is_killed_while_the_head_is_away(
    cluster: Cluster, undisturbed: Curves
) -> None:
    def fault() -> None:
        cluster.head.machine.kill()
        cluster.kill_service()
        cluster.service.launch()

    survived(cluster, undisturbed, "killed head and service", fault)


def test_the_power_is_out(cluster: Cluster, undisturbed: Curves) -> None:
    def fault() -> None:
        for each in cluster.of_ray:
            each.machine.kill()
        cluster.kill_service()
        cluster.keep_up()
        cluster.service.launch()

    survived(cluster, undisturbed, "no power", fault)


@pytest.mark.timeout(3600)
def test_two_hundred_random_kills(cluster: Cluster, undisturbed: Curves) -> None:
    """Anything at any moment, also while what was killed before comes back."""
    draw = random.Random(0)  # noqa: S311
    client = cluster.service.client
    killed: Counter[str] = Counter()
    begun = time.monotonic()

    def has_come_to(sweep_id: str, moment: float) -> bool:
        cluster.keep_up()
        return cluster.service.is_serving and client.sweep(sweep_id).progress >= moment

    wait_for(cluster.keep_up)
    while killed.total() < KILLS:
        sweep_id = client.submit(SWEEP).id
        for moment in sorted(draw.uniform(0.0, 0.95) for _ in range(KILLS_A_SWEEP)):
            wait_for(partial(has_come_to, sweep_id, moment))
            time.sleep(draw.uniform(0.0, 2.0))
            victim = draw.choices(list(VICTIMS), list(VICTIMS.values()))[0]
            killed[victim] += kill(cluster, victim, draw)
        wait_for(partial(has_come_to, sweep_id, 1.0))
        assert curves_at_the_end(client, sweep_id) == undisturbed
        report("random kills: so far", killed.total(), "")
    report("random kills: all", time.monotonic() - begun, "s")
    for victim, times in killed.items():
        report(f"random kills: {victim}", times, "")


def kill(cluster: Cluster, victim: str, draw: random.Random) -> int:
    """End something by force, and start a service again at once; how many were ended."""
    if victim == "service":
        cluster.kill_service()
        cluster.service.launch()
        return 1
    if victim == "worker":
        return kill_worker(cluster, draw)
    machines = {"driver": cluster.driver.machine, "head": cluster.head.machine}
    machine = machines.get(victim) or draw.choice(cluster.nodes).machine
    machine.kill()
    return 1


def kill_worker(cluster: Cluster, draw: random.Random) -> int:
    """End one of the workers by force, if there is one."""
    running = [pid for node in cluster.nodes for pid in node.machine.processes]
    workers = [pid for pid in running if is_worker(pid)]
    if not workers:
        return 0
    with suppress(ProcessLookupError):
        os.kill(draw.choice(workers), signal.SIGKILL)
        return 1
    return 0

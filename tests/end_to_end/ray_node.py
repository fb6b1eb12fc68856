"""Nodes of a Ray cluster, each on a machine of its own, as `docker/compose.yml` starts them."""

import sys
from collections.abc import Mapping
from pathlib import Path

from tests.end_to_end.machine import Machine
from tests.end_to_end.running_service import is_training, is_worker
from workers.pool.environment import pool_environment

HEALTH_CHECKS = {  # a node that does not answer counts as dead after about 8 s
    "RAY_health_check_initial_delay_ms": "2000",
    "RAY_health_check_period_ms": "500",
    "RAY_health_check_timeout_ms": "1000",
    "RAY_health_check_failure_threshold": "5",
}
RAY = str(Path(sys.executable).with_name("ray"))
NODE = (
    "--object-store-memory=83886080",
    "--block",
    "--disable-usage-stats",
    "--include-log-monitor=false",
    "--dashboard-agent-listen-port=0",  # which would be the same for all, also on loopback
)


def cluster_environment(address: str, token_file: Path) -> dict[str, str]:
    """What every process of a cluster has in its environment, the service's too."""
    environment = pool_environment(address, token_file.parent) | HEALTH_CHECKS
    environment.pop("RAY_AUTH_TOKEN", None)
    return environment | {"RAY_AUTH_TOKEN_PATH": str(token_file)}


class Node:
    """A head or a worker, which joins a head."""

    def __init__(
        self, machine: Machine, options: tuple[str, ...], environment: Mapping[str, str]
    ) -> None:
        """Start nothing yet."""
        self.machine = machine
        self._environment = environment
        self._words = (
            RAY,
            "start",
            f"--node-ip-address={machine.address}",
            f"--temp-dir={machine.folder}",
            *options,
            *NODE,
        )

    def start(self) -> None:
        """Start it, again where it has ended."""
        self.machine.start(self._words, self._environment)

    def keep_up(self) -> bool:
        """Start it again where it has ended, as Docker does; whether it is up."""
        if not self.machine.is_on:
            self.start()
        return self.is_up

    @property
    def is_up(self) -> bool:
        """Whether it has joined, as it says itself, since it was last started."""
        return self.machine.is_on and "Ray runtime started" in self.machine.terminal()

    @property
    def has_worker(self) -> bool:
        """Whether there is a worker on it, at work or idle."""
        return any(is_worker(pid) for pid in self.machine.processes)

    @property
    def trains(self) -> bool:
        """Whether a worker on it trains."""
        return any(is_training(pid) for pid in self.machine.processes)


def head(machine: Machine, port: int, environment: Mapping[str, str]) -> Node:
    """Return the head, which trains nothing."""
    options = ("--head", f"--port={port}", "--num-cpus=0", "--include-dashboard=false")
    return Node(machine, options, environment)


def worker(machine: Machine, address: str, environment: Mapping[str, str]) -> Node:
    """Return a node with one core that joins the head at that address."""
    return Node(machine, (f"--address={address}", "--num-cpus=1"), environment)

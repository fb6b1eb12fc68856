"""Run inside a worker's container, with Ray's token: what a task on each node can find and reach.

Arguments: secrets, reversed, so that looking for them does not bring them there; then addresses.
"""

import contextlib
import json
import os
import socket
import sys
from pathlib import Path
from typing import Any

import ray
from ray.util.scheduling_strategies import NodeAffinitySchedulingStrategy

LOOKED_THROUGH = ("/data", "/etc", "/home", "/root", "/run", "/tmp", "/var/lib")  # noqa: S108
LARGEST = 2**22


def found_on_a_node(reversed_secrets: dict[str, str], addresses: list[str]) -> dict[str, Any]:
    """Return the files that hold a secret, what is in /data, and which addresses answer."""
    wanted = {name: text[::-1].encode() for name, text in reversed_secrets.items()}
    files = [*Path("/proc").glob("[0-9]*/environ"), *Path("/proc").glob("[0-9]*/cmdline")]
    for folder in LOOKED_THROUGH:
        files += (path for path in Path(folder).rglob("*") if path.is_file())
    holding: dict[str, list[str]] = {name: [] for name in wanted}
    for path in files:
        with contextlib.suppress(OSError):
            if path.stat().st_size <= LARGEST:
                content = path.read_bytes()
                for name, secret in wanted.items():
                    if secret in content:
                        holding[name].append(str(path))
    data = sorted(str(path) for path in Path("/data").rglob("*"))
    return {
        "host": socket.gethostname(),
        "holding": holding,
        "data": data,
        "reached": [each for each in addresses if answers(each)],
        "user": os.getuid(),
    }


def answers(address: str) -> bool:
    """Whether anything listens at host:port."""
    host, _, port = address.rpartition(":")
    try:
        with socket.create_connection((host, int(port)), timeout=3.0):
            return True
    except OSError:
        return False


def main() -> None:
    """Print what was found on each node, as JSON."""
    reversed_secrets, addresses = json.loads(sys.argv[1]), json.loads(sys.argv[2])
    ray.init(address="auto", log_to_driver=False)
    task = ray.remote(num_cpus=0)(found_on_a_node)
    nodes = [node["NodeID"] for node in ray.nodes() if node["Alive"]]  # type: ignore[no-untyped-call]
    found = [
        task.options(scheduling_strategy=NodeAffinitySchedulingStrategy(node, soft=False)).remote(
            reversed_secrets, addresses
        )
        for node in nodes
    ]
    print(json.dumps(ray.get(found, timeout=240)))  # noqa: T201


main()

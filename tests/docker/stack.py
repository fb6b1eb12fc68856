"""The containers of `docker/compose.yml`, brought up by podman-compose."""

import json
import os
import secrets
import shutil
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from service.client import Client, ServiceError
from tests.docker.engine import Engine
from tests.end_to_end.curves import wait_for
from tests.end_to_end.running_service import free_port

DOCKER = Path(__file__).parents[2] / "docker"
PROJECT = "d3pg"
SECRETS = ("token", "ray_token", "database_password")
LIMITS = """\
services:
  head: &limits {ulimits: {nofile: 4096, nproc: 16384}}
  worker: *limits
  driver: *limits
  service: *limits
"""
"""Those of the file may be more than this machine may give."""
READY_SECONDS = 600.0


class Stack:
    """All containers, in a folder with their secrets; of two workers with a core each."""

    def __init__(self, engine: Engine, folder: Path) -> None:
        """Start nothing yet."""
        self.engine = engine
        self._folder = folder
        shutil.copy(DOCKER / "compose.yml", folder)
        (folder / "limits.yml").write_text(LIMITS)
        (folder / "secrets").mkdir(mode=0o700)
        self.secrets = {name: secrets.token_hex(32) for name in SECRETS}
        for name, secret in self.secrets.items():
            (folder / "secrets" / name).write_text(secret + "\n")
        port = free_port()
        self._environment = engine.environment | {
            "PORT": str(port),
            "CORES": "1",
            "WORKER_MEMORY": "1GB",
            "WORKER_CONTAINER_MEMORY": "3g",
        }
        self.client = Client(f"http://localhost:{port}", self.secrets["token"])

    def compose(self, *words: str, content: bytes = b"") -> bytes:
        """Run a command of Compose and return what it prints."""
        files = ("--file=compose.yml", "--file=limits.yml")
        done = subprocess.run(
            [sys.executable, "-m", "podman_compose", *files, *words],
            cwd=self._folder,
            env=self._environment,
            input=content,
            capture_output=True,
            check=False,
        )
        assert done.returncode == 0, f"compose {' '.join(words)}: {done.stderr.decode()}"
        return done.stdout

    def up(self, workers: int = 2) -> None:
        """Bring up what is not there, and wait until the service and so many workers are ready."""
        self.compose("up", "--detach", "--no-build", "--no-recreate", f"--scale=worker={workers}")
        self.wait_until_ready()

    def wait_until_ready(self) -> None:
        """Wait until runs can be stored and started."""
        wait_for(self._is_ready, READY_SECONDS)

    def name(self, service: str, number: int = 1) -> str:
        """Return the name of a container."""
        return f"{PROJECT}_{service}_{number}"

    def is_healthy(self, container: str) -> bool:
        """Whether its health check passes; nobody else runs it where there is no systemd."""
        done = subprocess.run(
            ["podman", "healthcheck", "run", container],
            env=self.engine.environment,
            capture_output=True,
            check=False,
        )
        return done.returncode == 0

    def kill(self, container: str) -> None:
        """End a container as an accident would: its first process is killed, not by podman."""
        os.kill(self._process(container), signal.SIGKILL)

    def run_inside(self, container: str, code: str, arguments: Sequence[str] = ()) -> str:
        """Run Python code in a container, and return what it prints."""
        return self.engine.run(
            "exec", "--interactive", container, "python", "-", *arguments, content=code
        )

    def address(self, container: str, network: str) -> str:
        """Return the address of a container in a network."""
        [found] = json.loads(self.engine.run("inspect", container))
        networks = found["NetworkSettings"]["Networks"]
        return str(networks[f"{PROJECT}_{network}"]["IPAddress"])

    def _process(self, container: str) -> int:
        return int(self.engine.run("inspect", "--format={{.State.Pid}}", container))

    def _is_ready(self) -> bool:
        try:
            return self.client.readiness().status == "ready"
        except (OSError, ServiceError):
            return False

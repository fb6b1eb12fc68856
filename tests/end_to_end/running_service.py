"""A real service in processes of its own, as a user runs it."""

import os
import secrets
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from functools import cached_property
from pathlib import Path

from service.client import Client, ServiceError
from tests.workers.processes import command_line, processes_with, processor_seconds

ROOT = Path(__file__).resolve().parents[2]
START_SECONDS = 60.0
READY_SECONDS = 90.0
STOP_SECONDS = 20.0
FAMILY = "TESTED_SERVICE"
"""A variable that every process of a service inherits; Ray's have none of the service's own."""
PORTS = range(20_000, 32_768)  # below those that Linux gives away by itself, to Ray above all


class RunningService:
    """`python -m service` on a free port, with its data in `data_dir`.

    Or, where there is one, a command that comes to the same, at an address of this machine.
    """

    def __init__(
        self,
        data_dir: Path,
        *,
        environment: Mapping[str, str] | None = None,
        command: Sequence[str] = (sys.executable, "-m", "service"),
        address: str = "127.0.0.1",
    ) -> None:
        """Start nothing yet. The environment is added to this process's."""
        self.data_dir = data_dir
        self.port = free_port()
        self.url = f"http://{address}:{self.port}"
        self._command = command
        own = {
            "D3PG_DATA_DIR": str(data_dir),
            "D3PG_PORT": str(self.port),
            "D3PG_URL": self.url,
            "D3PG_WORKERS": "2",
            FAMILY: str(data_dir),
            "PYTHONPATH": str(ROOT),
            "NO_COLOR": "1",
        }
        self.environment = {**os.environ, **own, **(environment or {})}
        self.process: subprocess.Popen[bytes] | None = None
        self._launched = 0.0
        self.serving_after = 0.0  # seconds from the last start to the first answer
        self.work_until_serving = 0.0  # of a processor, in that time

    def start(self) -> Client:
        """Start the service and wait until it answers and its cluster is ready."""
        self.launch()
        return self.wait_until_ready()

    def launch(self) -> None:
        """Start the service and wait for nothing."""
        self._launched = time.monotonic()
        self.serving_after = 0.0
        with (self.data_dir / "terminal.txt").open("ab") as terminal:
            self.process = subprocess.Popen(
                self._command,
                env=self.environment,
                stdin=subprocess.DEVNULL,
                stdout=terminal,
                stderr=terminal,
            )

    def wait_until_ready(self) -> Client:
        """Wait until the service answers and its cluster is ready."""
        assert self.process is not None
        deadline = time.monotonic() + START_SECONDS + READY_SECONDS
        while time.monotonic() < deadline:
            assert self.process.poll() is None, self.terminal()
            try:
                status = self.client.readiness().status
            except (OSError, ServiceError):
                time.sleep(0.05)
                continue
            if not self.serving_after:
                self.serving_after = time.monotonic() - self._launched
                self.work_until_serving = processor_seconds(self.process.pid)
            if status == "ready":
                return self.client
            time.sleep(0.2)
        raise TimeoutError(f"the service did not become ready:\n{self.terminal()}")

    @property
    def is_serving(self) -> bool:
        """Whether it answers, be its cluster ready or not."""
        try:
            self.client.readiness()
        except (OSError, ServiceError):
            return False
        return True

    @cached_property
    def client(self) -> Client:
        """Talks to the service, whichever process it is; the first one has made the token."""
        return Client(self.url, (self.data_dir / "token").read_text().strip())

    def terminal(self) -> str:
        """Everything the service printed."""
        return (self.data_dir / "terminal.txt").read_text()

    def command(self, *arguments: str, stdin: str = "") -> subprocess.CompletedProcess[str]:
        """Run `d3pg` against this service."""
        return subprocess.run(
            [sys.executable, "-m", "service.cli", *arguments],
            env=self.environment,
            input=stdin,
            capture_output=True,
            text=True,
            timeout=240,
            check=False,
        )

    def worker_pids(self) -> list[int]:
        """The processes that train."""
        return [pid for pid in self.family() if is_worker(pid)]

    def family(self) -> set[int]:
        """The server and all that it or an earlier one has started, whoever their parents are."""
        return processes_with(f"{FAMILY}={self.data_dir}\0")

    def kill(self) -> None:
        """End the server as a power cut would: SIGKILL, and wait for its end."""
        assert self.process is not None
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()

    @contextmanager
    def open_streams(self, count: int) -> Iterator[None]:
        """Have so many event streams open."""
        token = (self.data_dir / "token").read_text().strip()
        request = (
            "GET /api/v1/events HTTP/1.1\r\nHost: 127.0.0.1\r\n"
            f"Authorization: Bearer {token}\r\n\r\n"
        )
        with ExitStack() as streams:
            for _ in range(count):
                stream = streams.enter_context(
                    socket.create_connection(("127.0.0.1", self.port), timeout=START_SECONDS)
                )
                stream.sendall(request.encode())
                assert stream.recv(1)
            yield

    def stop(self, by: signal.Signals = signal.SIGINT) -> float:
        """End the service, as Ctrl-C would; the seconds it took. None of its processes is left."""
        assert self.process is not None
        family = self.family()
        begun = time.monotonic()
        self.process.send_signal(by)
        self.process.wait(STOP_SECONDS)
        seconds = time.monotonic() - begun
        wait_for_end(family)
        return seconds


@contextmanager
def running_service(
    data_dir: Path, environment: Mapping[str, str] | None = None
) -> Iterator[tuple[RunningService, Client]]:
    """A service that is up and ready, ended in any case."""
    service = RunningService(data_dir, environment=environment)
    try:
        yield service, service.start()
    finally:
        family = service.family()
        service.client.close()
        if service.process is not None and service.process.poll() is None:
            service.process.send_signal(signal.SIGINT)
            try:
                service.process.wait(STOP_SECONDS)
            except subprocess.TimeoutExpired:
                kill(family)
                service.process.wait()
        else:
            kill(family)  # which would wait for another service
        wait_for_end(family)


def free_port() -> int:
    """A port that nothing uses now, and that nobody is given before it is used."""
    while True:
        port = secrets.choice(PORTS)
        with socket.socket() as probe, suppress(OSError):
            probe.bind(("", port))
            return port


def is_worker(pid: int) -> bool:
    """Whether a process is a Ray actor that trains."""
    return " ".join(command_line(pid)).startswith("ray::Worker")


def is_training(pid: int) -> bool:
    """Whether a process is a Ray actor that trains now."""
    return " ".join(command_line(pid)).startswith("ray::Worker.train")


def kill(pids: Collection[int]) -> None:
    """End processes by force, those that are still there."""
    for pid in pids:
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)


def wait_for_end(pids: Collection[int], seconds: float = 20.0) -> None:
    """Wait until none of these processes runs; fails the test with those that do."""
    deadline = time.monotonic() + seconds
    while left := [pid for pid in pids if is_running(pid)]:
        if time.monotonic() > deadline:
            names = [" ".join(command_line(pid)) for pid in left]
            raise AssertionError(f"still running: {names}")
        time.sleep(0.1)


def is_running(pid: int) -> bool:
    """Whether the process exists and is no zombie."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False

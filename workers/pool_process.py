"""The pool as a process of its own, which holds the connection to Ray.

Ray ends the process that drives it when the cluster's head is lost. That must not be the service,
so `python -m workers` drives Ray, and talks JSON lines over a socket with the service: commands
one way, reports the other. Either end sees the other's death as the end of the stream.
"""

import json
import os
import queue
import secrets
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from workers.log_tail import log_tail
from workers.pool import PoolUnavailableError
from workers.report import Report, from_line
from workers.work import Work

TOKEN_VARIABLES = ("RAY_AUTH_TOKEN", "RAY_AUTH_TOKEN_PATH")
CLOSING_SECONDS = 4.0
"""How long the process may take to end Ray in order; then all of its group is killed."""


@dataclass(frozen=True)
class PoolSettings:
    """Where the workers are.

    workers      local worker slots; of no account with an address
    ray_address  a cluster to join; empty: a local one, made and ended with the pool
    data_dir     takes the token file and the logs
    checkpoints  folder of the runs' checkpoints
    """

    workers: int
    ray_address: str
    data_dir: Path
    checkpoints: Path


class PoolProcess:
    """A Pool (see workers/pool.py) in a process of its own."""

    def __init__(self, settings: PoolSettings) -> None:
        """Start nothing yet."""
        self._settings = settings
        self._reports: queue.SimpleQueue[Report | None] = queue.SimpleQueue()
        self._process: subprocess.Popen[bytes] | None = None
        self._channel: socket.socket | None = None
        self._scratch = ""

    def start(self) -> None:
        """Start the process. Workers come up while this returns."""
        self.close()
        logs = self._settings.data_dir / "logs"
        logs.mkdir(parents=True, exist_ok=True)
        ours, theirs = socket.socketpair()
        self._reports = queue.SimpleQueue()
        # Ray's own files: short, for a socket's path has at most 107 bytes, and gone at the end.
        self._scratch = tempfile.mkdtemp(prefix="d3pg-ray-")
        with theirs, self._log_path.open("wb") as log:
            self._process = subprocess.Popen(  # noqa: S603  (our own interpreter and module)
                [
                    sys.executable,
                    "-m",
                    "workers",
                    f"--channel={theirs.fileno()}",
                    f"--workers={self._settings.workers}",
                    f"--address={self._settings.ray_address}",
                    f"--logs={logs.resolve()}",
                    f"--checkpoints={self._settings.checkpoints.resolve()}",
                    f"--scratch={self._scratch}",
                ],
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                env=pool_environment(self._settings),
                start_new_session=True,  # Ctrl-C is for the service, which then closes the pool
            )
        self._channel = ours
        threading.Thread(
            target=_listen, args=(ours, self._reports), name="pool reports", daemon=True
        ).start()

    def train(self, worker: str, work: Work) -> None:
        """Train a cohort."""
        self._send(do="train", worker=worker, work=work.to_json())

    def drop(self, worker: str, seeds: Collection[int]) -> None:
        """Train these seeds no further."""
        self._send(do="drop", worker=worker, seeds=sorted(seeds))

    def kill(self, worker: str) -> None:
        """End a worker's process."""
        self._send(do="kill", worker=worker)

    def reports(self, timeout_seconds: float) -> list[Report]:
        """Wait for reports. Raises PoolUnavailableError when the process has ended.

        What it had started is ended then too.
        """
        found: list[Report] = []
        try:
            report = self._reports.get(timeout=timeout_seconds)
            while report is not None:
                found.append(report)
                report = self._reports.get_nowait()
        except queue.Empty:
            return found
        if found:
            self._reports.put(None)  # the end is told next time, after what came before it
            return found
        last_words = self._last_words()
        self.close()
        raise PoolUnavailableError(last_words)

    def close(self) -> None:
        """End the process and all it started: in order, or by force after a while."""
        if self._process is None or self._channel is None:
            return
        self._channel.shutdown(socket.SHUT_WR)
        try:
            self._process.wait(CLOSING_SECONDS)
        except subprocess.TimeoutExpired:
            pass
        finally:
            kill_group(self._process.pid)
            self._process.wait()
            self._channel.close()
            shutil.rmtree(self._scratch, ignore_errors=True)
            self._process = self._channel = None

    @property
    def process_id(self) -> int | None:
        """The process that drives Ray; None while there is none."""
        return None if self._process is None else self._process.pid

    @property
    def _log_path(self) -> Path:
        return self._settings.data_dir / "logs" / "pool.log"

    def _send(self, **command: Any) -> None:
        if self._channel is None:
            raise PoolUnavailableError("the pool has not been started")
        try:
            self._channel.sendall(json.dumps(command).encode() + b"\n")
        except OSError:
            return  # its end is told by `reports`

    def _last_words(self) -> str:
        code = None if self._process is None else self._process.wait()
        lines = log_tail(self._log_path).strip().splitlines()
        last = next((line for line in reversed(lines) if line.strip()), "it left no message")
        return f"the process that drives Ray ended (exit code {code}): {last.strip()}"


def pool_environment(settings: PoolSettings) -> dict[str, str]:
    """Return the environment of the process: ours, and what Ray and the workers need set.

    Ray turns its authentication on by itself in some processes only, and the others then fail, so
    it is set for all of them; the token is the data directory's, or for a cluster to join the one
    that the variables name. A local Ray binds to loopback alone. One thread a worker: the thread
    count of a library changes the bits, and is read as it loads.
    """
    environment = dict(os.environ)
    environment.update(
        RAY_AUTH_MODE="token",
        RAY_USAGE_STATS_ENABLED="0",
        RAY_ENABLE_UV_RUN_RUNTIME_ENV="0",
        RAY_ENABLE_AUTO_CONNECT="0",
        OMP_NUM_THREADS="1",
        MKL_NUM_THREADS="1",
        OPENBLAS_NUM_THREADS="1",
        NUMBA_NUM_THREADS="1",
    )
    if not settings.ray_address:
        environment["RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER"] = "0"
        for variable in TOKEN_VARIABLES:
            environment.pop(variable, None)
    if not set(TOKEN_VARIABLES) & set(environment):
        environment["RAY_AUTH_TOKEN_PATH"] = str(_token_file(settings.data_dir))
    source = Path(__file__).resolve().parent.parent
    if source.name not in {"site-packages", "dist-packages"}:  # not installed, but run in place
        paths = [str(source), environment.get("PYTHONPATH", "")]
        environment["PYTHONPATH"] = os.pathsep.join(path for path in paths if path)
    return environment


def kill_group(leader: int) -> None:
    """Kill what is left of a process group."""
    try:
        os.killpg(leader, signal.SIGKILL)
    except ProcessLookupError:
        return


def _token_file(data_dir: Path) -> Path:
    """Return the file with the token of the local cluster, made at first use, ours alone."""
    path = data_dir.resolve() / "ray-token"
    if not path.exists():
        descriptor = os.open(path, os.O_CREAT | os.O_WRONLY | os.O_EXCL, 0o600)
        with os.fdopen(descriptor, "w") as file:
            file.write(secrets.token_hex(32))
    return path


def _listen(channel: socket.socket, reports: "queue.SimpleQueue[Report | None]") -> None:
    """Turn lines into reports until the stream ends."""
    try:
        with channel.makefile("rb") as lines:
            for line in lines:
                reports.put(from_line(line))
    except (OSError, ValueError):  # cut off, perhaps within a line
        pass
    reports.put(None)

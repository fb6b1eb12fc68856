"""The pool as a process of its own, which holds the connection to Ray.

Ray ends the process that drives it when the cluster's head is lost. That must not be the service,
so `python -m workers` drives Ray, and talks JSON lines over a Unix socket with the service:
commands one way, reports the other.

The process outlives a service that is killed, keeps its workers at work and what they say (see
`workers/driver/outbox.py`), and is taken up by the next service on the data directory; a service
that is stopped closes it. Where it has ended meanwhile, what it had to say is read from its spool.
"""

import contextlib
import json
import queue
import shutil
import socket
import subprocess
import sys
import tempfile
import threading
from collections.abc import Collection
from dataclasses import asdict, dataclass
from io import BufferedReader
from pathlib import Path
from typing import Any

from workers.checkpoints.place import Place
from workers.driver.outbox import read_spool
from workers.driver.placement import Bounds
from workers.driver.settings import DriverSettings
from workers.messages.log_tail import log_tail
from workers.messages.report import FORMAT, Report, from_line
from workers.messages.work import Work
from workers.pool.environment import pool_environment
from workers.pool.pool import PoolUnavailableError
from workers.pool.process_group import kill_group, runs_with, wait_for_end

CLOSING_SECONDS = 1.5
"""How long the process may take to end Ray in order; then all of its group is killed."""
GREETING_SECONDS = 5.0
"""How long a process that is to be taken up may take to say a word."""


@dataclass(frozen=True)
class PoolSettings:
    """Where the workers are.

    workers      local worker slots; of no account with an address
    ray_address  a cluster to join; empty: a local one, made and ended with the pool
    data_dir     takes the token file, the logs and the spools
    checkpoints  where the workers keep them: a folder, as they see it, or s3://bucket/prefix
    min_workers  on a joined cluster: kept however little there is to do
    max_workers  on a joined cluster: the most there may be
    worker_bytes memory that each needs of its node; 0: any
    """

    workers: int
    ray_address: str
    data_dir: Path
    checkpoints: Place
    min_workers: int = 1
    max_workers: int = 1024
    worker_bytes: int = 0

    @property
    def bounds(self) -> Bounds:
        """How many workers there may be."""
        if self.ray_address:
            return Bounds(self.min_workers, self.max_workers)
        return Bounds(self.workers, self.workers)

    def for_driver(self, listener: int, scratch: str) -> DriverSettings:
        """Return what the process is told that listens there."""
        return DriverSettings(
            listener=listener,
            address=self.ray_address,
            **asdict(self.bounds),
            worker_bytes=self.worker_bytes,
            logs=(self.data_dir / "logs").resolve(),
            checkpoints=str(self.checkpoints),
            spool=(self.data_dir / "spool").resolve() / f"{Path(scratch).name}.jsonl",
            scratch=scratch,
        )


class PoolProcess:
    """A Pool (see workers/pool/pool.py) in a process of its own."""

    def __init__(self, settings: PoolSettings) -> None:
        """Start nothing yet."""
        self._settings = settings
        self._reports: queue.SimpleQueue[Report | None] = queue.SimpleQueue()
        self._process_id: int | None = None
        self._process: subprocess.Popen[bytes] | None = None  # where it is our child
        self._channel: socket.socket | None = None
        self._scratch = ""
        self._spooled = 0  # reports of processes that are no more, yet to be acknowledged

    def start(self) -> None:
        """Take up the process that an earlier service left, or start one.

        Workers come up while this returns.
        """
        self.close()
        self._reports = queue.SimpleQueue()
        self._spooled = 0
        if self._take_up():
            return
        self._read_spools()
        self._launch()

    def train(self, worker: str, work: Work) -> None:
        """Train a cohort."""
        self._send(do="train", worker=worker, work=work.to_json())

    def drop(self, worker: str, seeds: Collection[int]) -> None:
        """Train these seeds no further."""
        self._send(do="drop", worker=worker, seeds=sorted(seeds))

    def kill(self, worker: str) -> None:
        """End a worker's process."""
        self._send(do="kill", worker=worker)

    def demand(self, workers: int) -> None:
        """There is work for so many workers."""
        self._send(do="demand", workers=workers)

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

    def acknowledge(self, count: int) -> None:
        """So many more of the reports given out are recorded, in their order."""
        of_spools = min(count, self._spooled)
        self._spooled -= of_spools
        if of_spools and not self._spooled:
            for spool in self._spools():
                spool.unlink()
        if count > of_spools:
            self._send(do="acknowledge", count=count - of_spools)

    def close(self) -> None:
        """End the process and all it started: in order, or by force after a while."""
        if self._process_id is None or self._channel is None:
            return
        self._send(do="close")
        with contextlib.suppress(OSError):
            self._channel.shutdown(socket.SHUT_WR)
        wait_for_end(self._process_id, CLOSING_SECONDS)
        kill_group(self._process_id)
        if self._process is not None:
            self._process.wait()
        self._channel.close()
        self._record.unlink(missing_ok=True)
        shutil.rmtree(self._scratch, ignore_errors=True)
        self._process_id = self._process = self._channel = None

    @property
    def process_id(self) -> int | None:
        """The process that drives Ray; None while there is none."""
        return self._process_id

    # ---- finding and starting the process

    def _launch(self) -> None:
        self._log_path.parent.mkdir(parents=True, exist_ok=True)
        # Ray's own files: short, for a socket's path has at most 107 bytes, and gone at the end.
        self._scratch = tempfile.mkdtemp(prefix="d3pg-ray-")
        with socket.socket(socket.AF_UNIX) as listener, self._log_path.open("wb") as log:
            listener.bind(self._socket_path)
            listener.listen(1)
            driver = self._settings.for_driver(listener.fileno(), self._scratch)
            self._process = subprocess.Popen(  # noqa: S603  (our own interpreter and module)
                [sys.executable, "-m", "workers", *driver.arguments()],
                pass_fds=[listener.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                env=pool_environment(self._settings.ray_address, self._settings.data_dir),
                start_new_session=True,  # Ctrl-C is for the service, which then closes the pool
            )
            self._channel = self._connect()
        self._process_id = self._process.pid
        self._record.write_text(json.dumps(self._described()))
        self._listen(self._channel.makefile("rb"))

    def _take_up(self) -> bool:
        """Take up the process of an earlier service, where it is the one that is wanted and well.

        Otherwise it is ended.
        """
        try:
            described = json.loads(self._record.read_text())
            self._scratch = described["scratch"]
            pid = described["process"]
        except (OSError, ValueError, LookupError, TypeError):
            return False
        if runs_with(pid, f"--scratch={self._scratch}"):
            self._process_id = pid
            if described == self._described() and self._is_answered():
                return True
            kill_group(pid)
            wait_for_end(pid, CLOSING_SECONDS)
            self._process_id = None
        shutil.rmtree(self._scratch, ignore_errors=True)  # of one that is no more
        return False

    def _is_answered(self) -> bool:
        """Connect to the process of an earlier service, and see whether it says a word."""
        try:
            channel = self._connect()
            channel.settimeout(GREETING_SECONDS)
            lines = channel.makefile("rb")
            is_answered = bool(lines.peek(1))
        except OSError:
            return False
        if is_answered:
            channel.settimeout(None)
            self._channel = channel
            self._listen(lines)
        return is_answered

    def _described(self) -> dict[str, Any]:
        return {
            "format": FORMAT,
            "process": self._process_id,
            "scratch": self._scratch,
            "bounds": asdict(self._settings.bounds),
            "worker_bytes": self._settings.worker_bytes,
            "ray_address": self._settings.ray_address,
            "checkpoints": str(self._settings.checkpoints),
        }

    def _read_spools(self) -> None:
        for spool in self._spools():
            for report in read_spool(spool):
                self._spooled += 1
                self._reports.put(report)

    def _spools(self) -> list[Path]:
        """The files that processes left which are no more."""
        found = sorted(self._spool_folder.glob("*.jsonl"))
        return [path for path in found if path.stem != Path(self._scratch).name or self._is_gone]

    # ---- the channel

    def _connect(self) -> socket.socket:
        channel = socket.socket(socket.AF_UNIX)
        try:
            channel.connect(self._socket_path)
        except OSError:
            channel.close()
            raise
        return channel

    def _listen(self, lines: BufferedReader) -> None:
        threading.Thread(
            target=_listen, args=(lines, self._reports), name="pool reports", daemon=True
        ).start()

    def _send(self, **command: Any) -> None:
        if self._channel is None:
            raise PoolUnavailableError("the pool has not been started")
        try:
            self._channel.sendall(json.dumps(command).encode() + b"\n")
        except OSError:
            return  # its end is told by `reports`

    @property
    def _is_gone(self) -> bool:
        return self._process_id is None

    @property
    def _log_path(self) -> Path:
        return self._settings.data_dir / "logs" / "pool.log"

    @property
    def _record(self) -> Path:
        return self._settings.data_dir / "pool.json"

    @property
    def _spool_folder(self) -> Path:
        return self._settings.data_dir / "spool"

    @property
    def _socket_path(self) -> str:
        return f"{self._scratch}/pool.sock"

    def _last_words(self) -> str:
        code = None if self._process is None else self._process.wait()
        lines = log_tail(self._log_path).strip().splitlines()
        last = next((line for line in reversed(lines) if line.strip()), "it left no message")
        return f"the process that drives Ray ended (exit code {code}): {last.strip()}"


def _listen(lines: BufferedReader, reports: "queue.SimpleQueue[Report | None]") -> None:
    """Turn lines into reports, after the greeting, until the stream ends."""
    try:
        with lines:
            lines.readline()
            for line in lines:
                reports.put(from_line(line))
    except (OSError, ValueError):  # cut off, perhaps within a line
        pass
    reports.put(None)

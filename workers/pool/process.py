"""The pool as a process of its own, which holds the connection to Ray.

Ray ends the process that drives it when the cluster's head is lost. That must not be the service,
so `python -m workers` drives Ray, and talks JSON lines over a Unix socket with the service:
commands one way, reports the other.

The process outlives a service that is killed, and keeps its workers at work, and their reports (see
`workers/driver/outbox.py`). The next service on the data directory connects to it; a service that
is stopped closes it. If it has ended meanwhile, the next process sends its reports.
"""

import contextlib
import json
import shutil
import socket
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from workers.checkpoints.place import Place
from workers.driver.settings import DriverSettings
from workers.driver.terms import Terms
from workers.messages.log_tail import log_tail
from workers.messages.report import FORMAT
from workers.pool.driven_pool import GREETING_SECONDS, DrivenPool
from workers.pool.environment import pool_environment
from workers.pool.process_group import kill_group, runs_with, wait_for_end

CLOSING_SECONDS = 1.5
"""How long the process may take to end Ray in order, before its group is killed."""
SOCKET = "pool.sock"
"""A file in the folder of the process."""


@dataclass(frozen=True)
class PoolSettings:
    """Where the workers are.

    workers      local worker slots; ignored with an address
    ray_address  a cluster to join; empty: a local one, made and ended with the pool
    data_dir     takes the token file, the logs and the spools
    checkpoints  where the workers keep them: a folder, as they see it, or s3://bucket/prefix
    min_workers  on a joined cluster: kept even if there is less work
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
    def terms(self) -> Terms:
        """The terms for the process."""
        least, most = self.workers, self.workers
        if self.ray_address:
            least, most = self.min_workers, self.max_workers
        return Terms(self.ray_address, least, most, self.worker_bytes, str(self.checkpoints))

    def for_driver(self, listener: int, scratch: str) -> DriverSettings:
        """Return the settings of the process that listens there."""
        return DriverSettings(
            socket=Path(scratch) / SOCKET,
            logs=(self.data_dir / "logs").resolve(),
            spool=(self.data_dir / "spool").resolve() / "pool.jsonl",
            scratch=scratch,
            listener=listener,
        )


class PoolProcess(DrivenPool):
    """A Pool (see workers/pool/pool.py) in a process of its own."""

    def __init__(self, settings: PoolSettings) -> None:
        """Start nothing yet."""
        super().__init__()
        self._settings = settings
        self._process_id: int | None = None
        self._process: subprocess.Popen[bytes] | None = None  # where it is our child
        self._scratch = ""

    def start(self) -> None:
        """Connect to the process that an earlier service left, or start one.

        Workers start in the background.
        """
        self.close()
        if not self._take_up():
            self._launch()

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
            driver = self._settings.for_driver(listener.fileno(), self._scratch)
            listener.bind(str(driver.socket))
            listener.listen(1)
            self._process = subprocess.Popen(  # noqa: S603  (our own interpreter and module)
                [sys.executable, "-m", "workers", *driver.arguments()],
                pass_fds=[listener.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                env=pool_environment(self._settings.ray_address, self._settings.data_dir),
                start_new_session=True,  # Ctrl-C is for the service, which then closes the pool
            )
            self._connect(driver.socket, self._settings.terms, greeting_seconds=None)
        self._process_id = self._process.pid
        record = {"format": FORMAT, "process": self._process_id, "scratch": self._scratch}
        self._record.write_text(json.dumps(record))

    def _take_up(self) -> bool:
        """Connect to the process of an earlier service, if it has the same terms and works.

        Otherwise end it.
        """
        try:
            record = json.loads(self._record.read_text())
            self._scratch, pid, spoken = record["scratch"], record["process"], record["format"]
        except (OSError, ValueError, LookupError, TypeError):
            return False
        if runs_with(pid, f"--scratch={self._scratch}"):
            self._process_id = pid
            if spoken == FORMAT and self._is_answered():
                return True
            kill_group(pid)
            wait_for_end(pid, CLOSING_SECONDS)
            self._process_id = None
        shutil.rmtree(self._scratch, ignore_errors=True)  # of one that is no more
        return False

    def _is_answered(self) -> bool:
        """Connect to the process of an earlier service; return whether it accepts the terms."""
        try:
            path = Path(self._scratch) / SOCKET
            return self._connect(path, self._settings.terms, GREETING_SECONDS)
        except OSError:
            return False

    @property
    def _log_path(self) -> Path:
        return self._settings.data_dir / "logs" / "pool.log"

    @property
    def _record(self) -> Path:
        return self._settings.data_dir / "pool.json"

    def _last_words(self) -> str:
        code = None if self._process is None else self._process.wait()
        lines = log_tail(self._log_path).strip().splitlines()
        last = next((line for line in reversed(lines) if line.strip()), "it left no message")
        return f"the process that drives Ray ended (exit code {code}): {last.strip()}"

"""A service that a command starts for itself: a child process that ends with the command.

Its database, log and checkpoints stay in the data directory. The next service that is started there
goes on with what is queued.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from service.client import Client, ServiceError
from service.data_dir import make_private

START_SECONDS = 60.0
STOP_SECONDS = 20.0


@contextmanager
def own_service() -> Iterator[tuple[Client, subprocess.Popen[bytes]]]:
    """A client of a service started here, and its process; ended with the block.

    SIGTERM and SIGHUP become KeyboardInterrupt, so that the service ends with the command.
    """
    for ending in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(ending, signal.default_int_handler)
    log = data_dir() / "logs" / "service.log"
    make_private(data_dir())
    log.parent.mkdir(mode=0o700, exist_ok=True)
    with log.open("wb") as output:
        service = subprocess.Popen(
            [sys.executable, "-m", "service"],
            env={"D3PG_WORKERS": "2"} | os.environ,
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=output,
            start_new_session=True,  # Ctrl-C reaches the service through `stop` alone
        )
    try:
        yield connect(service, log), service
    finally:
        stop(service)


def data_dir() -> Path:
    """Where the service keeps everything."""
    return Path(os.environ.get("D3PG_DATA_DIR") or "d3pg-data")


def connect(service: subprocess.Popen[bytes], log: Path) -> Client:
    """A client of the service that is starting; raises ServiceError if it does not come up."""
    deadline = time.monotonic() + START_SECONDS
    while time.monotonic() < deadline:
        if service.poll() is not None:
            raise ServiceError(
                f"The service ended while starting (exit code {service.returncode}):\n"
                + log.read_text(encoding="utf-8", errors="replace")[-2000:]
            )
        try:
            client = Client()
            client.readiness()
        except ServiceError:
            time.sleep(0.2)
        else:
            return client
    raise ServiceError(f"The service did not answer within {START_SECONDS:g} s.")


def stop(service: subprocess.Popen[bytes]) -> None:
    """End the service as Ctrl-C would; kill it only if it does not exit."""
    if service.poll() is None:
        service.send_signal(signal.SIGINT)
    try:
        service.wait(STOP_SECONDS)
    except subprocess.TimeoutExpired:
        service.kill()
        service.wait()

"""`d3pg demo`: the whole system at once, for a first look.

Starts the service as a child process (embedded SQLite, a local Ray on two cores), waits until
it answers, submits the demo sweep (or goes on with one that was interrupted), prints the link
that signs a browser in, follows the training, and keeps the dashboard up until Ctrl-C.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from rich.console import Console

from service.cli.following import follow
from service.client import Client, ServiceError, has_ended

DEMO_SWEEP: dict[str, Any] = {
    "name": "demo",
    "algorithms": [{"name": "ddpg"}, {"name": "hybrid-ddpg"}],
    "environments": ["MassPoint", "Pendulum"],
    "seeds": 4,
    "timesteps": 20_000,
}
START_SECONDS = 60.0
STOP_SECONDS = 20.0


def run(console: Console, once: bool) -> int:
    """Run the demo; the exit code. Ctrl-C, or with `once` the sweep's end, ends the service."""
    for ending in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(ending, signal.default_int_handler)  # as Ctrl-C: the service goes too
    data_dir = Path(os.environ.get("D3PG_DATA_DIR") or "d3pg-data")
    log = data_dir / "logs" / "service.log"
    log.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    console.print("Starting the service and a local Ray ...")
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
        client = connect(service, log)
        sweep_id = demo_sweep(client)
        console.print(f"\n  The curves, live:  {sign_in_link(client, sweep_id)}\n", soft_wrap=True)
        code = follow(client, sweep_id, console)
        if once:
            return code
        console.print("\nDone. The dashboard stays up until Ctrl-C.")
        return service.wait()
    except KeyboardInterrupt:
        return 0
    finally:
        stop(service)
        console.print(f"Stopped. Everything measured is kept in {data_dir}/.", soft_wrap=True)


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


def demo_sweep(client: Client) -> str:
    """The id of the demo sweep to follow: an unfinished one, else a new one."""
    for sweep in client.sweeps():
        if sweep.name == DEMO_SWEEP["name"] and not has_ended(sweep):
            return sweep.id
    return client.submit(DEMO_SWEEP).id


def sign_in_link(client: Client, sweep_id: str) -> str:
    """The link that signs a browser in and opens the sweep."""
    return f"{client.url}/signin?token={client.token}&next=/sweeps/{sweep_id}"


def stop(service: subprocess.Popen[bytes]) -> None:
    """End the service as Ctrl-C would; kill it only if it does not go."""
    if service.poll() is None:
        service.send_signal(signal.SIGINT)
    try:
        service.wait(STOP_SECONDS)
    except subprocess.TimeoutExpired:
        service.kill()
        service.wait()

"""Reading a large sweep: seconds and bytes of its page's requests.

The sweep has 7 tasks, 8 curves in each, 16 seeds and 250 measurements a run: 896 runs, 224,000
points. Its numbers are invented, but the whole path is measured: an HTTP request arrives, stored
measurements are aggregated, and the body is sent. To hold: the curves in under 1 s and 1 MB. While
figures are drawn, a second client requests /healthz without pause: its 99th percentile shows
whether drawing delays others. Beside the wall time it prints the processor time of server and
client, which other programs on the machine cannot increase much; the best of several rounds counts.
"""

import argparse
import gzip
import logging
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import httpx2
import numpy as np
import structlog
import uvicorn
from pydantic import SecretStr

from algorithms.measurement import Measurement
from physics.randomness import generator
from service.api.app import create_app
from service.settings import Settings
from service.store.store import Store
from workers.messages.progress import Progress
from workers.messages.random_return import RandomReturn
from workers.messages.run_spec import RunSpec, Weights

TOKEN = "token-of-the-benchmark-0000"  # noqa: S105
TASKS = (
    "CartPole", "CartPoleSwingUp", "Pendulum", "MountainCar", "Acrobot", "RollingDie",
    "HalfCheetah",
)  # fmt: skip
CURVES = (
    ("ddpg", Weights()), ("hybrid-ddpg", Weights(1.0, 0.0)), ("hybrid-ddpg", Weights(0.1, 0.01)),
    ("hybrid-ddpg-cosine", Weights(1.0, 1.0)),
    ("sac", Weights()), ("hybrid-sac", Weights(1.0, 0.0)),
    ("gd", Weights()), ("mpc", Weights()),
)  # fmt: skip
SEEDS = 16
POINTS = 250
EVERY = 800


@dataclass
class NoCluster:
    """A dispatcher without workers."""

    problem: str | None = None
    workers: dict[str, bool] = field(default_factory=dict)


def main() -> None:
    structlog.configure(wrapper_class=structlog.make_filtering_bound_logger(logging.WARNING))
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--rounds", type=int, default=5)
    rounds = parser.parse_args().rounds
    with tempfile.TemporaryDirectory() as directory, serving(Path(directory)) as (url, sweep_id):
        headers = {"Authorization": f"Bearer {TOKEN}"}
        with httpx2.Client(base_url=url, headers=headers, timeout=60) as client:
            print(f"{len(TASKS) * len(CURVES) * SEEDS} runs, {POINTS} points each")
            print(f"{'':34}{'wall s':>8}{'cpu s':>8}{'kB':>8}{'kB gzip':>9}")
            link = f"/api/v1/sweeps/{sweep_id}"
            for what in (
                "", "/curves", "/curves?metric=return_history", "/curves?metric=critic_loss",
                "/table", "/statistics",
            ):  # fmt: skip
                report(client, link + what, rounds)
            tag = client.get(f"{link}/curves").headers["etag"]
            report(client, f"{link}/curves", rounds, {"If-None-Match": tag})
            with asking_healthz(url) as waits:
                for form in ("png", "svg", "pdf"):
                    report(client, f"{link}/plot.{form}", 1)
            waits.sort()
            print(
                f"/healthz while drawing: {len(waits)} requests, "
                f"p50 {waits[len(waits) // 2] * 1e3:.1f} ms, "
                f"p99 {waits[int(len(waits) * 0.99)] * 1e3:.1f} ms, "
                f"longest {waits[-1] * 1e3:.1f} ms"
            )


def report(
    client: httpx2.Client, path: str, rounds: int, headers: dict[str, str] | None = None
) -> None:
    seconds, processor = [], []
    for _ in range(rounds):
        started, busy = time.perf_counter(), time.process_time()
        response = client.get(path, headers=headers or {})
        seconds.append(time.perf_counter() - started)
        processor.append(time.process_time() - busy)
        assert response.status_code in (200, 304), response.text
    body = response.content
    name = path.partition("/sweeps/")[2].partition("/")[2] or "the sweep itself"
    if response.status_code == 304:
        name += ", unchanged (304)"
    print(
        f"{name:34}{min(seconds):8.3f}{min(processor):8.3f}"
        f"{len(body) / 1e3:8.0f}{len(gzip.compress(body)) / 1e3:9.0f}"
    )


@contextmanager
def serving(data_dir: Path) -> Iterator[tuple[str, str]]:
    """Serve a store with the sweep; yield the address and the sweep's id."""
    settings = Settings(data_dir=data_dir, token=SecretStr(TOKEN))
    store = Store.open(settings.store_url)
    sweep_id = fill(store)
    app = create_app(settings, store, NoCluster())
    server = uvicorn.Server(uvicorn.Config(app, port=0, log_level="critical"))
    thread = threading.Thread(target=server.run)
    thread.start()
    while not server.started:
        time.sleep(0.01)
    port = server.servers[0].sockets[0].getsockname()[1]
    yield f"http://127.0.0.1:{port}", sweep_id
    server.should_exit = True
    thread.join()
    store.close()


def fill(store: Store) -> str:
    """Store the sweep, as workers would."""
    specs = [
        RunSpec(name, task, seed, weights, EVERY * POINTS)
        for task in TASKS
        for name, weights in CURVES
        for seed in range(SEEDS)
    ]
    versions = dict.fromkeys(TASKS, 1)
    for task in TASKS:
        store.record_random_return(RandomReturn(task, 1, -1000.0, -1010.0, -990.0, 1000))
    entries = [{"name": name, "weights": {"w1": w1, "w2": w2}} for name, (w1, w2) in CURVES]
    request = {"algorithms": entries, "environments": list(TASKS), "seeds": SEEDS}
    sweep = store.create_sweep("overview", 0, request, specs, environment_versions=versions)
    while (claim := store.claim_cohort("worker", 600.0)) is not None:
        measurements = tuple(one for spec in claim.specs for one in measured(spec))
        ended = tuple(spec.seed for spec in claim.specs)
        store.record(claim, Progress(EVERY * POINTS, measurements=measurements, finished=ended))
    return sweep.id


def measured(spec: RunSpec) -> Iterator[Measurement]:
    walk = generator(spec.seed, f"{spec.cell}").standard_normal(POINTS).cumsum()
    returns = -1000 + 30 * walk + np.arange(POINTS)
    for index, value in enumerate(returns.tolist()):
        timestep = EVERY * (index + 1)
        history = float(returns[max(0, index - 99) : index + 1].mean())
        diagnostics = {"critic_loss": abs(value), "action_gradient_cosine": value / 2000}
        yield Measurement(
            spec.seed, timestep, value, history, timestep // 2, timestep, timestep / 1e4,
            diagnostics, 0.25,
        )  # fmt: skip


@contextmanager
def asking_healthz(url: str) -> Iterator[list[float]]:
    """Send requests without pause in this context; the list then holds the waits in seconds."""
    waits: list[float] = []
    is_over = threading.Event()

    def ask() -> None:
        with httpx2.Client(base_url=url) as client:
            while not is_over.wait(0.005):
                started = time.perf_counter()
                assert client.get("/healthz").status_code == 200
                waits.append(time.perf_counter() - started)

    thread = threading.Thread(target=ask)
    thread.start()
    yield waits
    is_over.set()
    thread.join()


if __name__ == "__main__":
    main()

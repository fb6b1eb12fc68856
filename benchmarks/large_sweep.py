"""Reading a sweep of 20,000 runs of 250 points: seconds and memory of its page's requests.

The sweep has 10 tasks, 20 entries in each and 100 seeds: five million invented points. To hold: any
read in at most 3 s and 300 MB more than the idle service, and 16 at once in 600 MB. The service is
a separate process; its memory is the largest that the kernel has seen (`VmHWM`), reset before each
request. Processor time is the service's. The second read shows the same data as the first, as when
a page is drawn again.
"""

import argparse
import logging
import multiprocessing
import os
import socket
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

import httpx2
import numpy as np
import structlog
import uvicorn
from pydantic import SecretStr
from sqlalchemy import text

from algorithms.measurement import Measurement
from benchmarks.overview import TOKEN, NoCluster
from physics.randomness import generator
from service.api.app import create_app
from service.settings import Settings
from service.store.connection import connect
from service.store.reading import measurements
from service.store.store import Store
from workers.messages.random_return import RandomReturn
from workers.messages.run_spec import RunSpec, Weights

TASKS = (
    "CartPole", "CartPoleSwingUp", "Pendulum", "MountainCar", "Acrobot", "RollingDie",
    "HalfCheetah", "MassPoint", "Hopper", "Walker2d",
)  # fmt: skip
ENTRIES = 20
SEEDS = 100
POINTS = 250
EVERY = 800
AT_ONCE = 16
READS = (
    "/curves", "/curves?band=iqr", "/curves?metric=critic_loss", "/curves?x=seconds&max_points=100",
    "/table", "/table?score=area", "/statistics", "/plot.csv?max_points=100",
)  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seeds", type=int, default=SEEDS)
    seeds = parser.parse_args().seeds
    with tempfile.TemporaryDirectory() as folder:
        settings = Settings(data_dir=Path(folder), token=SecretStr(TOKEN))
        sweep_id = filled(settings, seeds)
        with socket.create_server(("127.0.0.1", 0)) as listener:
            process = multiprocessing.get_context("spawn").Process(
                target=serve, args=(settings.data_dir, listener), daemon=True
            )
            process.start()
            assert process.pid is not None
            port = listener.getsockname()[1]
            headers = {"Authorization": f"Bearer {TOKEN}"}
            address = f"http://127.0.0.1:{port}"
            with httpx2.Client(base_url=address, headers=headers, timeout=600) as client:
                client.get("/healthz")
                report(client, process.pid, f"/api/v1/sweeps/{sweep_id}", ENTRIES * seeds)
            process.kill()
            process.join()


def report(client: httpx2.Client, pid: int, link: str, runs: int) -> None:
    load = os.getloadavg()[0]
    print(f"{runs * len(TASKS)} runs, {POINTS} points each; load {load:.1f}")
    print(f"{'':36}{'wall s':>8}{'cpu s':>8}{'MB more':>9}{'kB':>8}{'status':>8}")
    idle = memory(pid, "VmRSS")
    for what in READS:
        show(what, pid, idle, partial(read_once, client, link + what))
    with ThreadPoolExecutor(AT_ONCE) as threads:

        def together(read: Callable[[int], httpx2.Response]) -> list[httpx2.Response]:
            return list(threads.map(read, range(AT_ONCE)))

        paths = [f"{link}/curves?max_points={POINTS + each}" for each in range(AT_ONCE)]
        show(
            f"/curves, {AT_ONCE} at once",
            pid,
            idle,
            lambda: together(lambda each: client.get(paths[each])),
        )
        show(
            f"CSV begun, {AT_ONCE} at once",
            pid,
            idle,
            lambda: together(lambda _: begun(client, f"{link}/measurements")),
        )


def show(name: str, pid: int, idle: float, ask: Callable[[], list[httpx2.Response]]) -> None:
    Path(f"/proc/{pid}/clear_refs").write_text("5")  # reset the largest memory
    begun, busy = time.perf_counter(), processor_seconds(pid)
    answers = ask()
    wall, busy = time.perf_counter() - begun, processor_seconds(pid) - busy
    size = sum(len(each.content) for each in answers) / 1e3
    status = "/".join(sorted({str(each.status_code) for each in answers}))
    more = memory(pid, "VmHWM") - idle
    print(f"{name:36}{wall:8.2f}{busy:8.2f}{more:9.0f}{size:8.0f}{status:>8}", flush=True)


def read_once(client: httpx2.Client, address: str) -> list[httpx2.Response]:
    return [client.get(address)]


def begun(client: httpx2.Client, address: str) -> httpx2.Response:
    """Read the beginning of a stream, then close it."""
    with client.stream("GET", address) as response:
        chunks = response.iter_bytes()
        beginning = b"".join(next(chunks) for _ in range(100))
    return httpx2.Response(response.status_code, content=beginning)


def memory(pid: int, name: str) -> float:
    """Megabytes of a process in the kernel's counter of that name."""
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    return next(int(line.split()[1]) / 1e3 for line in lines if line.startswith(name))


def processor_seconds(pid: int) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def serve(data_dir: Path, listener: socket.socket) -> None:
    structlog.configure(wrapper_class=structlog.make_filtering_bound_logger(logging.WARNING))
    settings = Settings(data_dir=data_dir, token=SecretStr(TOKEN))
    app = create_app(settings, Store.open(settings.store_url), NoCluster())
    uvicorn.Server(uvicorn.Config(app, log_level="critical")).run(sockets=[listener])


def filled(settings: Settings, seeds: int) -> str:
    """Store the sweep, with its measurements directly in their table, and return its id."""
    store = Store.open(settings.store_url)
    weights = [Weights(0.01 * entry, 0.0) for entry in range(ENTRIES)]
    specs = [
        RunSpec("hybrid-ddpg", task, seed, pair, EVERY * POINTS)
        for task in TASKS
        for pair in weights
        for seed in range(seeds)
    ]
    for task in TASKS:
        store.record_random_return(RandomReturn(task, 1, -1000.0, -1010.0, -990.0, 1000))
    request = {
        "algorithms": [{"name": "hybrid-ddpg", "weights": [pair._asdict() for pair in weights]}],
        "environments": list(TASKS),
        "seeds": seeds,
    }
    versions = dict.fromkeys(TASKS, 1)
    sweep = store.create_sweep("large", 0, request, specs, environment_versions=versions)
    store.close()
    measure(settings)
    return sweep.id


def measure(settings: Settings) -> None:
    """Store all measurements of every run, faster than workers could."""
    rng = generator(0, "large sweep")
    engine = connect(settings.store_url, "writer")
    with engine.begin() as connection:
        numbers = list(connection.scalars(text("SELECT number FROM runs ORDER BY number")))
        for number in numbers:
            walk = rng.standard_normal(POINTS).cumsum()
            returns = (-1000 + 30 * walk + np.arange(POINTS)).tolist()
            taken = [(number, point(k, value)) for k, value in enumerate(returns, start=1)]
            measurements.add(connection, taken)
        connection.execute(
            text("UPDATE runs SET status = 'succeeded', timestep = timesteps, finished_at = 1.0")
        )
    engine.dispose()


def point(k: int, value: float) -> Measurement:
    return Measurement(
        seed=0,
        timestep=EVERY * k,
        return_mean=value,
        return_history=value - 1.0,
        updates=400 * k,
        jacobians=EVERY * k,
        seconds=0.07 * k + 1e-4 * value,
        diagnostics={"critic_loss": value},
        compile_seconds=0.25,
    )


if __name__ == "__main__":
    main()

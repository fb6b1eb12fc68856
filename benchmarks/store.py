"""The store: submitting, claiming and recording measurements, on SQLite and on PostgreSQL.

Everything is durable before it counts (`synchronous=FULL`, `fsync=on`). Recording measurements is
compared with the minimum work of any store: the driver's own `executemany` of the same rows into a
bare table, committed as often, in the same database and the same run. The best of several rounds
counts.

    python -m benchmarks.store [sqlite] [postgresql]
"""

import argparse
import statistics
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from algorithms.measurement import Measurement
from service.model.claim import Claim
from service.store.connection import connect
from service.store.reading import packed
from service.store.store import Store
from tests.service.store.postgresql import running_postgresql
from workers.messages.progress import Progress
from workers.messages.run_spec import COHORT_LIMIT, RunSpec, Weights

DATABASES = ("sqlite", "postgresql")
LEASE_SECONDS = 600.0
ROUNDS = 5
MESSAGES = 16  # of a cohort, each with POINTS measurements of every seed
POINTS = 16
DIAGNOSTICS = ("critic_loss", "actor_loss", "action_gradient_cosine", "state_gradient_cosine",
               "mean_q", "update_seconds")  # fmt: skip


def main() -> None:
    """Print every figure of the databases named on the command line."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("databases", nargs="*", default=DATABASES, metavar="|".join(DATABASES))
    asked = parser.parse_args().databases
    if "sqlite" in asked:
        with tempfile.TemporaryDirectory() as folder:
            measure("SQLite", f"sqlite:///{Path(folder) / 'd3pg.sqlite'}")
    if "postgresql" in asked:
        with running_postgresql("fsync=on") as server:
            measure("PostgreSQL", server.create("d3pg"))


def measure(name: str, url: str) -> None:
    """Measure one database, initially empty."""
    store = Store.open(url)
    report(f"{name}, submitting 10,000 runs", submit_seconds(store, 10_000), "s")
    report(f"{name}, claim with 10,000 runs queued", claim_milliseconds(store), "ms")
    for _ in range(5):
        submit_seconds(store, 20_000)
    report(f"{name}, claim with 110,000 runs queued", claim_milliseconds(store), "ms")
    ours = max(ingest_rate(store) for _ in range(ROUNDS))
    store.close()
    plain = max(plain_rate(url, place) for place in range(ROUNDS))
    report(f"{name}, measurements taken in", ours, "1/s")
    report(f"{name}, the same rows by plain executemany", plain, "1/s")
    report(f"{name}, taken in / plain executemany", ours / plain, "")


def submit_seconds(store: Store, runs: int) -> float:
    """The seconds until a sweep of `runs` runs is durable."""
    cells = runs // COHORT_LIMIT
    specs = [
        RunSpec("ddpg", "Pendulum", seed, Weights(float(cell)))
        for cell in range(cells)
        for seed in range(COHORT_LIMIT)
    ]
    begun = time.perf_counter()
    store.create_sweep("large", 0, {}, specs, environment_versions={"Pendulum": 1})
    return time.perf_counter() - begun


def claim_milliseconds(store: Store) -> float:
    """The median time of a claim of 16 runs."""
    durations = []
    for _ in range(20):
        begun = time.perf_counter()
        claimed(store)
        durations.append(time.perf_counter() - begun)
    return 1000 * statistics.median(durations)


def claimed(store: Store) -> Claim:
    claim = store.claim_cohort("benchmark", LEASE_SECONDS)
    assert claim is not None
    return claim


def messages(seeds: Sequence[int]) -> list[Progress]:
    """The messages of a cohort: measurements of all seeds, several per message."""
    return [
        Progress(
            800 * POINTS * (message + 1),
            measurements=tuple(
                point(seed, 800 * (POINTS * message + place + 1))
                for place in range(POINTS)
                for seed in seeds
            ),
        )
        for message in range(MESSAGES)
    ]


def point(seed: int, timestep: int) -> Measurement:
    values = dict.fromkeys(DIAGNOSTICS, timestep / 7)
    return Measurement(
        seed, timestep, -timestep / 3, -timestep / 9, timestep // 2, 3 * timestep, 1.0, values, 0.25
    )


def ingest_rate(store: Store) -> float:
    """Measurements per second that `record` makes durable, one message after the other."""
    claim = claimed(store)
    taken = messages([run.spec.seed for run in claim.runs])
    begun = time.perf_counter()
    for progress in taken:
        store.record(claim, progress)
    return count(taken) / (time.perf_counter() - begun)


def plain_rate(url: str, place: int) -> float:
    """The same rows, by the driver alone, into a table with only a key."""
    engine = connect(url, "writer")
    mark = "?" if engine.dialect.paramstyle == "qmark" else "%s"
    binary = "BLOB" if engine.dialect.name == "sqlite" else "BYTEA"
    try:
        with engine.begin() as connection:
            connection.exec_driver_sql(
                f"CREATE TABLE plain_{place} (run BIGINT, timestep BIGINT, mean DOUBLE PRECISION, "
                f"updates BIGINT, jacobians BIGINT, names BIGINT, packed {binary}, "
                "PRIMARY KEY (run, timestep))"
            )
        taken = messages(range(COHORT_LIMIT))
        insert = f"INSERT INTO plain_{place} VALUES ({', '.join([mark] * 7)})"  # noqa: S608
        begun = time.perf_counter()
        for progress in taken:
            with engine.begin() as connection:
                connection.exec_driver_sql(insert, [plain_row(m) for m in progress.measurements])
        return count(taken) / (time.perf_counter() - begun)
    finally:
        engine.dispose()


def plain_row(m: Measurement) -> tuple[Any, ...]:
    return (m.seed, m.timestep, m.return_mean, m.updates, m.jacobians, 1, packed.pack(m))


def count(taken: list[Progress]) -> int:
    return sum(len(progress.measurements) for progress in taken)


def report(name: str, value: float, unit: str) -> None:
    print(f"{name}: {value:,.3g} {unit}".rstrip(), flush=True)


if __name__ == "__main__":
    main()

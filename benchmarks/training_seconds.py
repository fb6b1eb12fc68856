"""Training seconds: tests whether a run's reported cost depends on other load on the machine.

The same run is trained repeatedly, each time in a new process that loads its kernels: on a quiet
machine, and beside a process that keeps another core, its caches and memory busy. Quiet and busy
rounds take turns, so that the machine's drift is the same in both.

    python -m benchmarks.training_seconds [ROUNDS]
"""

import json
import statistics
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

ROUNDS = 7
RUNS = (("hybrid-ddpg", "Pendulum", 12_000), ("sac", "CartPole", 6_000), ("gd", "Pendulum", 40_000))
BOUND_SECONDS = 120
"""Seconds, longer than a round: a neighbour outlives its benchmark by no more than this."""

TRAINING = """
import json, sys, algorithms
name, task, timesteps = json.loads(sys.argv[1])
*_, last = algorithms.train(name, task, [0], timesteps=timesteps)
print(json.dumps([last.seconds, last.compile_seconds]))
"""
NEIGHBOUR = """
import sys, time
import numpy as np
from threadpoolctl import threadpool_limits
end = time.monotonic() + float(sys.argv[1])
x = np.ones((1500, 1500))
print("busy", flush=True)
with threadpool_limits(1):
    while time.monotonic() < end:
        x = x @ x / 1500
"""


def main() -> None:
    """Print the seconds of each run, their spread, and the increase by the neighbour."""
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else ROUNDS
    for name, task, timesteps in RUNS:
        trained(name, task, timesteps)  # compiles the kernels, if they are not cached
        quiet, busy = [], []
        for _ in range(rounds):
            quiet.append(trained(name, task, timesteps))
            with busy_core():
                busy.append(trained(name, task, timesteps))
        tell(f"{name} on {task}, {timesteps:,} timesteps", quiet, busy)


def tell(run: str, quiet: list[tuple[float, float]], busy: list[tuple[float, float]]) -> None:
    seconds, beside = ([trained for trained, _ in each] for each in (quiet, busy))
    usual = statistics.median(seconds)
    report(f"{run}: training, median of {len(seconds)}", usual, "s")
    report(f"{run}: loading kernels", statistics.median(loaded for _, loaded in quiet), "s")
    report(f"{run}: training, farthest from its median", 100 * farthest(seconds, usual), "%")
    added = statistics.median(beside) / usual - 1
    report(f"{run}: training beside a busy core, median", 100 * added, "% more")
    report(f"{run}: the same, farthest", 100 * farthest(beside, usual), "%")


def farthest(values: list[float], centre: float) -> float:
    """The largest distance from the centre, relative to it."""
    return max(abs(value / centre - 1) for value in values)


def trained(name: str, task: str, timesteps: int) -> tuple[float, float]:
    """Train a run in a new process; return its seconds and those of its kernels."""
    command = [sys.executable, "-c", TRAINING, json.dumps([name, task, timesteps])]
    said = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)  # noqa: S603
    seconds, compile_seconds = json.loads(said.stdout)
    return seconds, compile_seconds


@contextmanager
def busy_core() -> Iterator[None]:
    """Run a neighbour that computes in this context; it ends if this process is killed."""
    command = [sys.executable, "-c", NEIGHBOUR, str(BOUND_SECONDS)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as neighbour:  # noqa: S603
        assert neighbour.stdout is not None
        neighbour.stdout.readline()
        try:
            yield
        finally:
            neighbour.kill()


def report(name: str, value: float, unit: str) -> None:
    print(f"{name}: {value:,.3g} {unit}", flush=True)


if __name__ == "__main__":
    main()

"""Physics: transitions per second of every task, compared with Gymnasium's and gymnax's tasks.

Ours are rollouts of random actions over `batch` rows, call by call through the public methods.
Every row that ended is reset to a start state, and all rows at the horizon (a die at rest costs
almost nothing). Gymnasium's are rollouts over as many environments, with its own resets; gymnax's
are whole rollouts in one jitted scan. All take turns in short rounds on one core, and the best
round of each counts: other programs can only slow one down.

The robots have their own benchmark with MuJoCo as peer: benchmarks/robots.py.
"""

import argparse
import importlib
import os
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

import physics
from benchmarks.peers.gymnasium_vector import gymnasium_step
from physics.catalogue import OWN
from physics.environment import Environment
from physics.randomness import generator

BATCHES = (1, 16)
# Our task -> Gymnasium's own, and the mode in which 16 of it run fastest, with its name.
GYMNASIUM = {
    "CartPole": ("CartPole-v1", "vector_entry_point", "native vector"),
    "Pendulum": ("Pendulum-v1", "sync", "SyncVectorEnv"),
    "MountainCar": ("MountainCarContinuous-v0", "sync", "SyncVectorEnv"),
    "Acrobot": ("Acrobot-v1", "sync", "SyncVectorEnv"),
}


class Contender(NamedTuple):
    """A function, and the number of transitions of a call."""

    name: str
    call: Callable[[], None]
    transitions: int


def best_rates(contenders: Sequence[Contender], seconds: float, rounds: int) -> list[float]:
    """Transitions per second in the best round of each; a round takes about `seconds`."""
    calls = []
    for contender in contenders:
        contender.call()
        start, count = time.perf_counter(), 0
        while time.perf_counter() - start < seconds:
            contender.call()
            count += 1
        calls.append(count)
    best = [0.0] * len(contenders)
    for _ in range(rounds):
        for index, (contender, count) in enumerate(zip(contenders, calls, strict=True)):
            start = time.perf_counter()
            for _ in range(count):
                contender.call()
            rate = contender.transitions * count / (time.perf_counter() - start)
            best[index] = max(best[index], rate)
    return best


def our_step(environment: Environment, batch: int, with_derivatives: bool) -> Callable[[], None]:
    """One step of one of our rollouts."""
    random = generator(0, "benchmark")
    starts = environment.initial_states(range(batch))
    actions = list(random.uniform(-1.0, 1.0, (64, batch, environment.action_size)))
    state, elapsed = starts, 0

    def step() -> None:
        nonlocal state, elapsed
        elapsed += 1
        if elapsed % environment.horizon == 0:
            state = starts.copy()
        if with_derivatives:
            transition = environment.differentiate(state, actions[elapsed % 64]).transition
        else:
            transition = environment.step(state, actions[elapsed % 64])
        state = transition.next_state
        if np.count_nonzero(transition.terminated):
            np.copyto(state, starts, where=transition.terminated[:, None])

    return step


def peers(name: str, batch: int, gymnax: Any) -> Iterator[Contender]:
    """The peers that have the task of that name."""
    if name not in GYMNASIUM:
        return
    peer, mode, label = GYMNASIUM[name]
    yield Contender(f"Gymnasium's {label}", gymnasium_step(peer, batch, mode), batch)
    if gymnax is not None:
        yield Contender("gymnax's jitted scan", *gymnax.gymnax_rollout(peer, batch))


def find_gymnax() -> Any:
    """The module that runs gymnax, or None if gymnax is not installed."""
    try:
        return importlib.import_module("benchmarks.peers.gymnax_rollout")
    except ModuleNotFoundError as error:
        print(f"gymnax: not installed ({error}); `make bench` installs it")
        return None


def report(name: str, value: float, unit: str) -> None:
    print(f"{name}: {value:,.4g} {unit}" if value < 1e4 else f"{name}: {value:,.0f} {unit}")


def measure(name: str, batch: int, others: Sequence[Contender], arguments: Any) -> None:
    """Print the rates of one task in one batch size, and how they compare."""
    environment, label = physics.make(name), f"{name}, batch {batch}"
    ours = [
        Contender("step", our_step(environment, batch, False), batch),
        Contender("differentiate", our_step(environment, batch, True), batch),
    ]
    rates = best_rates([*ours, *others], arguments.seconds, arguments.rounds)
    stepping, differentiating, *theirs = rates
    for contender, rate in zip([*ours, *others], rates, strict=True):
        report(f"{label}, {contender.name}", rate, "transitions/s")
    report(f"{label}, a step with its derivatives", 1e6 / differentiating, "us")
    report(f"{label}, differentiate takes", stepping / differentiating, "x step")
    for other, rate in zip(others, theirs, strict=True):
        report(f"{label}, step over {other.name}", stepping / rate, "x")
        report(f"{label}, differentiate over {other.name}", differentiating / rate, "x")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", default=list(OWN), help="tasks (default: our own)")
    parser.add_argument("--seconds", type=float, default=0.01, help="length of a round")
    parser.add_argument("--rounds", type=int, default=100)
    arguments = parser.parse_args()
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    gymnax = find_gymnax()
    for name in arguments.names:
        report(f"{name}, compiling or loading", physics.make(name).compile(), "s")
        for batch in BATCHES:
            measure(name, batch, list(peers(name, batch, gymnax)), arguments)


if __name__ == "__main__":
    main()

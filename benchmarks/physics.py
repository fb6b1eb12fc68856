"""Physics: transitions a second of every task, beside Gymnasium's own classic tasks.

Ours are rollouts of random actions over `batch` rows, through the public methods, with every row
that ended put back to a start state, and all of them at the horizon (a die that has come to rest
costs next to nothing); Gymnasium's are rollouts of random actions over as many environments, with
its own resets. The best of several rounds counts: other programs can only slow one down. Run with
`OMP_NUM_THREADS=1` or without: nothing here uses a second thread.
"""

import argparse
import time
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np

import physics
from physics.environment import Environment
from physics.randomness import generator

BATCHES = (1, 16)
ROUNDS = 7
# Our task -> Gymnasium's own, and how it runs 16 at a time fastest.
PEERS = {
    "CartPole": ("CartPole-v1", "vector_entry_point"),
    "Pendulum": ("Pendulum-v1", "sync"),
    "MountainCar": ("MountainCarContinuous-v0", "sync"),
    "Acrobot": ("Acrobot-v1", "sync"),
}

Action = Any
OneStep = Callable[[], None]


def best_rate(step: OneStep, transitions: int, seconds: float) -> float:
    """Transitions a second of the best round, each of about `seconds`."""
    step()
    start, calls = time.perf_counter(), 0
    while time.perf_counter() - start < seconds:
        step()
        calls += 1
    durations = []
    for _ in range(ROUNDS):
        start = time.perf_counter()
        for _ in range(calls):
            step()
        durations.append(time.perf_counter() - start)
    return transitions * calls / min(durations)


def our_step(environment: Environment, batch: int, with_derivatives: bool) -> OneStep:
    """One step of a rollout of ours."""
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
            state[transition.terminated] = starts[transition.terminated]

    return step


def peer_step(name: str, batch: int, mode: str) -> OneStep:
    """One step of a rollout of Gymnasium's."""
    peer: Any = gymnasium.make_vec(name, num_envs=batch, vectorization_mode=mode)
    peer.reset(seed=0)
    peer.action_space.seed(0)
    actions = [peer.action_space.sample() for _ in range(64)]
    turn = 0

    def step() -> None:
        nonlocal turn
        turn = (turn + 1) % 64
        peer.step(actions[turn])

    return step


def report(name: str, value: float, unit: str) -> None:
    print(f"{name}: {value:,.4g} {unit}" if value < 1e4 else f"{name}: {value:,.0f} {unit}")


def measure(name: str, seconds: float) -> None:
    environment = physics.make(name)
    report(f"{name}, compiling or loading", environment.compile(), "s")
    for batch in BATCHES:
        stepping = best_rate(our_step(environment, batch, False), batch, seconds)
        differentiating = best_rate(our_step(environment, batch, True), batch, seconds)
        report(f"{name}, batch {batch}, step", stepping, "transitions/s")
        report(f"{name}, batch {batch}, differentiate", differentiating, "transitions/s")
        report(f"{name}, batch {batch}, differentiate over step", stepping / differentiating, "x")
        if name in PEERS:
            peer, mode = PEERS[name]
            theirs = best_rate(peer_step(peer, batch, mode), batch, seconds)
            label = "native vector" if mode == "vector_entry_point" else "SyncVectorEnv"
            report(f"Gymnasium {peer} ({label}), batch {batch}", theirs, "transitions/s")
            report(f"{name}, batch {batch}, step over Gymnasium", stepping / theirs, "x")
            report(
                f"{name}, batch {batch}, differentiate over Gymnasium",
                differentiating / theirs,
                "x",
            )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", default=physics.names(), help="tasks (default: all)")
    parser.add_argument("--seconds", type=float, default=0.2, help="length of a round")
    arguments = parser.parse_args()
    for name in arguments.names:
        measure(name, arguments.seconds)


if __name__ == "__main__":
    main()
